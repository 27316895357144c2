#include "model/pairs/round_on_plane.hpp"

#include <algorithm>

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double flat = 1e-6;    // tilt below which a rim has no lowest point of its own [rad]
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

RimsOnPlane::RimsOnPlane(std::vector<Vector3> centres, double radius, const Plane& plane, const Pose& X_BS)
    : axis_(X_BS.q * Vector3::UnitZ()), aside_(-(X_BS.q * Vector3::UnitX())), radius_(radius), plane_(plane) {
  for (const Vector3& centre : centres) {
    Rim rim{X_BS * centre, {}};
    for (int k = 0; k < fixed; ++k) {
      const double angle = (2 * k + 1) * pi / fixed;
      rim.points.push_back(X_BS * (centre + radius * Vector3(std::cos(angle), std::sin(angle), 0)));
    }
    reach_ = std::max(reach_, rim.centre.norm() + radius);
    rims_.push_back(std::move(rim));
  }
}

std::string RimsOnPlane::feature(int slot) const {
  const std::string rim = "rim" + std::to_string(slot / (1 + fixed));
  return slot % (1 + fixed) == 0 ? rim : rim + "-" + std::to_string(slot % (1 + fixed) - 1);
}

void RimsOnPlane::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const Vector3 n = X_WA.q * plane_.normal, p = X_WA * plane_.point, u = X_WB.q * axis_;
  const Vector3 down = n.dot(u) * u - n;
  const double sine = down.norm();
  const Vector3 lowest = sine > flat ? Vector3(radius_ / sine * down) : Vector3(radius_ * (X_WB.q * aside_));
  for (std::size_t i = 0; i < rims_.size(); ++i) {
    const auto slots = out.subspan(i * (1 + fixed), 1 + fixed);
    slots[0] = over(n, p, X_WB * rims_[i].centre + lowest);
    for (std::size_t k = 0; k < fixed; ++k) {
      slots[1 + k].gap = infinity;
      if (sine < near_by) slots[1 + k] = over(n, p, X_WB * rims_[i].points[k]);
    }
  }
}

void RimsOnPlane::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Moving n = A.direction(X_WA.q * plane_.normal);
  const Moving u = B.direction(X_WB.q * axis_), down = dot(n, u) * u - n;
  const bool tilted = down.x.norm() > flat;
  const Moving lowest = tilted ? radius_ * unit(down) : B.direction(radius_ * (X_WB.q * aside_));
  for (std::size_t i = 0; i < rims_.size(); ++i) {
    const auto slots = out.subspan(i * (1 + fixed), 1 + fixed);
    over(n, B.point(X_WB * rims_[i].centre) + lowest, slots[0]);
    for (std::size_t k = 0; k < fixed; ++k) over(n, B.point(X_WB * rims_[i].points[k]), slots[1 + k]);
  }
}

EllipsoidOnPlane::EllipsoidOnPlane(const Vector3& semi_axes, const Plane& plane, const Pose& X_BS)
    : D_(X_BS.R() * semi_axes.cwiseAbs2().asDiagonal() * X_BS.R().transpose()),
      centre_(X_BS.p),
      reach_(X_BS.p.norm() + semi_axes.maxCoeff()),
      plane_(plane) {}

void EllipsoidOnPlane::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const Vector3 n = X_WA.q * plane_.normal, m = X_WB.q.conjugate() * n, Dm = D_ * m;
  out[0] = over(n, X_WA * plane_.point, X_WB * Vector3(centre_ - Dm / std::sqrt(m.dot(Dm))));
}

void EllipsoidOnPlane::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Moving n = A.direction(X_WA.q * plane_.normal);
  // b = centre - D n/s with D turning with B: d(D n) = D (dn - w x n) + w x (D n)
  const Matrix3 R = X_WB.R(), D = R * D_ * R.transpose();
  const Vector3 Dn = D * n.x;
  const double s = std::sqrt(n.x.dot(Dn));
  Moving support{Dn / s};
  const Matrix3 H = D / s - Dn * Dn.transpose() / (s * s * s);
  support.d = H * n.d;
  support.d.middleCols<3>(9) += H * skew(n.x) - skew(support.x);
  over(n, B.point(X_WB * centre_) - support, out[0]);
}

}  // namespace perp
