#include "model/pairs/smooth_pair.hpp"

#include <Eigen/LU>

namespace perp {
namespace {

/// What supports along -n or n (by `sign`) of a body that turns with w: its part that n does not move.
void turn_with_body(const Support& s, const Vector3& n, double sign, int w, Moving& point) {
  point.d.middleCols<3>(w) += sign * (s.H * skew(n) - skew(s.point));
}

}  // namespace

void SmoothPair::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const SmoothSolid A = a_.turned(X_WA.R()), B = b_.turned(X_WB.R());
  const Vector3 c_A = X_WA * a_.centre, c_B = X_WB * b_.centre;
  const SmoothDistance best = smooth_distance(A, B, c_B - c_A);
  const Witness w{best.n, c_A + Support(A, best.n).point, c_B - Support(B, best.n).point, best.value};
  out[0] = w.contact(a_.radius, b_.radius);
}

/// dn from the condition at its maximum; what supports moves with its body and with n.
void SmoothPair::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  const SmoothSolid solid_a = a_.turned(X_WA.R()), solid_b = b_.turned(X_WB.R());
  const Vector3 c_A = X_WA * a_.centre, c_B = X_WB * b_.centre;
  const SmoothDistance best = smooth_distance(solid_a, solid_b, c_B - c_A);
  const Vector3& n = best.n;
  const Support s_a(solid_a, n), s_b(solid_b, n);
  const FixedIn A{0, X_WA}, B{6, X_WB};
  Moving a = A.point(c_A), b = B.point(c_B);
  turn_with_body(s_a, n, 1, 3, a);
  turn_with_body(s_b, n, -1, 9, b);
  const Eigen::Matrix<double, 3, 2> E = contact_frame(n).rightCols<2>();
  const Eigen::Matrix2d K = E.transpose() * (s_a.H + s_b.H) * E + best.value * Eigen::Matrix2d::Identity();
  const Moving normal{n, E * K.inverse() * (E.transpose() * (b.d - a.d))};
  a.d += s_a.H * normal.d;
  b.d -= s_b.H * normal.d;
  MovingWitness{normal, a, b}.contact(a_.radius, b_.radius, out[0]);
}

void SmoothOnPlane::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const Vector3 n = X_WA.q * plane_.normal;
  const Vector3 x = X_WB * b_.centre - Support(b_.turned(X_WB.R()), n).point - b_.radius * n;
  out[0] = {.gap = n.dot(x - X_WA * plane_.point), .normal = n, .point = x};
}

void SmoothOnPlane::differentiate(const Pose& X_WA, const Pose& X_WB,
                                  std::span<ContactDerivative> out) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Moving n = A.direction(X_WA.q * plane_.normal);
  const Support s(b_.turned(X_WB.R()), n.x);
  Moving x = B.point(X_WB * b_.centre);
  turn_with_body(s, n.x, -1, 9, x);
  x.d -= s.H * n.d + b_.radius * n.d;
  out[0] = {};
  out[0].normal = n.d;
  out[0].point = x.d;
}

}  // namespace perp
