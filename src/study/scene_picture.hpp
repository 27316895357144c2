// What bodies of built-in scenes look like where their contacts do not tell.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "perp/study/scene.hpp"

namespace perp {

/// Shapes that move as one, with a body or, of a generalized one, which has no pose, by its coordinates. For pictures alone: nothing of
/// this touches anything or enters the motion.
struct ScenePart {
  BodyId body;       ///< the ground too
  std::string name;  ///< of the part of a generalized body: "sleeve"
  std::vector<Shape> shapes;
  std::vector<Pose> poses;  ///< of the shapes, in the part's axes, which of a body with a pose are its own
  std::function<Pose(const Vector&)> pose =
      {};  ///< of a generalized body's part in the world, from its coordinates
};

/// Empty for scenes whose contacts and joints say what their bodies are.
[[nodiscard]] std::vector<ScenePart> picture_of(const Scene& scene);

}  // namespace perp
