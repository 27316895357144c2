#include "step/parts/free_rotation.hpp"

#include <cmath>
#include <Eigen/LU>
#include <limits>
#include <numbers>

namespace perp {
namespace {

/// Newton with halved steps; what is left of the equation, relative to L.
double solve(const Matrix3& J, const Vector3& L, double h, Vector3& w) {
  constexpr int most = 40, most_halvings = 12;
  constexpr double rounding = 1e-15;
  const double size = L.norm();
  const auto miss = [&](const Vector3& x) -> Vector3 { return rotation(0.5 * h * x) * Vector3(J * x) - L; };
  Vector3 F = miss(w);
  for (int k = 0; k < most && F.norm() > rounding * size; ++k) {
    const Vector3 a = 0.5 * h * w;
    const Matrix3 slope = rotation(a).toRotationMatrix() * (J - 0.5 * h * skew(J * w) * rotation_jacobian(a));
    const Vector3 step = slope.partialPivLu().solve(F);
    if (!step.allFinite()) break;
    double t = 1;
    Vector3 next = w - step;
    for (int i = 0; i < most_halvings && !(miss(next).norm() < F.norm()); ++i) next = w - (t /= 2) * step;
    const Vector3 now = miss(next);
    if (!(now.norm() < F.norm())) break;
    w = next;
    F = now;
  }
  return F.norm() / size;
}

/// J (w_f - w) = h (torque - w_f x J w_f) by Newton's method from w_f, its steps halved until they lessen the miss; false if that is not
/// at rounding.
bool solve_backward(const Matrix3& J, const Vector3& w, const Vector3& torque, double h, Vector3& w_f) {
  constexpr int most = 50;
  constexpr double rounding = 4 * std::numeric_limits<double>::epsilon(), least_part = 1e-3;
  const Vector3 L = J * w;
  const double scale = L.norm() + h * torque.norm();
  Vector3 best = w_f, newton = Vector3::Zero();
  double least = infinity, part = 1;
  for (int i = 0; i < most && least > rounding * scale; ++i) {
    const Vector3 L_f = J * w_f, r = L_f - L + h * (w_f.cross(L_f) - torque);
    if (r.norm() < least) {
      least = r.norm();
      best = w_f;
      newton = -Matrix3(J + h * (skew(w_f) * J - skew(L_f))).partialPivLu().solve(r);
      part = 1;
    } else if ((part /= 2) < least_part) {
      break;
    }
    w_f = best + part * newton;
  }
  w_f = best;
  return least <= 64 * rounding * scale;
}

}  // namespace

Vector3 free_rotation(const Matrix3& J, const Vector3& L, double h) {
  constexpr int starts = 200;
  constexpr double enough = 1e-13;
  const Matrix3 J_inverse = J.inverse();
  Vector3 best = J_inverse * L;
  if (L.isZero(0)) return best;
  double least = solve(J, L, h, best);
  for (int i = 0; i < starts && least > enough; ++i) {  // a spiral over the sphere
    const double z = 1 - (2 * i + 1.0) / starts, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    Vector3 w = L.norm() * (J_inverse * Vector3(r * std::cos(angle), r * std::sin(angle), z));
    const double miss = solve(J, L, h, w);
    if (miss < least) least = miss, best = w;
  }
  return best;
}

void implicit_gyroscopic(const Model& model, const State& x, double h, Vector& k) {
  for (const Body& b : model.bodies()) {
    if (b.kind != BodyKind::Spatial || b.J == b.J(0, 0) * Matrix3::Identity()) continue;
    const Vector3 w = x.nu.segment<3>(b.v0 + 3);
    const Vector3 torque = Vector3(k.segment<3>(b.v0 + 3)) + w.cross(b.J * w);
    Vector3 w_f = w;
    // turns of radians a step: from the answers of shorter ones
    for (int parts = 1; !solve_backward(b.J, w, torque, h, w_f) && parts <= 64; parts *= 4) {
      w_f = w;
      for (int i = 1; i < 4 * parts; ++i) solve_backward(b.J, w, torque, i * h / (4 * parts), w_f);
    }
    k.segment<3>(b.v0 + 3) = torque - w_f.cross(b.J * w_f);
  }
}

}  // namespace perp
