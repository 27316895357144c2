// What can move and how much: a body's kind decides its coordinates and nothing else about it.
#pragma once

#include <functional>
#include <string>

#include "perp/core/pose.hpp"
#include "perp/model/generalized.hpp"
#include "perp/model/inertia.hpp"
#include "perp/model/recipe.hpp"

namespace perp {

/// Handle of a body in the Model that made it.
struct BodyId {
  int index = 0;
  friend bool operator==(BodyId, BodyId) = default;
};

/// The inertial frame as a body: always there, never moves, no coordinates.
inline constexpr BodyId ground{0};

/// kind        coordinates q                              velocities nu
/// Ground      none                                       none
/// Prescribed  none: its pose is a function of time       none
/// Particle    x y z                                      v (world)
/// Planar      x y angle, in the world's xy plane         vx vy omega
/// Spatial     x y z, unit quaternion w x y z             v (world), w (body axes: M stays constant)
/// Generalized n coordinates of its own                   q'
enum class BodyKind { Ground, Prescribed, Particle, Planar, Spatial, Generalized };

/// A motion that nothing can change: shakers, turntables, belts. `pose` and `twist` belong together (twist is the
/// velocity of pose, world axes: dPsi/dt of the gap rows); `surface` is the velocity [m/s] of the surface relative
/// to the body at a world point, as of a conveyor belt, and enters the friction rows only.
struct PrescribedMotion {
  std::function<Pose(double t)> pose;
  std::function<Twist(double t)> twist;
  std::function<Vector3(double t, const Vector3& point)> surface;  ///< empty: none
  std::function<Twist(double t)> acceleration;  ///< of `twist`; empty: by differences of it [m/s^2, rad/s^2]
  Recipe recipe = {};                           ///< of those made here

  /// `acceleration`, or by differences of twist that are extrapolated.
  Twist acceleration_at(double t) const;

  /// amplitude sin(rate t + phase) [m; rad/s; rad] about `pose`.
  static PrescribedMotion shaker(const Vector3& amplitude, double rate, double phase = 0,
                                 const Pose& pose = {});
  /// Turns about the axis (a unit vector is made of it) through pose.p at rate [rad/s].
  static PrescribedMotion turntable(const Vector3& axis, double rate, const Pose& pose = {});
  /// Stands still; its surface runs at `velocity` [m/s], world axes.
  static PrescribedMotion belt(const Vector3& velocity, const Pose& pose = {});
};

/// One body as the model keeps it. The first entry in q and nu, and how many of each, follow from the kind.
struct Body {
  std::string name = {};
  BodyKind kind = BodyKind::Ground;
  double mass = 0;                      ///< [kg]
  Matrix3 J = Matrix3::Zero();          ///< body axes, about the centre of mass [kg m^2]; planar: J(2, 2)
  Matrix3 J_inverse = Matrix3::Zero();  ///< of J; planar: (2, 2)
  Pose rest = {};                       ///< pose in Model::rest(), where joints are defined
  PrescribedMotion motion = {};         ///< of a prescribed body
  GeneralizedSystem system = {};        ///< of a generalized one, which has no mass, J or pose
  int q0 = 0, nq = 0;                   ///< its part of State::q
  int v0 = 0, nv = 0;                   ///< its part of State::nu
};

}  // namespace perp
