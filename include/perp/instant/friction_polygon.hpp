// The polygon that stands for the circular friction cone in linear methods (Figure 5).
#pragma once

#include <vector>

#include "perp/core/types.hpp"

namespace perp {

/// Vertices d_k of the friction polygon with `edges` vertices, inscribed in the unit circle: d_k at the angle 2 pi k/edges from
/// t, as (t, o) components. Between vertices friction reaches only cos(pi/edges) of the circle's (erratum 20).
/// Throws std::invalid_argument for edges < 3: fewer do not span the tangent plane positively.
[[nodiscard]] std::vector<Vector2> friction_polygon(int edges);

}  // namespace perp
