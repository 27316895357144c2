#include "solve/friction/minimum_norm.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>

#include "solve/friction/cone.hpp"

namespace perp {
namespace {

enum class Mode { Open, Slide, Stick };

struct Piece {
  Mode mode;
  Vector3 ray;  // unit, of a sliding contact
};

/// Reads the modes off the velocity; what is below round-off of the largest velocity counts as zero.
std::vector<Piece> modes(const FrictionProblem& problem, const Vector& r, const Vector& u) {
  const std::vector<Eigen::Index> first = problem.offsets();
  const double zero_velocity = 1e-9 * u.cwiseAbs().maxCoeff(), zero_reaction = 1e-9 * r.cwiseAbs().maxCoeff();
  std::vector<Piece> pieces;
  for (int i = 0; i < static_cast<int>(problem.blocks()); ++i) {
    const BlockKind kind = problem.kind(i);
    const double mu = problem.mu(i);
    Vector3 u_i = Vector3::Zero();
    u_i.head(block_rows(kind)) = u.segment(first[i], block_rows(kind));
    Piece piece{Mode::Stick, Vector3::Zero()};
    if (kind == BlockKind::Interval) {
      if (std::abs(u_i(0)) > zero_velocity) piece = {Mode::Slide, Vector3(u_i(0) > 0 ? -1 : 1, 0, 0)};
    } else if (u_i(0) > zero_velocity && std::abs(r(first[i])) <= zero_reaction) {
      piece.mode = Mode::Open;
    } else if (u_i.tail<2>().norm() > zero_velocity) {
      const Vector2 d = u_i.tail<2>().normalized();
      piece = {Mode::Slide, Vector3(1, -mu * d(0), -mu * d(1)).normalized()};
    }
    pieces.push_back(piece);
  }
  return pieces;
}

/// Projection of z onto the piece's reactions and its derivative.
void project(const Piece& piece, BlockKind kind, double mu, const Vector3& z, Vector3& p, Matrix3& P) {
  p.setZero();
  P.setZero();
  if (kind == BlockKind::Interval) {
    if (piece.mode == Mode::Slide) {
      p(0) = piece.ray(0) * mu;
    } else {
      p(0) = std::clamp(z(0), -mu, mu);
      P(0, 0) = std::abs(z(0)) < mu ? 1 : 0;
    }
    return;
  }
  if (piece.mode == Mode::Open) return;
  if (piece.mode == Mode::Slide) {
    const double along = piece.ray.dot(z);
    if (along < 0) return;  // at 0, where Newton starts, the side on which it gives way
    p = along * piece.ray;
    P = piece.ray * piece.ray.transpose();
    return;
  }
  p = project_block(disc_block(kind, mu), z);
  const double tangential = z.tail<2>().norm();
  if (tangential <= mu * z(0)) {
    P.diagonal().head(block_rows(kind)).setOnes();
  } else if (mu * tangential > -z(0)) {  // on the side of the cone: along its ray and, curved, across
    const Vector2 d = tangential > 0 ? Vector2(z.tail<2>() / tangential) : Vector2(1, 0);
    const Vector3 ray = Vector3(1, mu * d(0), mu * d(1)).normalized();
    P = ray * ray.transpose();
    if (kind == BlockKind::Cone && tangential > 0) {
      const Vector3 across(0, -d(1), d(0));
      P += p.tail<2>().norm() / tangential * across * across.transpose();
    }
  }
}

}  // namespace

std::optional<Vector> minimum_norm_reactions(const FrictionProblem& problem, const Matrix& W,
                                             const Vector& r0, const Vector& u) {
  constexpr int most_iterations = 100, most_halvings = 30;
  const Eigen::Index m = r0.size();
  for (Eigen::Index i = 0; i < problem.blocks(); ++i)
    if (problem.mu_o.size() > 0 || block_rows(problem.kind(i)) > 3 || problem.kind(i) > BlockKind::Interval)
      return std::nullopt;
  const std::vector<Eigen::Index> first = problem.offsets();
  const std::vector<Piece> pieces = modes(problem, r0, u);
  const Vector target = W * r0;
  Matrix derivative(m, m);
  const auto reactions = [&](const Vector& lambda, bool with_derivative) {
    const Vector z = W.transpose() * lambda;
    Vector r(m);
    Vector3 p;
    Matrix3 P;
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i) {
      const int rows = block_rows(problem.kind(i));
      Vector3 z_i = Vector3::Zero();
      z_i.head(rows) = z.segment(first[i], rows);
      project(pieces[i], problem.kind(i), problem.mu(i), z_i, p, P);
      r.segment(first[i], rows) = p.head(rows);
      if (with_derivative)
        derivative.middleCols(first[i], rows).noalias() =
            W.middleCols(first[i], rows) * P.topLeftCorner(rows, rows);
    }
    return r;
  };
  Vector lambda = Vector::Zero(m);
  Vector r = reactions(lambda, true);
  for (int k = 0; k < most_iterations; ++k) {
    const Vector miss = target - W * r;
    if (miss.norm() <= 1e-14 * (target.norm() + W.norm() * r.norm())) return r;
    Matrix normal = derivative * W.transpose();
    normal.diagonal().array() +=
        1e-13 * std::max(normal.trace(), W.trace() * W.trace() / static_cast<double>(m));
    const Vector step = normal.ldlt().solve(miss);
    if (!step.allFinite()) break;
    double t = 1;
    for (int halvings = 0;; ++halvings, t /= 2) {
      const Vector trial = reactions(lambda + t * step, false);
      if ((target - W * trial).norm() <= (1 - 1e-4 * t) * miss.norm()) break;
      if (halvings == most_halvings)
        return miss.norm() <= 1e-10 * target.norm() ? std::optional(r) : std::nullopt;
    }
    lambda += t * step;
    r = reactions(lambda, true);
  }
  return std::nullopt;
}

}  // namespace perp
