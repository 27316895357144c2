#include "step/sensitivity/state_tangent.hpp"

#include <algorithm>

namespace perp {
namespace {

Quaternion orientation_of(const Body& b, const Vector& q) {
  return {q[b.q0 + 3], q[b.q0 + 4], q[b.q0 + 5], q[b.q0 + 6]};
}

/// How many of a body's coordinates change by adding.
int added(const Body& b) { return b.kind == BodyKind::Spatial ? 3 : b.nv; }

}  // namespace

State displaced(const Model& model, const State& x, const Vector& xi, const Vector& dnu, double eps) {
  State there = x;
  move(model, xi, eps, there.q);
  there.nu += eps * dnu;
  return there;
}

Vector displacement(const Model& model, const State& from, const State& to) {
  Vector xi(model.nv());
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    xi.segment(b.v0, added(b)) = to.q.segment(b.q0, added(b)) - from.q.segment(b.q0, added(b));
    if (b.kind == BodyKind::Spatial)
      xi.segment<3>(b.v0 + 3) =
          rotation_vector(orientation_of(b, from.q).conjugate() * orientation_of(b, to.q));
  }
  return xi;
}

StateDerivative in_coordinates(const Model& model, const State& x, const StateTangent& tangent) {
  StateDerivative out{Matrix::Zero(x.q.size(), tangent.xi.cols()), tangent.nu};
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    out.q.middleRows(b.q0, added(b)) = tangent.xi.middleRows(b.v0, added(b));
    if (b.kind != BodyKind::Spatial) continue;
    const Quaternion q = orientation_of(b, x.q);
    for (Eigen::Index j = 0; j < out.q.cols(); ++j) {  // q' = q (0, xi/2)
      const Vector3 half = 0.5 * tangent.xi.col(j).segment<3>(b.v0 + 3);
      out.q(b.q0 + 3, j) = -q.vec().dot(half);
      out.q.col(j).segment<3>(b.q0 + 4) = q.w() * half + q.vec().cross(half);
    }
  }
  return out;
}

void difference(const Model& model, const State& x, const State& plus, const State& minus, double eps,
                Eigen::Index column, StateTangent& out) {
  out.xi.col(column) = (displacement(model, x, plus) - displacement(model, x, minus)) / (2 * eps);
  out.nu.col(column) = (plus.nu - minus.nu) / (2 * eps);
}

double half_width(const Model& model, const State& x, const StateTangent& tangent, Eigen::Index column) {
  // the third derivative's part, of order eps^2, and the rounding's, 1e-16/eps, are then alike
  constexpr double share = 6e-6;  // of what counts as much: a radian, the state's own lengths and speeds
  double fastest = 0, length = 0, turn = 0, speed = 0, spin = 0;
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    const int linear = b.kind == BodyKind::Planar ? 2 : added(b);
    const auto part = [&](const Matrix& m, int from, int n) {
      return n == 0 ? 0.0 : m.col(column).segment(b.v0 + from, n).cwiseAbs().maxCoeff();
    };
    length = std::max(length, part(tangent.xi, 0, linear));
    turn = std::max(turn, part(tangent.xi, linear, b.nv - linear));
    speed = std::max(speed, part(tangent.nu, 0, linear));
    spin = std::max(spin, part(tangent.nu, linear, b.nv - linear));
    fastest = std::max(fastest, x.nu.segment(b.v0, b.nv).cwiseAbs().maxCoeff());
  }
  const double most = std::max({turn, length, speed / std::max(1.0, fastest), spin / std::max(1.0, fastest)});
  return most > 0 ? share / most : share;
}

}  // namespace perp
