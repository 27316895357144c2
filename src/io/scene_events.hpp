// [[event]] of scene files: when something comes to pass, and what then.
#pragma once

#include "io/scene_table.hpp"
#include "perp/step/trajectory.hpp"

namespace perp {

/// when = an expression of t and of the bodies' coordinates as trajectory.csv names them (BODY.x, BODY.vx, ...); direction; then.
/// One without a name is event-NUMBER.
[[nodiscard]] UserEvent read_event(const SceneTable& table, const Model& model, std::size_t number);

}  // namespace perp
