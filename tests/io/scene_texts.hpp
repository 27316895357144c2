// Scene files made up by tests, and what reading one says.
#pragma once

#include "perp/io/scene_file.hpp"

namespace perp {

inline std::string message_of(const std::string& text, const SceneParameters& set = {}) {
  try {
    static_cast<void>(read_scene(text, "s.toml", set));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "read";
}

/// A scene that a body's other lines and more tables make complete.
inline std::string with_ball(const std::string& more = "") {
  return "[[body]]\nname = \"ball\"\nkind = \"spatial\"\nmass = 1\ninertia = { shape = \"solid_sphere\", "
         "radius = 0.1 }\n" +
         more;
}

}  // namespace perp
