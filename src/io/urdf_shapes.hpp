// Collision shapes of a robot as contacts: with the floor, and with each other where perp has a gap for it.
#pragma once

#include "io/urdf_robot.hpp"
#include "perp/model/model.hpp"

namespace perp {

struct PlacedShape {
  UrdfShape shape;
  std::string name;       ///< of its contact with the floor
  int line = 0;           ///< of its link
  BodyId body;            ///< that it is part of
  BodyId carrier = body;  ///< that its body's joint sits on; its body itself at the root
  Pose X_BS = {};         ///< in its body's axes
  Pose X_WS_start = {};
};

struct ShapeContactOptions {
  bool floor = false;  ///< a plane z = 0 of the ground
  double mu = 0, e = 0;
};

/// Spheres, boxes and cylinders (by their two rims) against the floor; spheres and boxes against each other, where no joint joins
/// the two bodies and they are apart at the start. What gets no contact is returned.
std::vector<UrdfUnused> add_shape_contacts(const std::vector<PlacedShape>& shapes,
                                           const ShapeContactOptions& options, const std::string& file,
                                           Model& model);

}  // namespace perp
