// The chain of solve_friction beside a plain Gauss-Seidel: CPU milliseconds to a relative residual of 1e-10, medians of five by turns,
// sweeps, and the ratio of the two.
//   plain_gauss_seidel FILE...
//   plain_gauss_seidel --discs SEED COUNT    COUNT piles of discs in the plane, in the reduced form
#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "../../src/solve/friction/friction_stages.hpp"
#include "../../src/solve/friction/global_form.hpp"
#include "perp/solve/friction_io.hpp"
#include "perp/solve/friction_solver.hpp"
#include "tests/solve/friction_examples.hpp"

using namespace perp;

namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Sweeps until the residual is 1e-10, at most `most`; how many. Velocities are kept up to date: u = Hᵀ v + w, v += Y dr, Y = M^-1 H, or, in
/// the local form, H = 1, Y = W.
int plain_gauss_seidel(const FrictionProblem& problem, int most, Vector& r) {
  const Eigen::Index m = problem.rows(), n = problem.blocks();
  SparseMatrix H(m, m), Y;
  Vector v = problem.q, w = Vector::Zero(m), lambda;
  if (problem.is_global()) {
    const MassResponse response(problem);
    H = problem.H.to_sparse();
    Y = response.times(H);
    response.velocity(problem.f, v, lambda);
    w = problem.w;
  } else {
    H.setIdentity();
    Y = problem.W.to_sparse();
  }
  const std::vector<Eigen::Index> offsets = problem.offsets();
  std::vector<Matrix3> D(static_cast<std::size_t>(n), Matrix3::Zero());
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = offsets[i]; j < offsets[i + 1]; ++j)
      for (Eigen::Index k = offsets[i]; k < offsets[i + 1]; ++k)
        D[i](j - offsets[i], k - offsets[i]) = H.col(j).dot(Y.col(k));
  std::vector<Block<3>> blocks;
  for (Eigen::Index i = 0; i < n; ++i) blocks.push_back(make_block<3>(problem, i));
  r = Vector::Zero(m);
  double moved = 0, goal = 1e-11;
  for (int sweep = 1; sweep <= most; ++sweep, moved = 0) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index o = offsets[i], rows = offsets[i + 1] - o;
      Vector3 p = Vector3::Zero(), u = Vector3::Zero();
      for (Eigen::Index j = 0; j < rows; ++j) p[j] = r[o + j], u[j] = H.col(o + j).dot(v) + w[o + j];
      const Vector3 next = solve_one_contact<3>(blocks[i], D[i], u - D[i] * p, p);
      for (Eigen::Index j = 0; j < rows; ++j) {
        const double dr = next[j] - p[j];
        if (dr == 0) continue;
        v += dr * Y.col(o + j);
        r[o + j] = next[j];
        moved = std::max(moved, std::abs(dr));
      }
    }
    if (moved > goal * r.lpNorm<Eigen::Infinity>()) continue;
    if (friction_residual(problem, r).relative <= 1e-10) return sweep;
    goal /= 2;
  }
  return most;
}

}  // namespace

int main(int argc, char** argv) {
  std::printf("%-40s %9s %11s %7s %9s %11s %-15s %6s\n", "file", "contacts", "sweeps ms", "sweeps",
              "residual", "chain ms", "stage", "ratio");
  std::vector<std::pair<std::string, FrictionProblem>> problems;
  const std::string first = argc > 1 ? argv[1] : "";
  if (argc == 4 && first == "--discs")
    for (int k = 0; k < std::stoi(argv[3]); ++k)
      problems.emplace_back("discs " + std::to_string(k),
                            disc_pile(static_cast<unsigned>(std::stoi(argv[2]) + k)));
  else
    for (int k = 1; k < argc; ++k) {
      const std::string path = argv[k];
      problems.emplace_back(path.substr(path.rfind('/') + 1), read_friction_problem(path));
    }
  for (const auto& [name, problem] : problems) {
    std::array<double, 5> plain{}, chain{};
    Vector r;
    int sweeps = 0;
    FrictionSolution s;
    for (std::size_t run = 0; run < plain.size(); ++run) {
      double begin = cpu_seconds();
      sweeps = plain_gauss_seidel(problem, 5000, r);
      plain[run] = 1e3 * (cpu_seconds() - begin);
      begin = cpu_seconds();
      s = solve_friction(problem);
      chain[run] = 1e3 * (cpu_seconds() - begin);
    }
    std::sort(plain.begin(), plain.end());
    std::sort(chain.begin(), chain.end());
    std::printf("%-40s %9ld %11.3f %7d %9.1e %11.3f %-15s %6.2f\n", name.c_str(), long{problem.blocks()},
                plain[2], sweeps, friction_residual(problem, r).relative, chain[2],
                std::string(s.solved() ? to_string(s.stage) : "not solved").c_str(), chain[2] / plain[2]);
  }
}
