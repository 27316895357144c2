// The gaps of scene files: each kind with the sizes that it needs, to be read and to be written.
#pragma once

#include <string>

#include "io/scene_table.hpp"
#include "perp/model/gaps.hpp"

namespace perp {

/// A gap that a table { kind = "sphere_on_plane", radius = 1 } says.
[[nodiscard]] Gap read_gap(const SceneTable& table);

/// The table that read_gap makes the same gap of.
[[nodiscard]] std::string write_gap(const Recipe& recipe);

}  // namespace perp
