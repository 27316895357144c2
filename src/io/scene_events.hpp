// [[event]] of scene files: when something comes to pass, and what then.
#pragma once

#include <string>
#include <vector>

#include "io/scene_table.hpp"
#include "perp/step/user_event.hpp"

namespace perp {

/// `when`, an expression of t, of the bodies' coordinates and velocities as trajectory.csv names them (BODY.x, BODY.vx, ...), and of
/// JOINT.coordinate and JOINT.rate, joints as joints.csv names them; `direction`; `then`. One without a name is event-NUMBER, counted from
/// 1 over `before`, whose names it may not have.
[[nodiscard]] UserEvent read_event(const SceneTable& table, const Model& model,
                                   const std::vector<UserEvent>& before);

/// The table's lines. The event must have a recipe.
[[nodiscard]] std::string write_event(const UserEvent& event);

}  // namespace perp
