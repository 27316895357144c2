#include "even_friction.hpp"

#include <cmath>
#include <Eigen/QR>

#include "vanishing_compliance.hpp"

namespace perp {
namespace {

/// The unknowns of a problem's modes: r = P y + known, and the rows of u that are zero are those of Qᵀ.
struct TiedRows {
  Matrix P, Q;
  Vector known;
};

/// Modes by reactions r: open, at the side of the cone (with its friction tied to the normal reaction) or inside.
TiedRows tie(const FrictionProblem& problem, const Vector& r, const Vector& weight) {
  constexpr double at_side = 1e-9,
                   unloaded = 1e-10;  // of the bound of friction; of the largest reaction as a velocity
  const std::vector<Eigen::Index> first = problem.offsets();
  const double zero = unloaded * (weight.array() * r.array().abs()).maxCoeff();
  const Eigen::Index m = problem.rows();
  TiedRows tied{Matrix::Zero(m, m), Matrix::Zero(m, m), Vector::Zero(m)};
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
    const Eigen::Index row = first[static_cast<std::size_t>(i)];
    const BlockKind kind = problem.kind(i);
    const Eigen::Index tangents = block_rows(kind) - 1;
    if (kind == BlockKind::Interval) {
      if (std::abs(r[row]) >= problem.mu[i] * (1 - at_side)) {
        tied.known[row] = r[row] > 0 ? problem.mu[i] : -problem.mu[i];
      } else {
        tied.P(row, n) = tied.Q(row, n) = 1;
        ++n;
      }
      continue;
    }
    if (!(weight[row] * r[row] > zero)) continue;
    tied.P(row, n) = tied.Q(row, n) = 1;
    const auto friction = r.segment(row + 1, tangents);
    const double size = friction.norm(), bound = tangents > 0 ? problem.mu[i] * r[row] : 0;
    const bool slides = tangents > 0 && size >= bound * (1 - at_side);
    if (slides && size > 0) tied.P.col(n).segment(row + 1, tangents) = problem.mu[i] / size * friction;
    ++n;
    for (Eigen::Index t = 1; !slides && t <= tangents; ++t, ++n) tied.P(row + t, n) = tied.Q(row + t, n) = 1;
  }
  tied.P.conservativeResize(Eigen::NoChange, n);
  tied.Q.conservativeResize(Eigen::NoChange, n);
  return tied;
}

/// Whether no rows repeat each other, as directions 1e-6 rad apart do, squared by W = Gᵀ M^-1 G.
bool is_regular(const Matrix& W, const Vector& scale) {
  Eigen::ColPivHouseholderQR<Matrix> qr(W.rows(), W.cols());
  qr.setThreshold(1e-12);
  qr.compute(scale.cwiseInverse().asDiagonal() * W * scale.cwiseInverse().asDiagonal());
  return qr.rank() == W.rows();
}

}  // namespace

FrictionSolution solve_evenly(const FrictionProblem& problem, const Matrix& C, const Vector& k,
                              const FrictionOptions& options) {
  constexpr double slight = 1e-7;  // of what reactions do to their own rows [-]
  if (problem.rows() == 0) return solve_friction(problem, options);
  const Matrix W = problem.W.to_dense();
  const Vector weight = W.diagonal().cwiseAbs().cwiseMax(1e-300 + 1e-14 * W.diagonal().cwiseAbs().maxCoeff());
  if (is_regular(W, weight.cwiseSqrt())) return solve_friction(problem, options);
  const double eps = slight * std::exp((weight.array() / C.diagonal().array().abs()).log().mean());
  FrictionProblem soft = problem;
  soft.W = Matrix(W + eps * C);
  soft.q = problem.q + eps * k;
  const FrictionSolution near = solve_friction(soft, options);
  if (!near.solved()) return solve_friction(problem, options);

  // in the modes found, exactly
  const TiedRows tied = tie(problem, near.r, weight);
  VanishingCompliance limit;
  Vector y;
  const auto Q = tied.Q.transpose();
  const auto outcome = limit.solve(Q * W * tied.P, Q * (problem.q + W * tied.known), Q * C * tied.P,
                                   Q * (k + C * tied.known), (Q * weight).cwiseSqrt(), y);
  if (outcome == VanishingCompliance::Outcome::Found) {
    FrictionSolution exact = near;
    exact.r = tied.P * y + tied.known;
    exact.u = W * exact.r + problem.q;
    exact.residuals = friction_residual(problem, exact.r);
    exact.residual = exact.residuals.relative;
    if (exact.residual <= options.tolerance) return exact;
  }
  FrictionOptions how = options;
  how.start = near.r;
  FrictionSolution beside = solve_friction(problem, how);
  beside.iterations += near.iterations;
  return beside;
}

}  // namespace perp
