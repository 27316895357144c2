#include <algorithm>
#include <string>

#include "perp/core/errors.hpp"
#include "perp/solve/lemke.hpp"
#include "perp/solve/linear_feasibility.hpp"
#include "solve/lcp/lcp_ways.hpp"
#include "solve/linear/equilibrate.hpp"

namespace perp {
namespace {

void check(const Lcp& lcp) {
  const std::string n = std::to_string(lcp.b.size());
  if (lcp.A.rows() != lcp.b.size() || lcp.A.cols() != lcp.b.size())
    refuse("lcp", "A", "(" + std::to_string(lcp.A.rows()) + ", " + std::to_string(lcp.A.cols()) + ")",
           "(" + n + ", " + n + ") is needed for b of size " + n);
  if (!lcp.A.allFinite()) refuse("lcp", "A", "not finite", "finite entries are needed");
  if (!lcp.b.allFinite()) refuse("lcp", "b", "not finite", "finite entries are needed");
}

Lcp scaled_by(const Scaling& scaling, const Lcp& lcp) {
  return {scaling.apply(lcp.A), scaling.r.cwiseProduct(lcp.b)};
}

// Takes a scaled problem's answer back to the units of the data.
void unscale(const Lcp& lcp, const Scaling& scaling, LcpSolution& solution) {
  solution.z = scaling.c.cwiseProduct(solution.z);
  if (solution.certificate.size() > 0) solution.certificate = scaling.r.cwiseProduct(solution.certificate);
  solution.residual = lcp_residual(lcp.A, lcp.b, solution.z);
}

bool decided(const LcpSolution& solution) {
  return solution.solved() || solution.status == LcpStatus::NoSolution;
}

// The linear part alone: where z >= 0, A z + b >= 0 cannot be met, (1) cannot.
void try_certificate(const Lcp& lcp, LcpSolution& out) {
  const FeasibilityAnswer answer = find_feasible(lcp.A, lcp.b, Vector::Ones(lcp.b.size()));
  out.pivots += answer.pivots;
  if (answer.status != Feasibility::Infeasible || !proves_no_solution(lcp.A, lcp.b, answer.y)) return;
  out.status = LcpStatus::NoSolution;
  out.certificate = answer.y;
  out.stage = "certificate";
}

}  // namespace

LcpSolution lemke(const Lcp& lcp, const LemkeOptions& options) {
  check(lcp);
  const Scaling scaling = equilibrate(lcp.A, true);
  const Lcp scaled = scaled_by(scaling, lcp);
  LemkeOptions scaled_options = options;
  if (options.covering.size() == lcp.b.size())
    scaled_options.covering = scaling.r.cwiseProduct(options.covering);
  LcpSolution solution;
  LemkeSolver(scaled_options).solve(scaled.A, scaled.b, solution);
  unscale(lcp, scaling, solution);
  return solution;
}

LcpSolution solve_lcp(const Lcp& lcp, const LcpOptions& options) {
  check(lcp);
  constexpr int restarts = 4;
  constexpr double max_nodes = 3000, max_work = 2e10;  // relaxations; multiplications in all of them, about
  const double n = static_cast<double>(std::max<Eigen::Index>(lcp.b.size(), 1));
  const int nodes = static_cast<int>(std::min(max_nodes, 1 + max_work / (8 * n * n * n)));
  const Scaling symmetric = equilibrate(lcp.A, true);
  const Lcp balanced = scaled_by(symmetric, lcp);
  LcpSolution solution;
  LemkeSolver({.max_pivots = options.max_pivots, .tolerance = options.tolerance})
      .solve(balanced.A, balanced.b, solution);
  try_polish(balanced, options, solution);
  if (decided(solution)) {
    unscale(lcp, symmetric, solution);
    return solution;
  }

  const Scaling scaling = equilibrate(lcp.A, false);
  const Lcp scaled = scaled_by(scaling, lcp);
  const int pivots = solution.pivots;
  LemkeSolver({.max_pivots = options.max_pivots, .tolerance = options.tolerance, .restarts = restarts})
      .solve(scaled.A, scaled.b, solution);
  solution.stage = "lemke, equilibrated";
  solution.pivots += pivots;
  try_polish(scaled, options, solution);
  if (!decided(solution)) try_certificate(scaled, solution);
  if (!decided(solution)) try_covering_vectors(scaled, options, solution);
  if (!decided(solution)) try_branches(scaled, options, nodes, solution);
  unscale(lcp, scaling, solution);
  return solution;
}

}  // namespace perp
