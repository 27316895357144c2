// Where a body is: a rigid transform from body to world, and how it moves.
#pragma once

#include "perp/core/types.hpp"

namespace perp {

/// X_WB: maps body coordinates to world coordinates, x_W = p + R x_B.
struct Pose {
  Vector3 p = Vector3::Zero();            ///< p_WB, body origin in world axes [m]
  Quaternion q = Quaternion::Identity();  ///< R_WB as a unit quaternion

  Matrix3 R() const { return q.toRotationMatrix(); }                   ///< R_WB
  Vector3 operator*(const Vector3& x_B) const { return p + q * x_B; }  ///< body point to world
  Pose operator*(const Pose& X_BC) const { return {*this * X_BC.p, q * X_BC.q}; }
  Pose inverse() const { return {q.conjugate() * (-p), q.conjugate()}; }
};

/// Velocity of a body in world axes.
struct Twist {
  Vector3 v = Vector3::Zero();  ///< of the body's origin [m/s]
  Vector3 w = Vector3::Zero();  ///< angular velocity [rad/s]

  /// Velocity of the body's material point at the offset r from its origin, both in world axes [m/s].
  Vector3 at(const Vector3& r) const { return v + w.cross(r); }
};

/// [a]x: the matrix of x -> a x x.
[[nodiscard]] Matrix3 skew(const Vector3& a);

/// J of the exponential map at `angle`, body side: rotation(angle + da) = rotation(angle) rotation(J da) to first order.
[[nodiscard]] Matrix3 rotation_jacobian(const Vector3& angle);

/// q at unit length. One that has it to rounding (8 eps) is returned as it is, so that what was normalised once, printed
/// and read back keeps its bits.
[[nodiscard]] Quaternion unit(const Quaternion& q);

/// Rotation by the vector `angle` (axis times radians): the exponential map, exact for a constant rate.
[[nodiscard]] Quaternion rotation(const Vector3& angle);

/// The vector `angle` with |angle| <= pi and rotation(angle) = q: the logarithm, accurate near identity too.
[[nodiscard]] Vector3 rotation_vector(const Quaternion& q);

}  // namespace perp
