#include <algorithm>
#include <cmath>

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

bool is_regular(const Matrix& W, const Vector& scale) {
  Eigen::ColPivHouseholderQR<Matrix> qr(W.rows(), W.cols());
  qr.setThreshold(1e-12);  // as VanishingCompliance
  qr.compute(scale.cwiseInverse().asDiagonal() * W * scale.cwiseInverse().asDiagonal());
  return qr.rank() == W.rows();
}

}  // namespace

FrictionSolution solve_evenly(const FrictionProblem& problem, const Matrix& C, const Vector& k,
                              const FrictionOptions& options) {
  constexpr double slight = 1e-7;  // of what reactions do to their own rows [-]
  constexpr int most_rounds = 3;   // each gains a factor of about `slight`
  if (problem.rows() == 0) return solve_friction(problem, options);
  const Matrix W = problem.W.to_dense();
  const Vector weight = W.diagonal().cwiseAbs().cwiseMax(1e-300 + 1e-14 * W.diagonal().cwiseAbs().maxCoeff());
  if (is_regular(W, weight.cwiseSqrt())) return solve_friction(problem, options);
  const double eps = slight * std::exp((weight.array() / C.diagonal().array().abs()).log().mean());

  // rows that give, then with what they give taken back
  FrictionProblem soft = problem;
  soft.W = Matrix(W + eps * C);
  soft.q = problem.q + eps * k;
  FrictionOptions how = options;
  FrictionSolution near;
  for (int round = 0; round < most_rounds; ++round) {
    near = solve_friction(soft, how);
    if (!near.solved()) return solve_friction(problem, options);
    how.start = near.r;
    soft.q = problem.q - eps * (C * near.r);
  }
  how.start = near.r;
  FrictionSolution even = solve_friction(problem, how);

  // in the modes found, exactly
  const TiedRows tied = tie(problem, near.r, weight);
  VanishingCompliance limit;
  Vector y;
  const Vector scale = (tied.Q.transpose() * weight).cwiseSqrt();
  const VanishingCompliance::Outcome outcome =
      limit.solve(tied.Q.transpose() * W * tied.P, tied.Q.transpose() * (problem.q + W * tied.known),
                  tied.Q.transpose() * C * tied.P, tied.Q.transpose() * (k + C * tied.known), scale, y);
  using Outcome = VanishingCompliance::Outcome;
  if (outcome == Outcome::None || outcome == Outcome::Several) return even;
  FrictionSolution exact = near;
  exact.r = tied.P * y + tied.known;
  exact.u = W * exact.r + problem.q;
  exact.residuals = friction_residual(problem, exact.r);
  exact.residual = exact.residuals.relative;
  exact.iterations += even.iterations;
  if (!(exact.residual <= options.tolerance)) return even;
  return exact;
}

}  // namespace perp
