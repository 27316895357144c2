// The polygon that stands for the circular friction cone in linear methods (Figure 5).
#pragma once

#include <vector>

#include "perp/core/types.hpp"

namespace perp {

/// Vertices d_k of the friction polygon with `edges` vertices, inscribed in the unit circle: d_k at the angle 2 pi k/edges from
/// t, as (t, o) components. Between vertices friction reaches only cos(pi/edges) of the circle's (erratum 20).
/// Throws std::invalid_argument for edges < 3: fewer do not span the tangent plane positively.
[[nodiscard]] std::vector<Vector2> friction_polygon(int edges);

/// Vertices of a polytope inscribed in the unit ball, for friction that twists, as (t, o, n) components: the polygon as rings at the latitudes
/// j pi/(2 m), |j| < m = max(1, edges/4), and both poles.
[[nodiscard]] std::vector<Vector3> friction_polytope(int edges);

/// By how much the polygon, the polytope, has to be enlarged to reach p: 1 on its boundary.
[[nodiscard]] double polygon_gauge(int edges, const Vector2& p);
[[nodiscard]] double polytope_gauge(int edges, const Vector3& p);
/// The largest d . y over its vertices d.
[[nodiscard]] double polygon_support(int edges, const Vector2& y);
[[nodiscard]] double polytope_support(int edges, const Vector3& y);

}  // namespace perp
