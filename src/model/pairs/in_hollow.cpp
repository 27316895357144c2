#include "model/pairs/in_hollow.hpp"

namespace perp {

InHollow::InHollow(double radius, bool cylinder, const Pose& X_AS, const Polytope& b)
    : radius_(radius), cylinder_(cylinder), X_AS_(X_AS), b_(b) {}

void InHollow::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const Vector3 centre = X_WA * X_AS_.p, axis = X_WA.q * (X_AS_.q * Vector3::UnitZ());
  for (std::size_t i = 0; i < b_.corners.size(); ++i) {
    const Vector3 x = X_WB * b_.corners[i];
    Vector3 d = x - centre;
    if (cylinder_) d -= axis.dot(d) * axis;
    const double distance = d.norm();
    // in the middle all ways out are alike
    const Vector3 n = distance > 0 ? Vector3(-d / distance) : Vector3(X_WA.q * (X_AS_.q * Vector3::UnitX()));
    out[i] = {.gap = radius_ - distance - b_.radius, .normal = n, .point = x - b_.radius * n};
  }
}

void InHollow::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Moving centre = A.point(X_WA * X_AS_.p), axis = A.direction(X_WA.q * (X_AS_.q * Vector3::UnitZ()));
  for (std::size_t i = 0; i < b_.corners.size(); ++i) {
    const Moving x = B.point(X_WB * b_.corners[i]);
    Moving d = x - centre;
    if (cylinder_) d = d - dot(axis, d) * axis;
    const Moving n = d.x.norm() > 0 ? -1.0 * unit(d) : A.direction(X_WA.q * (X_AS_.q * Vector3::UnitX()));
    out[i] = {};
    out[i].normal = n.d;
    out[i].point = (x - b_.radius * n).d;
  }
}

}  // namespace perp
