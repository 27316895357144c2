#include "view/mesh.hpp"

#include <cmath>
#include <numbers>

namespace perp {
namespace {

using Kind = Solid::Kind;
using std::numbers::pi;

/// A surface of revolution about z: points (r, z) of the profile from below upwards, each with its normal in the same plane.
struct Profile {
  std::vector<Vector2> points, normals;
  void add(const Vector2& p, const Vector2& n) { points.push_back(p), normals.push_back(n); }
};

Mesh turned(const Profile& profile, int around) {
  Mesh mesh;
  const int n = static_cast<int>(profile.points.size());
  for (int j = 0; j <= around; ++j) {
    const double angle = 2 * pi * j / around, c = std::cos(angle), s = std::sin(angle);
    for (int i = 0; i < n; ++i) {
      const Vector2 &p = profile.points[static_cast<std::size_t>(i)],
                    &m = profile.normals[static_cast<std::size_t>(i)];
      mesh.vertices.emplace_back(c * p.x(), s * p.x(), p.y());
      mesh.normals.emplace_back(c * m.x(), s * m.x(), m.y());
    }
  }
  for (int j = 0; j < around; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      const Vector2 &low = profile.points[static_cast<std::size_t>(i)],
                    &high = profile.points[static_cast<std::size_t>(i) + 1];
      if (low == high) continue;  // a corner of the profile, there twice for its two normals
      const int a = j * n + i, b = a + n;
      if (low.x() > 0) mesh.triangles.insert(mesh.triangles.end(), {a, b, a + 1});
      if (high.x() > 0) mesh.triangles.insert(mesh.triangles.end(), {b, b + 1, a + 1});
    }
  return mesh;
}

void add_arc(Profile& profile, double r, double z, double from, double to, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const double angle = from + (to - from) * i / steps;
    const bool pole = std::abs(std::abs(angle) - pi / 2) < 1e-12;
    const Vector2 n(pole ? 0 : std::cos(angle), std::sin(angle));
    profile.add({r * n.x(), z + r * n.y()}, n);
  }
}

Mesh sphere(double r) {
  Profile profile;
  add_arc(profile, r, 0, -pi / 2, pi / 2, 12);
  return turned(profile, 24);
}

Mesh capsule(double r, double length) {
  Profile profile;
  add_arc(profile, r, -length / 2, -pi / 2, 0, 6);
  add_arc(profile, r, length / 2, 0, pi / 2, 6);
  return turned(profile, 24);
}

Mesh cylinder(double r, double low, double high, bool ends) {
  Profile profile;
  if (ends) profile.add({0, low}, {0, -1}), profile.add({r, low}, {0, -1});
  profile.add({r, low}, {1, 0}), profile.add({r, high}, {1, 0});
  if (ends) profile.add({r, high}, {0, 1}), profile.add({0, high}, {0, 1});
  return turned(profile, 32);
}

/// Flat faces, each a loop of points counter-clockwise from outside.
Mesh faces(const std::vector<std::vector<Vector3>>& loops) {
  Mesh mesh;
  for (const std::vector<Vector3>& loop : loops) {
    const int first = static_cast<int>(mesh.vertices.size());
    const Vector3 n = (loop[1] - loop[0]).cross(loop[2] - loop[0]).normalized();
    for (const Vector3& p : loop) mesh.vertices.push_back(p), mesh.normals.push_back(n);
    for (int i = 2; i < static_cast<int>(loop.size()); ++i)
      mesh.triangles.insert(mesh.triangles.end(), {first, first + i - 1, first + i});
  }
  return mesh;
}

/// A convex polygon of the xy plane, `depth` to both sides.
Mesh prism(const std::vector<Vector3>& base, double depth) {
  std::vector<std::vector<Vector3>> loops(2);
  const std::size_t n = base.size();
  const Vector3 up(0, 0, depth);
  for (std::size_t i = 0; i < n; ++i) {
    loops[0].push_back(base[i] + up);
    loops[1].push_back(base[n - 1 - i] - up);
    const Vector3 &p = base[i], &q = base[(i + 1) % n];
    loops.push_back({p - up, q - up, q + up, p + up});
  }
  return faces(loops);
}

Mesh rectangle(double x, double y, double depth) {
  return prism({{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}}, depth);
}

Mesh polyhedron(const Solid& solid) {
  std::vector<std::vector<Vector3>> loops;
  for (const std::vector<int>& face : solid.faces) {
    loops.emplace_back();
    for (const int i : face) loops.back().push_back(solid.vertices[static_cast<std::size_t>(i)]);
  }
  return faces(loops);
}

Mesh plain(const Solid& solid, double reach, double thin) {
  const Vector3& size = solid.size;
  switch (solid.kind) {
    case Kind::Sphere:
    case Kind::HollowSphere:
      return sphere(size.x());
    case Kind::Box:
      return rectangle(size.x() / 2, size.y() / 2, size.z() > 0 ? size.z() / 2 : thin);
    case Kind::Capsule:
      return capsule(size.x(), size.y());
    case Kind::Cylinder:
      return cylinder(size.x(), -size.y() / 2, size.y() / 2, true);
    case Kind::HollowCylinder: {
      const double half = size.y() > 0 ? size.y() / 2 : reach;
      return cylinder(size.x(), -half, half, false);
    }
    case Kind::Disc:
      return cylinder(size.x(), -thin, thin, true);
    case Kind::Ellipsoid: {
      Mesh mesh = sphere(1);
      for (Vector3& p : mesh.vertices) p = p.cwiseProduct(size);
      for (Vector3& n : mesh.normals) n = n.cwiseQuotient(size).normalized();
      return mesh;
    }
    case Kind::Plane:
      return faces({{{-reach, -reach, 0}, {reach, -reach, 0}, {reach, reach, 0}, {-reach, reach, 0}}});
    case Kind::Point:
      return sphere(2 * thin);
    case Kind::Stick: {
      Mesh mesh = cylinder(thin, 0, size.norm(), true);
      const Quaternion q = Quaternion::FromTwoVectors(Vector3::UnitZ(), size);
      for (Vector3& p : mesh.vertices) p = q * p;
      for (Vector3& n : mesh.normals) n = q * n;
      return mesh;
    }
    case Kind::Ellipse: {
      Mesh mesh = cylinder(1, -thin, thin, true);
      const Vector3 axes(size.x(), size.y(), 1);
      for (Vector3& p : mesh.vertices) p = p.cwiseProduct(axes);
      for (Vector3& n : mesh.normals) n = n.cwiseQuotient(axes).normalized();
      return mesh;
    }
    case Kind::Polygon:
      return prism(solid.vertices, thin);
    case Kind::Polyhedron:
      return polyhedron(solid);
  }
  return {};
}

}  // namespace

Mesh mesh_of(const Solid& solid, double reach, double thin) {
  Mesh mesh = plain(solid, reach, thin);
  for (Vector3& p : mesh.vertices) p = solid.place * p;
  for (Vector3& n : mesh.normals) n = solid.place.q * n;
  return mesh;
}

}  // namespace perp
