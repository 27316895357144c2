#include "model/pairs/polytope.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/index.hpp"
#include "perp/core/types.hpp"

namespace perp {
namespace {

double diameter(const std::vector<Vector3>& corners) {
  double largest = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) largest = std::max(largest, (corners[i] - corners[j]).norm());
  return largest;
}

}  // namespace

void Polytope::add_edge(int from, int to, std::vector<Vector3> sides) {
  const Vector3 d = corners[at(to)] - corners[at(from)];
  edges.push_back({from, to, d.normalized(), d.norm(), std::move(sides)});
  spokes[at(from)].push_back(edges.back().along);
  spokes[at(to)].push_back(-edges.back().along);
}

void Polytope::add_face(const std::vector<int>& loop) {
  Vector3 area =
      Vector3::Zero();  // Newell: twice the area along the normal, whatever corner lies on a straight edge
  for (std::size_t i = 0; i < loop.size(); ++i)
    area += (corners[at(loop[i])] - corners[at(loop[0])])
                .cross(corners[at(loop[(i + 1) % loop.size()])] - corners[at(loop[0])]);
  Face face{.normal = area.normalized(), .offset = 0, .point = corners[at(loop[0])], .sides = {}};
  face.offset = face.normal.dot(face.point);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vector3 &p = corners[at(loop[i])], &q = corners[at(loop[(i + 1) % loop.size()])];
    const Vector3 out = (q - p).cross(face.normal).normalized();
    face.sides.push_back({out, out.dot(p)});
  }
  faces.push_back(std::move(face));
}

Polytope Polytope::point(double radius) {
  Polytope p;
  p.corners = {Vector3::Zero()};
  p.spokes.resize(1);
  p.radius = p.size = radius;
  return p;
}

Polytope Polytope::segment(double length, double radius) {
  Polytope p;
  p.corners = {-0.5 * length * Vector3::UnitZ(), 0.5 * length * Vector3::UnitZ()};
  p.spokes.resize(2);
  p.add_edge(0, 1, {});
  p.radius = radius;
  p.size = length + radius;
  return p;
}

Polytope Polytope::half_space() {
  Polytope p;
  p.faces = {{.normal = Vector3::UnitZ(), .offset = 0, .point = Vector3::Zero(), .sides = {}}};
  return p;
}

Polytope Polytope::box(const Vector3& size) {
  std::vector<Vector3> corners;
  for (unsigned i = 0; i < 8; ++i)
    corners.push_back(0.5 * Vector3((i & 1U) != 0 ? size.x() : -size.x(),
                                    (i & 2U) != 0 ? size.y() : -size.y(),
                                    (i & 4U) != 0 ? size.z() : -size.z()));
  return polyhedron(std::move(corners),
                    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

Polytope Polytope::polygon(std::vector<Vector2> loop) {
  Polytope p;
  for (const Vector2& x : loop) p.corners.emplace_back(x.x(), x.y(), 0);
  p.spokes.resize(loop.size());
  p.size = diameter(p.corners);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::size_t j = (i + 1) % loop.size();
    const Vector3 &a = p.corners[i], &b = p.corners[j];
    const Vector3 along = (b - a).normalized(), normal = along.cross(Vector3::UnitZ());
    p.faces.push_back({.normal = normal,
                       .offset = normal.dot(a),
                       .point = a,
                       .sides = {{along, along.dot(b)}, {-along, -along.dot(a)}}});
    p.spokes[i].push_back(along);
    p.spokes[j].push_back(-along);
  }
  return p;
}

Polytope Polytope::polyhedron(std::vector<Vector3> corners, const std::vector<std::vector<int>>& loops) {
  Polytope p;
  p.corners = std::move(corners);
  p.spokes.resize(p.corners.size());
  p.size = diameter(p.corners);
  std::map<std::pair<int, int>, std::vector<Vector3>> sides;
  for (const std::vector<int>& loop : loops) {
    p.add_face(loop);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto [from, to] = std::minmax(loop[i], loop[(i + 1) % loop.size()]);
      sides[{from, to}].push_back(-p.faces.back().sides[i].normal);
    }
  }
  for (auto& [ends, within] : sides) p.add_edge(ends.first, ends.second, within);
  return p;
}

Polytope Polytope::moved(const Pose& X) const {
  Polytope p = *this;
  const Matrix3 R = X.R();
  for (Vector3& x : p.corners) x = X.p + R * x;
  for (std::vector<Vector3>& around : p.spokes)
    for (Vector3& d : around) d = R * d;
  for (Edge& edge : p.edges) {
    edge.along = R * edge.along;
    for (Vector3& side : edge.sides) side = R * side;
  }
  for (Face& face : p.faces) {
    face.normal = R * face.normal;
    face.point = X.p + R * face.point;
    face.offset = face.normal.dot(face.point);
    for (Side& side : face.sides) {
      side.normal = R * side.normal;
      side.limit += side.normal.dot(X.p);
    }
  }
  return p;
}

double Polytope::reach() const {
  if (corners.empty()) return infinity;
  double longest = 0;
  for (const Vector3& x : corners) longest = std::max(longest, x.norm());
  return longest + radius;
}

int Polytope::highest_face(const Vector3& x, double& height) const {
  height = -infinity;
  int highest = -1;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double d = faces[i].normal.dot(x) - faces[i].offset;
    if (d > height) height = d, highest = static_cast<int>(i);
  }
  return highest;
}

bool Polytope::over(const Face& face, const Vector3& x, double slack) const {
  return std::all_of(face.sides.begin(), face.sides.end(),
                     [&](const Side& side) { return side.normal.dot(x) <= side.limit + slack; });
}

}  // namespace perp
