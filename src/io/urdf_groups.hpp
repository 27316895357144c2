// Links that fixed joints hold together: which they are, and their inertia as one body.
#pragma once

#include "io/urdf_robot.hpp"

namespace perp {

struct UrdfGroup {
  int first = 0;                     ///< the link nearest to the root; its frame is the group's
  int joint = -1;                    ///< in UrdfRobot::joints, that which moves it; -1: the root's group
  double mass = 0;                   ///< [kg]
  Vector3 centre = Vector3::Zero();  ///< of mass, in the group's frame [m]
  Matrix3 J = Matrix3::Zero();       ///< about the centre, along the group's axes [kg m^2]
  bool left_out = false;             ///< it has no mass and carries nothing that has
};

struct UrdfGroups {
  std::vector<UrdfGroup> all;  ///< each after the one that carries it; the root's is the first
  std::vector<int> of_link;    ///< the group of each link
  std::vector<Pose> X_GL;      ///< where each link's frame is in its group's
  std::vector<UrdfUnused> unused;
};

/// With `fixed` the root's group stands still and needs no inertia. Throws std::invalid_argument with FILE:LINE for a negative mass
/// and for links without mass that carry others on a joint that moves.
[[nodiscard]] UrdfGroups gather_links(const UrdfRobot& robot, const std::string& file, bool fixed);

}  // namespace perp
