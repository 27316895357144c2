// Loads that are not contact or joint reactions: the seed's g_ext.
#pragma once

#include <functional>

#include "perp/model/body.hpp"
#include "perp/model/joint.hpp"
#include "perp/model/recipe.hpp"
#include "perp/model/state.hpp"

namespace perp {

class Model;

/// Force and moment on a body, in world axes, the moment about its centre of mass.
struct Wrench {
  Vector3 force = Vector3::Zero();   ///< [N]
  Vector3 moment = Vector3::Zero();  ///< [N m]
};

/// Spring and damper between a point of A and a point of B (in their own axes), along the line between them:
///   force on B = -(stiffness (l - length) + damping l') e,   l e = x_B - x_A,   |e| = 1.
/// With length = 0 and damping = 0 the force is -stiffness (x_B - x_A), defined at l = 0 too.
struct Spring {
  BodyId a, b;
  Vector3 point_a = Vector3::Zero(), point_b = Vector3::Zero();  ///< [m]
  double stiffness = 0;                                          ///< [N/m] >= 0
  double damping = 0;                                            ///< [N s/m] >= 0
  double length = 0;                                             ///< unstretched [m] >= 0
};

/// Spring and damper along a joint's coordinate c: a moment or force on B, its opposite on A, of
///   -(stiffness (c - rest) + damping c').
struct JointSpring {
  JointId joint;
  double stiffness = 0;  ///< [N m/rad] or [N/m] >= 0
  double damping = 0;    ///< [N m s/rad] or [N s/m] >= 0
  double rest = 0;       ///< [rad] or [m]
  int coordinate = 0;    ///< which of the joint's
};

/// A motor that gives a moment or force [N m, N] along a joint's coordinate, on B, its opposite on A. It has no part in
/// Model::energy.
struct JointMotor {
  using Effort = std::function<double(const Model&, const State&, double coordinate, double rate)>;
  JointId joint;
  Effort effort;
  int coordinate = 0;  ///< which of the joint's
  Recipe recipe = {};
};

/// Any load on one body that depends on the whole state. It has no part in Model::energy.
struct BodyForce {
  BodyId body;
  std::function<Wrench(const Model&, const State&)> wrench;
  Recipe recipe = {};
};

}  // namespace perp
