#include "solve/blocks/ellipsoid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace perp {

Vector3 ellipsoid_support_gradient(const Vector3& axes, const Vector3& u) {
  const double size = ellipsoid_support(axes, u);
  return size > 0 ? Vector3(axes.cwiseAbs2().cwiseProduct(u) / size) : Vector3::Zero();
}

double ellipsoid_gauge(const Vector3& axes, const Vector3& x) {
  Vector3 share = Vector3::Zero();
  for (int k = 0; k < 3; ++k)
    if (x(k) != 0) share(k) = axes(k) > 0 ? x(k) / axes(k) : infinity;
  return share.norm();
}

namespace {

/// The point of s E that a far z comes to as s vanishes, over s: a^2 z / |a z|.
Vector3 direction(const Vector3& axes, const Vector3& z) { return ellipsoid_support_gradient(axes, z); }

}  // namespace

EllipsoidProjection project_on_ellipsoid(const Vector3& axes, double size, const Vector3& z) {
  EllipsoidProjection result;
  const Vector3 b = size * axes;
  for (int k = 0; k < 3; ++k) result.p(k) = b(k) > 0 ? z(k) : 0;
  result.inside = ellipsoid_gauge(b, result.p) <= 1;
  if (result.inside) return result;
  const Vector3 squares = b.cwiseAbs2(), pull = b.cwiseProduct(result.p);
  double t =
      std::max(0.0, pull.norm() - squares.maxCoeff());  // at these |e| >= 1; of a ball it is the answer
  for (int k = 0; k < 3; ++k) t = std::max(t, std::abs(pull(k)) - squares(k));
  constexpr int most = 100;  // a handful is enough; rounding ends the search
  for (int step = 0; step < most; ++step) {
    Vector3 e = Vector3::Zero(), slope = Vector3::Zero();  // slope: -de/dt . e over e^2
    for (int k = 0; k < 3; ++k) {
      if (pull(k) == 0) continue;
      e(k) = pull(k) / (squares(k) + t);
      slope(k) = e(k) * e(k) / (squares(k) + t);
    }
    const double norm = e.norm();
    const double miss = norm - 1;
    const double next = t + norm * norm * miss / slope.sum();
    if (!(miss > std::numeric_limits<double>::epsilon()) || !(next > t)) break;
    t = next;
  }
  for (int k = 0; k < 3; ++k)
    if (b(k) > 0) result.p(k) = squares(k) / (squares(k) + t) * z(k);
  result.multiplier = t;
  return result;
}

EllipsoidSlope differentiate(const EllipsoidProjection& at, const Vector3& axes, double size,
                             const Vector3& z) {
  EllipsoidSlope slope{Matrix3::Zero(), Vector3::Zero()};
  const Vector3 squares = (size * axes).cwiseAbs2();
  if (at.inside) {
    for (int k = 0; k < 3; ++k) slope.dz(k, k) = squares(k) > 0 ? 1 : 0;
    return slope;
  }
  slope.ds = direction(axes, z);  // as s vanishes
  if (!(squares.maxCoeff() > 0)) return slope;
  Vector3 D = Vector3::Zero(), normal = Vector3::Zero();
  for (int k = 0; k < 3; ++k) {
    if (!(squares(k) > 0)) continue;
    D(k) = squares(k) / (squares(k) + at.multiplier);
    normal(k) = z(k) / (squares(k) + at.multiplier);
  }
  const Vector3 Dn = D.cwiseProduct(normal);
  slope.dz = -Dn * Dn.transpose() / normal.dot(Dn);
  slope.dz.diagonal() += D;
  slope.ds = (at.p - slope.dz * z) / size;
  return slope;
}

}  // namespace perp
