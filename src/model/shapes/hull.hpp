// The convex hull of points.
#pragma once

#include <vector>

#include "perp/core/types.hpp"

namespace perp {

struct Hull {
  std::vector<Vector3> vertices;
  std::vector<std::vector<int>> faces;  ///< loops, counter-clockwise seen from outside; facets of one plane are one
};

/// Of points in space, by Qhull. Throws std::invalid_argument naming `where` for fewer than four points, points in a plane, a
/// coordinate that is not finite, and where perp is built without Qhull.
Hull convex_hull(const char* where, const std::vector<Vector3>& points);

}  // namespace perp
