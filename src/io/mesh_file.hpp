// Triangles of STL and OBJ files.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "perp/core/types.hpp"

namespace perp {

struct TriangleMesh {
  std::vector<Vector3> points;                ///< each once
  std::vector<std::array<int, 3>> triangles;  ///< of numbers of points, as the file has them
  double volume() const;                      ///< of the solid within; negative if its faces look inwards
};

inline constexpr std::size_t most_triangles = 1'000'000;

/// Reads a file that ends in .stl (of text, or binary) or .obj. Throws std::invalid_argument with the file's name, and of files of text
/// the line, for what cannot be a solid: a file that is missing, of another kind or cut short, numbers that are not finite, fewer than
/// four points, a million triangles, faces that look inwards.
[[nodiscard]] TriangleMesh read_mesh(const std::filesystem::path& file);

/// At most `most` of the points: those that are furthest out in directions spread evenly, so that their hull is near the hull of all.
[[nodiscard]] std::vector<Vector3> outermost(const std::vector<Vector3>& points, int most);

}  // namespace perp
