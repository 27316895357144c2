// Collision shapes of a robot as shapes of its bodies.
#pragma once

#include "io/urdf_robot.hpp"
#include "perp/model/model.hpp"

namespace perp {

struct PlacedShape {
  UrdfShape shape;
  std::string name;  ///< of its link, or LINK_2, ...
  int line = 0;      ///< of its link
  BodyId body;       ///< that it is part of
  Pose X_BS = {};    ///< in its body's axes
};

/// Gives the model the shapes; pairs that perp has no gap for keep their bodies apart. What gets no contact is returned.
std::vector<UrdfUnused> add_robot_shapes(const std::vector<PlacedShape>& shapes, const std::string& file,
                                         Model& model);

}  // namespace perp
