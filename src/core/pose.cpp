#include "perp/core/pose.hpp"

#include <cmath>

namespace perp {

Quaternion unit(const Quaternion& q) {
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  return std::abs(q.squaredNorm() - 1) <= rounding ? q : q.normalized();
}

Quaternion rotation(const Vector3& angle) {
  const double theta = angle.norm();
  const double half = 0.5 * theta;
  // sin(theta/2)/theta from its series where the quotient would lose digits or divide by zero
  const double s = theta < 1e-4 ? 0.5 - theta * theta / 48 : std::sin(half) / theta;
  return {std::cos(half), s * angle.x(), s * angle.y(), s * angle.z()};
}

Vector3 rotation_vector(const Quaternion& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const Vector3 v = sign * q.vec();
  const double n = v.norm();
  const double scale = n < 1e-8 ? 2.0 : 2 * std::atan2(n, sign * q.w()) / n;
  return scale * v;
}

}  // namespace perp
