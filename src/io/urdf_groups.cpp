#include "io/urdf_groups.hpp"

#include "io/toml_file.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

[[noreturn]] void refuse_link(const std::string& file, const UrdfLink& link, const std::string& found,
                              const char* allowed) {
  refuse_at(file, {static_cast<std::size_t>(link.line), 1}, found, allowed);
}

UrdfGroups group(const UrdfRobot& robot) {
  UrdfGroups groups;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const int joint = static_cast<int>(i) - 1;
    if (i > 0 && robot.joints[i - 1].kind == UrdfJoint::Kind::Fixed) {
      const auto parent = static_cast<std::size_t>(robot.joints[i - 1].parent);
      groups.of_link.push_back(groups.of_link[parent]);
      groups.X_GL.push_back(groups.X_GL[parent] * robot.joints[i - 1].X_PJ);
    } else {
      groups.of_link.push_back(static_cast<int>(groups.all.size()));
      groups.X_GL.emplace_back();
      groups.all.push_back({.first = static_cast<int>(i), .joint = joint});
    }
  }
  return groups;
}

/// Mass, centre of mass, and J by the parallel axes: J += R J Rᵀ + m (|d|² 1 - d dᵀ), d from the group's centre to the link's.
void add_inertia(const UrdfRobot& robot, UrdfGroups& groups) {
  const auto group_of = [&](std::size_t i) -> UrdfGroup& {
    return groups.all[static_cast<std::size_t>(groups.of_link[i])];
  };
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const UrdfLink& link = robot.links[i];
    group_of(i).mass += link.mass;
    group_of(i).centre += link.mass * (groups.X_GL[i] * link.X_LC.p);
  }
  for (UrdfGroup& g : groups.all)
    if (g.mass > 0) g.centre /= g.mass;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const UrdfLink& link = robot.links[i];
    if (link.mass == 0) continue;
    const Pose X = groups.X_GL[i] * link.X_LC;
    const Vector3 d = X.p - group_of(i).centre;
    const Matrix3 R = X.R(), J = R * link.J * R.transpose();
    group_of(i).J +=
        0.5 * (J + J.transpose()) + link.mass * (d.squaredNorm() * Matrix3::Identity() - d * d.transpose());
  }
}

/// From the ends of the tree to the root: what has no mass and carries nothing is left out.
void leave_out(const UrdfRobot& robot, const std::string& file, UrdfGroups& groups) {
  std::vector<int> beyond(groups.all.size(), -1);  // a joint by which each carries another
  for (std::size_t i = groups.all.size(); i-- > 1;) {
    UrdfGroup& g = groups.all[i];
    const UrdfLink& link = robot.links[static_cast<std::size_t>(g.first)];
    const UrdfJoint& joint = robot.joints[static_cast<std::size_t>(g.joint)];
    if (g.mass > 0) {
      beyond[static_cast<std::size_t>(groups.of_link[static_cast<std::size_t>(joint.parent)])] = g.joint;
    } else if (beyond[i] < 0) {
      g.left_out = true;
      groups.unused.push_back({link.line, "link '" + link.name + "' and joint '" + joint.name +
                                              "': it has no inertia and carries nothing"});
    } else {
      refuse_link(file, link,
                  "link '" + link.name + "' without inertia between the joints '" + joint.name + "' and '" +
                      robot.joints[static_cast<std::size_t>(beyond[i])].name + "'",
                  "needs an <inertial> with a mass");
    }
  }
}

}  // namespace

UrdfGroups gather_links(const UrdfRobot& robot, const std::string& file, bool fixed) {
  UrdfGroups groups = group(robot);
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const UrdfLink& link = robot.links[i];
    if (!(link.mass >= 0))
      refuse_link(file, link, "the mass " + shortest(link.mass) + " of link '" + link.name + "'",
                  "needs to be >= 0 [kg]");
    if (fixed && groups.of_link[i] == 0 && link.mass > 0)
      groups.unused.push_back(
          {link.line, "<inertial> of link '" + link.name + "', which is fixed to the world"});
  }
  add_inertia(robot, groups);
  if (const UrdfLink& root = robot.links[0]; !fixed && groups.all[0].mass == 0)
    refuse_link(file, root, "the root link '" + root.name + "' without inertia",
                "needs it if it is to float (base.fixed = 0)");
  leave_out(robot, file, groups);
  return groups;
}

}  // namespace perp
