// Robots that tests make up, piece by piece.
#pragma once

#include <filesystem>
#include <string>

#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/io/urdf.hpp"

namespace perp {

inline const std::filesystem::path robots =
    std::filesystem::path(PERP_TEST_FOLDER) / ".." / ".." / "examples" / "robots";

inline std::string inertial(double mass, double ixx, double iyy, double izz, const std::string& origin = "") {
  return "<inertial><origin " + origin + "/><mass value=\"" + shortest(mass) + "\"/><inertia ixx=\"" +
         shortest(ixx) + "\" ixy=\"0\" ixz=\"0\" iyy=\"" + shortest(iyy) + "\" iyz=\"0\" izz=\"" +
         shortest(izz) + "\"/></inertial>";
}

inline std::string xml_link(const std::string& name, const std::string& what = "") {
  return "<link name=\"" + name + "\">" + what + "</link>";
}

inline std::string xml_joint(const std::string& name, const std::string& type, const std::string& parent,
                             const std::string& child, const std::string& what = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + what + "</joint>";
}

inline std::string robot(const std::string& what) { return "<robot name=\"r\">\n" + what + "</robot>\n"; }

inline Scene read(const std::string& what, const SceneParameters& set = {}) {
  return read_urdf(robot(what), "r.urdf", set);
}

/// One link on one joint with the world.
inline std::string held(const std::string& type, const std::string& what, const std::string& of_joint) {
  return xml_link("world") + xml_link("l", what) + xml_joint("j", type, "world", "l", of_joint);
}

inline const std::string stops_far = "<limit lower=\"-1000\" upper=\"1000\" effort=\"1\" velocity=\"1\"/>";

}  // namespace perp
