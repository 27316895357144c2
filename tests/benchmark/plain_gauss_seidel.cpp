// The chain of solve_friction beside a plain Gauss-Seidel, on files: CPU milliseconds to a relative residual of 1e-10, medians of five by
// turns, sweeps, and the ratio.
//   plain_gauss_seidel FILE...
#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>

#include "../../src/solve/friction_stages.hpp"
#include "../../src/solve/global_form.hpp"
#include "perp/solve/friction_io.hpp"
#include "perp/solve/friction_solver.hpp"

using namespace perp;

namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Sweeps until the residual is 1e-10, at most `most`; how many. Velocities are kept up to date: u = Hᵀ v + w with v += Y dr, Y = M^-1 H,
/// or, in the local form, u = r W + q with H = 1, Y = W.
int plain_gauss_seidel(const FrictionProblem& problem, int most, Vector& r) {
  const bool global = problem.is_global();
  const Eigen::Index m = problem.rows();
  SparseMatrix H(m, m), Y;
  Vector v = problem.q, w = Vector::Zero(m), lambda;
  if (global) {
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
  std::vector<Matrix3> D;
  for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
    Matrix3& own = D.emplace_back(Matrix3::Zero());
    const Eigen::Index n = offsets[i + 1] - offsets[i], first = first_row(problem.kind(i));
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index k = 0; k < n; ++k)
        own(first + j, first + k) = H.col(offsets[i] + j).dot(Y.col(offsets[i] + k));
  }
  r = Vector::Zero(m);
  for (int sweep = 1; sweep <= most; ++sweep) {
    for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
      const Eigen::Index o = offsets[i], n = offsets[i + 1] - o, first = first_row(problem.kind(i));
      Vector3 p = Vector3::Zero(), u = Vector3::Zero();
      for (Eigen::Index j = 0; j < n; ++j)
        p[first + j] = r[o + j], u[first + j] = H.col(o + j).dot(v) + w[o + j];
      const double size = std::max(D[static_cast<std::size_t>(i)].trace(), 1e-300) / static_cast<double>(n);
      const Matrix3 W = D[static_cast<std::size_t>(i)] / size;
      const Vector3 next = solve_one_contact(problem.kind(i), problem.mu[i], W, u / size - W * p, p);
      for (Eigen::Index j = 0; j < n; ++j)
        if (const double dr = next[first + j] - r[o + j]; dr != 0) v += dr * Y.col(o + j), r[o + j] += dr;
    }
    if (sweep % 10 == 0 && friction_residual(problem, r).relative <= 1e-10) return sweep;
  }
  return most;
}

}  // namespace

int main(int argc, char** argv) {
  std::printf("%-40s %9s %11s %7s %9s %11s %-15s %6s\n", "file", "contacts", "sweeps ms", "sweeps",
              "residual", "chain ms", "stage", "ratio");
  for (int k = 1; k < argc; ++k) {
    const FrictionProblem problem = read_friction_problem(argv[k]);
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
    const std::string path = argv[k];
    std::printf("%-40s %9ld %11.3f %7d %9.1e %11.3f %-15s %6.2f\n", path.substr(path.rfind('/') + 1).c_str(),
                long{problem.blocks()}, plain[2], sweeps, friction_residual(problem, r).relative, chain[2],
                std::string(s.solved() ? to_string(s.stage) : "not solved").c_str(), chain[2] / plain[2]);
  }
}
