#include "solve/lcp/lcp_ways.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <Eigen/QR>
#include <utility>
#include <vector>

#include "perp/solve/lemke.hpp"
#include "perp/solve/linear_feasibility.hpp"

namespace perp {
namespace {

using Indices = std::vector<Eigen::Index>;

// Uniform in (0, 1): a linear congruence (Knuth's MMIX constants), the same on every machine.
class Draw {
 public:
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return (static_cast<double>(state_ >> 12) + 0.5) * 0x1p-52;
  }

 private:
  std::uint64_t state_ = 1;
};

bool accept(const Lcp& lcp, const LcpOptions& options, Vector z, std::string_view stage, LcpSolution& out) {
  if (!(lcp_relative_residual(lcp.A, lcp.b, z) <= options.tolerance)) return false;
  out.status = LcpStatus::Solved;
  out.z = std::move(z);
  out.residual = lcp_residual(lcp.A, lcp.b, out.z);
  out.stage = stage;
  return true;
}

// The z with w_i = 0 for i in basis and z_i = 0 elsewhere; of several the shortest.
Vector basic_solution(const Lcp& lcp, const Indices& basis) {
  Vector z = Vector::Zero(lcp.b.size());
  if (basis.empty()) return z;
  const Matrix A = lcp.A(basis, basis);
  const Vector b = lcp.b(basis);
  const Eigen::CompleteOrthogonalDecomposition<Matrix> factors(A);
  Vector x = factors.solve(-b);
  x -= factors.solve(A * x + b);
  z(basis) = x.cwiseMax(0.0);
  return z;
}

}  // namespace

void try_covering_vectors(const Lcp& lcp, const LcpOptions& options, LcpSolution& out) {
  constexpr int tries = 8;
  Draw draw;
  for (int k = 0; k < tries; ++k) {
    Vector d(lcp.b.size());
    for (double& d_i : d) d_i = std::exp2(4 * draw() - 2);
    LcpSolution attempt;
    LemkeSolver(
        {.max_pivots = options.max_pivots, .tolerance = options.tolerance, .covering = d, .restarts = 2})
        .solve(lcp.A, lcp.b, attempt);
    out.pivots += attempt.pivots;
    if (!attempt.solved() && attempt.status != LcpStatus::NoSolution) continue;
    attempt.pivots = out.pivots;
    attempt.stage = "covering vectors";
    out = attempt;
    return;
  }
}

namespace {

// A problem with some z_i = 0 and some w_i = 0 chosen, the rest open.
struct Choice {
  std::vector<char> closed;  // per pair: 0 open, 'z' z_i = 0, 'w' w_i = 0
};

// The linear relaxation: z >= 0, w >= 0, and the chosen ones zero; z of the columns that are not chosen zero.
FeasibilityAnswer relax(const Lcp& lcp, const Choice& choice, const Vector& cost) {
  const auto n = lcp.b.size();
  Indices columns, tight;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (choice.closed[static_cast<size_t>(i)] != 'z') columns.push_back(i);
    if (choice.closed[static_cast<size_t>(i)] == 'w') tight.push_back(i);
  }
  const auto k = static_cast<Eigen::Index>(columns.size()), t = static_cast<Eigen::Index>(tight.size());
  Matrix A(n + t, k);
  Vector b(n + t);
  A << lcp.A(Eigen::all, columns), -lcp.A(tight, columns);
  b << lcp.b, -lcp.b(tight);
  FeasibilityAnswer answer = find_feasible(A, b, cost(columns));
  if (answer.status == Feasibility::Feasible) {
    Vector z = Vector::Zero(n);
    z(columns) = answer.z;
    answer.z = z;
  }
  return answer;
}

}  // namespace

void try_branches(const Lcp& lcp, const LcpOptions& options, int max_nodes, LcpSolution& out) {
  const auto n = lcp.b.size();
  const Vector cost = Vector::Ones(n);
  std::vector<Choice> open{{std::vector<char>(static_cast<size_t>(n), 0)}};
  bool complete = true;
  for (int node = 0; !open.empty(); ++node) {
    if (node == max_nodes) return;
    Choice choice = std::move(open.back());
    open.pop_back();
    const FeasibilityAnswer relaxed = relax(lcp, choice, cost);
    out.pivots += relaxed.pivots;
    if (relaxed.status == Feasibility::Infeasible) continue;

    Vector z = relaxed.status == Feasibility::Feasible ? relaxed.z : Vector::Zero(n);
    const Vector w = lcp.A * z + lcp.b;
    Indices basis;
    Eigen::Index worst = -1;
    double largest = -1;
    for (Eigen::Index i = 0; i < n; ++i) {
      const char closed = choice.closed[static_cast<size_t>(i)];
      if (closed == 'w' || (closed == 0 && z[i] > w[i])) basis.push_back(i);
      if (closed == 0 && std::min(z[i], w[i]) > largest) largest = std::min(z[i], w[i]), worst = i;
    }
    if (accept(lcp, options, basic_solution(lcp, basis), "branches", out)) return;
    Vector relaxed_z = Vector::Zero(n);  // the basis may be singular, and the relaxation right
    relaxed_z(basis) = z(basis);
    if (accept(lcp, options, relaxed_z, "branches", out)) return;
    if (worst < 0) {  // all chosen, and neither a solution nor ruled out
      complete = false;
      continue;
    }
    const bool w_first = z[worst] > w[worst];
    for (const bool first : {false, true}) {  // what is pushed last is looked at first
      Choice next = choice;
      next.closed[static_cast<size_t>(worst)] = w_first == first ? 'w' : 'z';
      open.push_back(std::move(next));
    }
  }
  if (!complete) return;
  out.status = LcpStatus::Exhausted;
  out.stage = "branches";
}

}  // namespace perp
