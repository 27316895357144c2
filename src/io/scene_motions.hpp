// What scene files say of prescribed motions and of forces.
#pragma once

#include <string>

#include "io/scene_table.hpp"

namespace perp {

/// The motion that a table { kind = "shaker", ... } says, about `pose`.
[[nodiscard]] PrescribedMotion read_motion(const SceneTable& table, const Pose& pose);

/// Where that pose stands in the recipe, and the table that says the rest; empty if the body stands still.
[[nodiscard]] Pose pose_of_motion(const Recipe& recipe);
[[nodiscard]] std::string write_motion(const Recipe& recipe);

/// A force that a table [[force]] says, added to the model; and back.
void read_force(const SceneTable& table, Model& model);
[[nodiscard]] std::string write_force(const Model& model, const BodyForce& force);

}  // namespace perp
