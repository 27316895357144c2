#include "perp/instant/friction_polygon.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

/// Vertices of the polygon of a meridian, all round.
int meridian(int edges) { return 4 * std::max(1, edges / 4); }

/// The angle of p past the vertex before it.
double past_vertex(int edges, const Vector2& p) {
  const double turn = 2 * std::numbers::pi / edges, angle = std::atan2(p.y(), p.x());
  return angle - turn * std::floor(angle / turn);
}

}  // namespace

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

std::vector<Vector3> friction_polytope(int edges) {
  const std::vector<Vector2> ring = friction_polygon(edges);
  const std::vector<Vector2> half = friction_polygon(meridian(edges));
  const int m = meridian(edges) / 4;
  std::vector<Vector3> d;
  for (int j = 1 - m; j < m; ++j) {
    const Vector2& latitude = half[static_cast<std::size_t>(j < 0 ? j + 4 * m : j)];
    for (const Vector2& v : ring) d.push_back({latitude.x() * v.x(), latitude.x() * v.y(), latitude.y()});
  }
  d.push_back(Vector3::UnitZ());
  d.push_back(-Vector3::UnitZ());
  return d;
}

double polygon_gauge(int edges, const Vector2& p) {
  const double half = std::numbers::pi / edges;
  return p.norm() * std::cos(past_vertex(edges, p) - half) / std::cos(half);
}

double polytope_gauge(int edges, const Vector3& p) {
  return polygon_gauge(meridian(edges), {polygon_gauge(edges, p.head<2>()), std::abs(p.z())});
}

double polygon_support(int edges, const Vector2& y) {
  const double past = past_vertex(edges, y);
  return y.norm() * std::cos(std::min(past, 2 * std::numbers::pi / edges - past));
}

double polytope_support(int edges, const Vector3& y) {
  return polygon_support(meridian(edges), {polygon_support(edges, y.head<2>()), std::abs(y.z())});
}

}  // namespace perp
