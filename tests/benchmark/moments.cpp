// moments [SEED] [COUNT]: members of the families with torsion and rolling, and the same members without their moments' rows:
// how many are solved to 1e-10 by the chain, by what, and in what time.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <Eigen/Dense>
#include <map>
#include <string>
#include <vector>

#include "perp/solve/friction_solver.hpp"
#include "perp/study/friction_families.hpp"

using namespace perp;

namespace {

FrictionProblem without_moments(FrictionProblem p) {
  const std::vector<Eigen::Index> first = p.offsets();
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < p.blocks(); ++i)
    for (Eigen::Index k = 0; k < 3; ++k) kept.push_back(first[static_cast<std::size_t>(i)] + k);
  const Matrix H = p.H.to_dense();
  p.H = SparseMatrix(Matrix(H(Eigen::all, kept)).sparseView());
  p.w = Vector(p.w(kept));
  p.kinds.assign(p.kinds.size(), BlockKind::Cone);
  return p;
}

struct Tally {
  int solved = 0;
  std::vector<double> milliseconds;
  std::map<std::string, int> stages;

  void add(const FrictionProblem& problem) {
    const std::clock_t begin = std::clock();
    const FrictionSolution s = solve_friction(problem, {.use_ipopt = false});
    milliseconds.push_back(1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    solved += s.solved();
    ++stages[s.solved() ? std::string(to_string(s.stage)) : std::string(to_string(s.status))];
  }
  void print(const std::string& name) {
    std::sort(milliseconds.begin(), milliseconds.end());
    const auto at = [&](double share) {
      return milliseconds[static_cast<std::size_t>(share * static_cast<double>(milliseconds.size() - 1))];
    };
    std::printf("| %s | %d/%zu | %.3f | %.3f | %.0f |", name.c_str(), solved, milliseconds.size(), at(0.5),
                at(0.9), at(1));
    for (const auto& [stage, count] : stages) std::printf(" %s %d", stage.c_str(), count);
    std::printf(" |\n");
    std::fflush(stdout);
  }
};

}  // namespace

int main(int argc, char** argv) {
  const auto seed = static_cast<std::uint64_t>(argc > 1 ? std::atoll(argv[1]) : 2026);
  const int count = argc > 2 ? std::atoi(argv[2]) : 200;
  std::printf("| family | solved | median ms | p90 ms | most ms | by |\n|---|---|---|---|---|---|\n");
  for (const char* family : {"torsion", "rolling", "twist"}) {
    Tally with, without;
    for (int i = 0; i < count; ++i) {
      const FrictionProblem problem = friction_family(family, seed, i);
      with.add(problem);
      without.add(without_moments(problem));
    }
    with.print(family);
    without.print(std::string(family) + ", moments left out");
  }
}
