#include "model/pairs/smooth_pair.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <vector>

namespace perp {
namespace {

using Matrix2 = Eigen::Matrix2d;

/// √(nᵀ D n) with its gradient, the point that supports along n, and its Hessian.
struct Support {
  double value = 0;
  Vector3 point = Vector3::Zero();
  Matrix3 H = Matrix3::Zero();

  Support(const Matrix3& D, const Vector3& n) {
    const Vector3 Dn = D * n;
    value = std::sqrt(n.dot(Dn));
    if (!(value > 0)) return;
    point = Dn / value;
    H = D / value - Dn * Dn.transpose() / (value * value * value);
  }
};

/// The two solids in world axes, the centre of A at the origin.
struct Problem {
  Matrix3 D_a, D_b;
  Vector3 d;  // centre of B

  double value(const Vector3& n) const {
    return n.dot(d) - std::sqrt(n.dot(D_a * n)) - std::sqrt(n.dot(D_b * n));
  }
};

Eigen::Matrix<double, 3, 2> across(const Vector3& n) { return contact_frame(n).rightCols<2>(); }

/// Newton's direction uphill: where F is not concave along a tangent, as if it were.
Eigen::Vector2d uphill(const Matrix2& K, const Eigen::Vector2d& slope) {
  const Eigen::SelfAdjointEigenSolver<Matrix2> eigen(K);
  const double least = 1e-12 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  const Eigen::Vector2d curvature = eigen.eigenvalues().cwiseAbs().cwiseMax(least);
  return eigen.eigenvectors() * (eigen.eigenvectors().transpose() * slope).cwiseQuotient(curvature);
}

/// The local maximum of F uphill from n.
Vector3 climb(const Problem& p, Vector3 n) {
  constexpr int most = 100;
  constexpr double rounding = 4e-16;
  const double size = p.d.norm() + std::sqrt(p.D_a.trace()) + std::sqrt(p.D_b.trace());
  double F = p.value(n);
  for (int k = 0; k < most; ++k) {
    const Support a(p.D_a, n), b(p.D_b, n);
    const auto E = across(n);
    const Eigen::Vector2d slope = E.transpose() * (p.d - a.point - b.point);
    if (slope.norm() <= rounding * size) break;
    const Matrix2 K = E.transpose() * (a.H + b.H) * E + F * Matrix2::Identity();
    const Vector3 step = E * uphill(K, slope);
    bool rises = false;
    for (double part = std::min(1.0, 1.0 / step.norm()); part > 1e-10 && !rises; part *= 0.5) {
      const Vector3 tried = (n + part * step).normalized();
      const double there = p.value(tried);
      rises = there > F || (part == 1 && there >= F - rounding * size && step.norm() < 1e-6);
      if (rises) n = tried, F = there;
    }
    if (!rises) break;
  }
  return n;
}

Vector3 best_direction(const Problem& p, const Matrix3& R_a, const Matrix3& R_b) {
  Vector3 best = climb(p, p.d.norm() > 0 ? p.d.normalized() : Vector3(Vector3::UnitZ()));
  if (p.value(best) >= 0) return best;
  for (const Matrix3* R : {&R_a, &R_b})
    for (int k = 0; k < 3; ++k)
      for (const double sign : {1.0, -1.0}) {
        const Vector3 n = climb(p, sign * R->col(k));
        if (p.value(n) > p.value(best)) best = n;
      }
  return best;
}

Problem problem(const SmoothSolid& a, const SmoothSolid& b, const Pose& X_WA, const Pose& X_WB, Vector3& n) {
  const Matrix3 R_a = X_WA.R(), R_b = X_WB.R();
  Problem p{R_a * a.D * R_a.transpose(), R_b * b.D * R_b.transpose(), X_WB * b.centre - X_WA * a.centre};
  n = best_direction(p, R_a, R_b);
  return p;
}

}  // namespace

SmoothSolid SmoothSolid::ellipsoid(const Vector3& semi_axes, const Pose& X) {
  const Matrix3 R = X.R();
  return {R * semi_axes.cwiseAbs2().asDiagonal() * R.transpose(), X.p, 0};
}

void SmoothPair::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  Vector3 n;
  const Problem p = problem(a_, b_, X_WA, X_WB, n);
  const Witness w{n, X_WA * a_.centre + Support(p.D_a, n).point, X_WB * b_.centre - Support(p.D_b, n).point,
                  p.value(n)};
  out[0] = w.contact(a_.radius, b_.radius);
}

/// dn from the condition at its maximum; what supports moves with its body and with n.
void SmoothPair::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  Vector3 n;
  const Problem p = problem(a_, b_, X_WA, X_WB, n);
  const Support s_a(p.D_a, n), s_b(p.D_b, n);
  const FixedIn A{0, X_WA}, B{6, X_WB};
  Moving a = A.point(X_WA * a_.centre), b = B.point(X_WB * b_.centre);
  a.d.middleCols<3>(3) += s_a.H * skew(n) - skew(s_a.point);
  b.d.middleCols<3>(9) -= s_b.H * skew(n) - skew(s_b.point);
  const auto E = across(n);
  const Matrix2 K = E.transpose() * (s_a.H + s_b.H) * E + p.value(n) * Matrix2::Identity();
  const Moving normal{n, E * K.inverse() * (E.transpose() * (b.d - a.d))};
  a.d += s_a.H * normal.d;
  b.d -= s_b.H * normal.d;
  MovingWitness{normal, a, b}.contact(a_.radius, b_.radius, out[0]);
}

}  // namespace perp
