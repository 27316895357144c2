#include "model/pairs/round_on_plane.hpp"

#include <algorithm>

namespace perp {
namespace {

constexpr double flat = 1e-8;    // tilt below which a rim has no lowest point of its own [rad]
constexpr double near_by = 0.5;  // tilt from which on points fixed on it are not looked at, as a sine
constexpr double pi = 3.14159265358979323846;

/// A point x of B over the plane.
ContactPoint over(const Vector3& n, const Vector3& on_plane, const Vector3& x) {
  return {.gap = n.dot(x - on_plane), .normal = n, .point = x};
}

void over(const Moving& n, const Moving& x, ContactDerivative& out) {
  out = {};
  out.normal = n.d;
  out.point = x.d;
}

}  // namespace

Rims::Rims(const std::vector<Vector3>& centres, double r, const Pose& X_BS)
    : axis(X_BS.q * Vector3::UnitZ()), aside(-(X_BS.q * Vector3::UnitX())), radius(r) {
  for (const Vector3& centre : centres) {
    Rim rim{X_BS * centre, {}};
    for (int k = 0; k < fixed; ++k) {
      const double angle = (2 * k + 1) * pi / fixed;
      rim.points.push_back(X_BS * (centre + r * Vector3(std::cos(angle), std::sin(angle), 0)));
    }
    reach = std::max(reach, rim.centre.norm() + r);
    all.push_back(std::move(rim));
  }
}

void RimsOnPlane::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const Vector3 n = X_WA.q * plane_.normal, p = X_WA * plane_.point, u = X_WB.q * rims_->axis;
  const Vector3 down = n.dot(u) * u - n;
  const double sine = down.norm();
  const Vector3 lowest =
      sine > flat ? Vector3(rims_->radius / sine * down) : Vector3(rims_->radius * (X_WB.q * rims_->aside));
  for (std::size_t i = 0; i < rims_->all.size(); ++i) {
    const Rims::Rim& rim = rims_->all[i];
    const auto slots = out.subspan(i * (1 + Rims::fixed), 1 + Rims::fixed);
    slots[0] = over(n, p, X_WB * rim.centre + lowest);
    for (std::size_t k = 0; k < Rims::fixed; ++k) {
      slots[1 + k].gap = infinity;
      if (sine < near_by) slots[1 + k] = over(n, p, X_WB * rim.points[k]);
    }
  }
}

void RimsOnPlane::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Moving n = A.direction(X_WA.q * plane_.normal);
  const Moving u = B.direction(X_WB.q * rims_->axis), down = dot(n, u) * u - n;
  const bool tilted = down.x.norm() > flat;
  const Moving lowest =
      tilted ? rims_->radius * unit(down) : B.direction(rims_->radius * (X_WB.q * rims_->aside));
  for (std::size_t i = 0; i < rims_->all.size(); ++i) {
    const Rims::Rim& rim = rims_->all[i];
    const auto slots = out.subspan(i * (1 + Rims::fixed), 1 + Rims::fixed);
    over(n, B.point(X_WB * rim.centre) + lowest, slots[0]);
    for (std::size_t k = 0; k < Rims::fixed && down.x.norm() < near_by; ++k)
      over(n, B.point(X_WB * rim.points[k]), slots[1 + k]);
  }
}

}  // namespace perp
