#include "perp/instant/friction_polygon.hpp"

#include <cmath>
#include <numbers>

#include "perp/core/errors.hpp"

namespace perp {

std::vector<Vector2> friction_polygon(int edges) {
  if (edges < 3) refuse("friction_polygon", "edges", edges, "needs to be 3 at least");
  const auto n = static_cast<std::size_t>(edges);
  std::vector<Vector2> d(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / edges;
    d[k] = {std::cos(angle), std::sin(angle)};
    if (4 * k == n) d[k] = Vector2::UnitY();             // a quarter turn to the last bit
    if (n % 2 == 0 && 2 * k >= n) d[k] = -d[k - n / 2];  // opposite vertices are opposite to the last bit
  }
  return d;
}

}  // namespace perp
