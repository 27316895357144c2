#include "solve/friction/even_friction.hpp"

#include <cmath>
#include <Eigen/QR>

#include "solve/blocks/block.hpp"
#include "solve/friction/vanishing_compliance.hpp"

namespace perp {
namespace {

/// The unknowns of a problem's modes: r = P y + known, and the rows of u that are zero are those of Qᵀ.
struct TiedRows {
  Matrix P, Q;
  Vector known;
};

/// A group's friction over the normal reaction that it needs to be at its bound: r_g = ray n. Zero rows where the group pushes nothing.
struct Bound {
  double n;
  Vector3 ray;
};

Bound bound_of(const Vector3& axes, const Vector3& r) {
  const double longest = axes.maxCoeff(), size = r.norm();
  if (!(longest > 0) || size == 0) return {0, Vector3::Zero()};
  if ((axes.array() == longest || axes.array() == 0).all()) return {size / longest, longest / size * r};
  const double gauge = ellipsoid_gauge(axes, r);
  return {gauge, r / gauge};
}

/// Modes by reactions r: open, at the side of the cone (with its friction tied to the normal reaction) or inside; each group of rows for itself.
TiedRows tie(const FrictionProblem& problem, const Vector& r, const Vector& weight) {
  constexpr double at_side = 1e-9,
                   unloaded = 1e-10;  // of the bound of friction; of the largest reaction as a velocity
  const std::vector<Eigen::Index> first = problem.offsets();
  const double zero = unloaded * (weight.array() * r.array().abs()).maxCoeff();
  const Eigen::Index m = problem.rows();
  TiedRows tied{Matrix::Zero(m, m), Matrix::Zero(m, m), Vector::Zero(m)};
  Eigen::Index n = 0;
  const auto free = [&](Eigen::Index row) { tied.P(row, n) = tied.Q(row, n) = 1, ++n; };
  for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
    const BlockLayout& layout = layout_of(problem.kind(i));
    const Block<6> block = make_block<6>(problem, i);
    const Eigen::Index row = first[static_cast<std::size_t>(i)];
    if (layout.contact && !(weight[row] * r[row] > zero)) continue;
    const double size = layout.contact ? r[row] : 1;
    const Eigen::Index normal = n;
    if (layout.contact) free(row);
    for (const RowGroup& group : RowGroups<6>::all) {
      std::array<Eigen::Index, 3> rows{};  // of the problem, of the group's that are there
      Vector3 r_g = Vector3::Zero(), axes = Vector3::Zero();
      int there = 0;
      for (int k = layout.contact ? 1 : 0; k < layout.rows; ++k) {
        const int place = layout.place[static_cast<std::size_t>(k)];
        if (place < group.first || place >= group.first + group.size) continue;
        rows[static_cast<std::size_t>(there)] = row + k;
        r_g(there) = r[row + k];
        axes(there++) = block.axes(place);
      }
      const Bound bound = bound_of(axes, r_g);
      const bool slides = !(axes.maxCoeff() > 0) || bound.n >= size * (1 - at_side);
      for (int k = 0; k < there; ++k) {
        const Eigen::Index at = rows[static_cast<std::size_t>(k)];
        if (slides && layout.contact)
          tied.P(at, normal) = bound.ray(k);
        else if (slides)
          tied.known[at] = bound.ray(k);
        else if (axes(k) > 0)
          free(at);
      }
    }
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
