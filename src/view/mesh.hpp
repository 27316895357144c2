// Solids as triangles.
#pragma once

#include <vector>

#include "perp/view/solids.hpp"

namespace perp {

/// Triangles with a normal at each vertex; `triangles` holds three vertex numbers each, counter-clockwise from outside.
struct Mesh {
  std::vector<Vector3> vertices, normals;
  std::vector<int> triangles;
};

/// The solid in its body's axes. `reach` [m] is the half width of what has no end (planes, tubes without a length), `thin` the half
/// thickness of what has none (discs, planar shapes, sticks).
[[nodiscard]] Mesh mesh_of(const Solid& solid, double reach, double thin);

}  // namespace perp
