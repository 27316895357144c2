#include "perp/core/pose.hpp"

#include <cmath>

namespace perp {

Quaternion unit(const Quaternion& q) {
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  return std::abs(q.squaredNorm() - 1) <= rounding ? q : q.normalized();
}

Matrix3 skew(const Vector3& a) {
  Matrix3 A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

Matrix3 rotation_jacobian(const Vector3& angle) {
  // I - (1 - cos)/theta² [a] + (theta - sin)/theta³ [a]², from series where the quotients would lose digits
  const double square = angle.squaredNorm(), theta = std::sqrt(square);
  const bool small = theta < 1e-2;
  const double b = small ? 0.5 - square * (1.0 / 24 - square / 720) : (1 - std::cos(theta)) / square;
  const double c =
      small ? 1.0 / 6 - square * (1.0 / 120 - square / 5040) : (theta - std::sin(theta)) / (square * theta);
  const Matrix3 A = skew(angle);
  return Matrix3::Identity() - b * A + c * A * A;
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
