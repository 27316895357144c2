// A state as named numbers: the columns of trajectory.csv after t.
#pragma once

#include <string>
#include <vector>

#include "perp/model/model.hpp"

namespace perp {

/// Of each body in the model's order: spatial and prescribed NAME.x .y .z .qw .qx .qy .qz .vx .vy .vz .wx .wy .wz, planar NAME.x .y
/// .angle .vx .vy .omega, particle NAME.x .y .z .vx .vy .vz, generalized NAME.q1 .. .v1 ..
[[nodiscard]] std::vector<std::string> motion_columns(const Model& model);

/// The numbers of a state in that order: coordinates and velocities as it has them, except a spatial body's angular velocity, here
/// in world axes. `row` is filled anew.
void motion_row(const Model& model, const State& x, std::vector<double>& row);

}  // namespace perp
