// What a URDF file says, in perp's own types: links, joints between them, and what perp has no use for.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "perp/core/pose.hpp"

namespace perp {

/// The collision element of a link.
struct UrdfShape {
  enum class Kind { Sphere, Box, Cylinder, Capsule, Mesh } kind = Kind::Sphere;
  Vector3 size =
      Vector3::Zero();    ///< radius; full edges; radius and length (the axis is z) [m]; of a mesh its scale
  Pose X_LS = {};         ///< in the link's frame
  std::string file = {};  ///< of a mesh: its URI
};

struct UrdfLink {
  std::string name;
  int line = 0;
  double mass = 0;              ///< 0: no inertia
  Pose X_LC;                    ///< the frame of its inertial element: centre of mass, axes of J
  Matrix3 J = Matrix3::Zero();  ///< [kg m^2]
  std::vector<UrdfShape> shapes;
};

struct UrdfJoint {
  enum class Kind { Revolute, Continuous, Prismatic, Fixed, Floating, Planar } kind = Kind::Fixed;
  std::string name;
  int line = 0;
  int parent = 0, child = 0;         ///< in UrdfRobot::links
  Pose X_PJ;                         ///< the joint's frame in the parent's, the coordinate zero
  Vector3 axis = Vector3::UnitX();   ///< in the joint's frame
  bool limited = false;              ///< has a limit element
  double lower = 0, upper = 0;       ///< its stops [rad, m]
  double friction = 0, damping = 0;  ///< [N m, N], [N m s/rad, N s/m]
  std::string mimic;                 ///< the joint whose coordinate it follows: multiplier c + offset
  double multiplier = 1, offset = 0;
};

/// Something that was not used, and where it stands.
struct UrdfUnused {
  int line = 0;
  std::string what;  ///< "<visual> of link 'arm'"
};

/// A tree: each link but the root is the child of one joint, and its parent comes before it.
struct UrdfRobot {
  std::string name;
  std::vector<UrdfLink>
      links;  ///< the root first, then each after its parent, in the order of the file's joints
  std::vector<UrdfJoint> joints;  ///< joints[i] holds links[i + 1]
  std::vector<UrdfUnused> unused;
};

/// make(), its refusals placed at a line of the file: "FILE:LINE:1: whose: ...".
template <class Make>
auto at_line(const std::string& file, int line, const std::string& whose, Make make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(file + ":" + std::to_string(line) + ":1: " + whose + ": " + error.what());
  }
}

/// Reads a URDF file. Throws std::invalid_argument with "FILE:LINE:COLUMN: what was found, what is allowed" for what urdfdom
/// does not take and for what is not a tree, and where perp was built without urdfdom.
[[nodiscard]] UrdfRobot read_urdf_robot(std::string_view text, const std::string& file);

}  // namespace perp
