// How a body resists: mass, and the inertia tensor about its centre of mass.
#pragma once

#include "perp/core/types.hpp"

namespace perp {

/// Mass and inertia of a spatial rigid body. The body frame's origin is the centre of mass; its axes need not be
/// principal (they are found). A tensor is one that a body can have: symmetric, principal moments I1 <= I2 <= I3
/// positive with I1 + I2 >= I3 (to 1e-12 I3; equality is a flat body).
/// Every maker throws std::invalid_argument naming the argument that no body can have.
class Inertia {
 public:
  /// mass [kg] > 0; J (3, 3) [kg m^2] about the centre of mass in body axes.
  Inertia(double mass, const Matrix3& J);

  static Inertia principal(double mass, const Vector3& moments);  ///< J = diag(moments) [kg m^2]
  static Inertia solid_sphere(double mass, double radius);        ///< 2/5 m r^2
  static Inertia hollow_sphere(double mass, double radius);       ///< thin shell, 2/3 m r^2
  static Inertia solid_box(double mass, const Vector3& size);     ///< full edge lengths along the axes [m]
  static Inertia solid_cylinder(double mass, double radius, double length);  ///< axis along z
  static Inertia solid_ellipsoid(double mass, const Vector3& semi_axes);

  double mass() const { return mass_; }                          ///< [kg]
  const Matrix3& tensor() const { return J_; }                   ///< body axes [kg m^2]
  const Vector3& principal_moments() const { return moments_; }  ///< ascending [kg m^2]
  const Matrix3& principal_axes() const { return axes_; }  ///< columns: a right-handed frame in body axes

 private:
  double mass_;
  Matrix3 J_;
  Vector3 moments_;
  Matrix3 axes_;
};

}  // namespace perp
