// What scene files say of joints, their stops, motors and springs.
#pragma once

#include <functional>
#include <string>

#include "io/scene_table.hpp"

namespace perp {

// Tables [[joint]], [[limit]], [[motor]], [[joint_spring]], added to the model.
void read_joint(const SceneTable& table, Model& model);
void read_limit(const SceneTable& table, Model& model);
void read_motor(const SceneTable& table, Model& model);
void read_joint_spring(const SceneTable& table, Model& model);

/// All of these as text; `cannot_say` is called with the name of what is a function of its own, and does not return.
[[nodiscard]] std::string write_joints(const Model& model,
                                       const std::function<void(const std::string& what)>& cannot_say);

}  // namespace perp
