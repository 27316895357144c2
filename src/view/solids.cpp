#include "perp/view/solids.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace perp {
namespace {

using Kind = Solid::Kind;

/// The two solids that a gap is between, from the numbers that its maker was given.
struct Pair {
  Solid a, b;
};

/// The numbers of a recipe, one argument after the other.
struct Arguments {
  const std::vector<double>& x;
  double number(std::size_t i) const { return x.at(i); }
  Vector3 vector(std::size_t i) const { return {x.at(i), x.at(i + 1), x.at(i + 2)}; }
  /// A half space whose z axis is the normal at `i`, through the point after it.
  Solid plane(std::size_t i) const {
    return {.kind = Kind::Plane,
            .place = {vector(i + 3), Quaternion::FromTwoVectors(Vector3::UnitZ(), vector(i))}};
  }
  Solid sphere(std::size_t i, Kind kind = Kind::Sphere) const {
    return {.kind = kind, .size = {number(i), 0, 0}};
  }
  Solid box(std::size_t i) const { return {.kind = Kind::Box, .size = vector(i)}; }
  Solid rectangle(std::size_t i) const { return {.kind = Kind::Box, .size = {number(i), number(i + 1), 0}}; }
};

using Maker = std::function<Pair(const Arguments&)>;

const std::map<std::string_view, Maker>& makers() {
  static const std::map<std::string_view, Maker> all = {
      {"sphere_on_plane",
       [](const Arguments& x) {
         return Pair{x.plane(1), x.sphere(0)};
       }},
      {"particle_on_plane",
       [](const Arguments& x) {
         return Pair{x.plane(0), {.kind = Kind::Point}};
       }},
      {"point_on_plane",
       [](const Arguments& x) {
         return Pair{x.plane(3), {.kind = Kind::Stick, .size = x.vector(0)}};
       }},
      {"capsule_on_plane",
       [](const Arguments& x) {
         return Pair{x.plane(2), {.kind = Kind::Capsule, .size = {x.number(0), x.number(1), 0}}};
       }},
      {"box_on_plane",
       [](const Arguments& x) {
         return Pair{x.plane(3), x.box(0)};
       }},
      {"ellipsoid_on_plane",
       [](const Arguments& x) {
         return Pair{
             x.plane(3),
             {.kind = Kind::Ellipsoid, .place = {x.vector(9), Quaternion::Identity()}, .size = x.vector(0)}};
       }},
      {"disc_on_plane",
       [](const Arguments& x) {
         return Pair{x.plane(1), x.sphere(0, Kind::Disc)};
       }},
      {"sphere_in_cylinder",
       [](const Arguments& x) {
         return Pair{{.kind = Kind::HollowCylinder,
                      .place = {x.vector(5), Quaternion::FromTwoVectors(Vector3::UnitZ(), x.vector(2))},
                      .size = {x.number(0), 0, 0}},
                     x.sphere(1)};
       }},
      {"sphere_on_sphere",
       [](const Arguments& x) {
         return Pair{x.sphere(0), x.sphere(1)};
       }},
      {"sphere_in_sphere",
       [](const Arguments& x) {
         return Pair{x.sphere(0, Kind::HollowSphere), x.sphere(1)};
       }},
      {"sphere_on_box",
       [](const Arguments& x) {
         return Pair{x.box(1), x.sphere(0)};
       }},
      {"box_on_box",
       [](const Arguments& x) {
         return Pair{x.box(0), x.box(3)};
       }},
      {"disc_on_line",
       [](const Arguments& x) {
         return Pair{x.plane(1), x.sphere(0, Kind::Disc)};
       }},
      {"disc_in_circle",
       [](const Arguments& x) {
         return Pair{x.sphere(0, Kind::HollowCylinder), x.sphere(1, Kind::Disc)};
       }},
      {"particle_in_circle",
       [](const Arguments& x) {
         return Pair{x.sphere(0, Kind::HollowCylinder), {.kind = Kind::Point}};
       }},
      {"ellipse_on_line",
       [](const Arguments& x) {
         return Pair{x.plane(2), {.kind = Kind::Ellipse, .size = {x.number(0), x.number(1), 0}}};
       }},
      {"rectangle_on_rectangle",
       [](const Arguments& x) {
         return Pair{x.rectangle(0), x.rectangle(2)};
       }},
      {"box_on_line",
       [](const Arguments& x) {
         return Pair{x.plane(2), x.rectangle(0)};
       }},
  };
  return all;
}

/// Circles of latitude from pole to pole.
void add_superquadric(const Vector3& a, double e1, double e2, Solid& solid) {
  constexpr int rings = 15, around = 24;
  constexpr double pi = 3.14159265358979323846;
  const auto power = [](double x, double e) { return std::copysign(std::pow(std::abs(x), e), x); };
  for (int i = 0; i <= rings + 1; ++i)
    for (int k = 0; k < around; ++k) {
      const double u = pi * (i / (rings + 1.0) - 0.5), v = 2 * pi * k / around;
      const double across = power(std::cos(u), e1);
      solid.vertices.emplace_back(a.x() * across * power(std::cos(v), e2),
                                  a.y() * across * power(std::sin(v), e2), a.z() * power(std::sin(u), e1));
      const int next = (k + 1) % around;
      if (i > 0)
        solid.faces.push_back(
            {(i - 1) * around + k, (i - 1) * around + next, i * around + next, i * around + k});
    }
}

/// What a body's own shape looks like.
Solid solid_of(const BodyShape& s) {
  using Of = Shape::Kind;
  const std::vector<double>& x = s.shape.sizes();
  const auto with = [&](Kind kind, const Vector3& size = Vector3::Zero()) {
    return Solid{.kind = kind, .place = s.pose, .size = size};
  };
  const auto round = [&](Kind kind) { return with(kind, {x[0], x.size() > 1 ? x[1] : 0, 0}); };
  switch (s.shape.kind()) {
    case Of::Sphere:
      return round(Kind::Sphere);
    case Of::HalfSpace:
      return with(Kind::Plane);
    case Of::Line: {
      Solid plane = with(Kind::Plane);
      plane.place = s.pose * Pose{Vector3::Zero(), rotation({-0.5 * 3.14159265358979323846, 0, 0})};
      return plane;
    }
    case Of::Box:
      return with(Kind::Box, {x[0], x[1], x[2]});
    case Of::PlanarBox:
      return with(Kind::Box, {x[0], x[1], 0});
    case Of::Capsule:
      return round(Kind::Capsule);
    case Of::Cylinder:
      return round(Kind::Cylinder);
    case Of::Disc:
    case Of::PlanarDisc:
      return round(Kind::Disc);
    case Of::Superquadric: {
      Solid solid = with(Kind::Polyhedron);
      add_superquadric({x[0], x[1], x[2]}, x[3], x[4], solid);
      return solid;
    }
    case Of::Ellipsoid:
      return with(Kind::Ellipsoid, {x[0], x[1], x[2]});
    case Of::Ellipse:
      return with(Kind::Ellipse, {x[0], x[1], 0});
    case Of::Formula:
      return with(Kind::Point);
    case Of::HollowSphere:
      return round(Kind::HollowSphere);
    case Of::HollowCylinder:
      return round(Kind::HollowCylinder);
    case Of::Polyhedron:
    case Of::Polygon:
      break;
  }
  Solid solid = with(s.shape.planar() ? Kind::Polygon : Kind::Polyhedron);
  solid.vertices = s.shape.vertices();
  solid.faces = s.shape.faces();
  return solid;
}

bool same(const Solid& x, const Solid& y) {
  return x.kind == y.kind && x.size == y.size && x.place.p == y.place.p &&
         x.place.q.coeffs() == y.place.q.coeffs() && x.vertices == y.vertices;
}

void add(std::vector<Solid>& solids, Solid solid) {
  const bool there =
      std::any_of(solids.begin(), solids.end(), [&](const Solid& s) { return same(s, solid); });
  if (!there) solids.push_back(std::move(solid));
}

/// Sticks between the joints of a body that has no solids, or from its origin to its only one.
void add_links(const Model& model, BodyId body, std::vector<Solid>& solids) {
  for (const JointGeometry& joint : model.joints())
    for (const auto& [id, anchor] : {std::pair(joint.a, joint.anchor_a), std::pair(joint.b, joint.anchor_b)})
      if (id == body && !anchor.isZero(0)) add(solids, {.kind = Kind::Stick, .size = anchor});
}

}  // namespace

std::string_view name_of(Solid::Kind kind) {
  constexpr std::string_view names[] = {
      "sphere",    "hollow_sphere", "box",   "capsule", "cylinder", "hollow_cylinder", "disc",
      "ellipsoid", "plane",         "point", "stick",   "ellipse",  "polygon",         "polyhedron"};
  return names[static_cast<std::size_t>(kind)];
}

std::vector<std::vector<Solid>> solids_of(const Model& model) {
  std::vector<std::vector<Solid>> solids(model.bodies().size());
  for (const Contact& contact : model.contacts()) {
    const Recipe& recipe = contact.gap.recipe();
    const auto maker = makers().find(recipe.maker);
    if (contact.stop.joint >= 0 || contact.own || maker == makers().end()) continue;
    Pair pair = maker->second({recipe.numbers});
    if (recipe.places.size() == 2) {
      pair.a.place = recipe.places[0] * pair.a.place;
      pair.b.place = recipe.places[1] * pair.b.place;
    }
    add(solids[static_cast<std::size_t>(contact.a.index)], pair.a);
    add(solids[static_cast<std::size_t>(contact.b.index)], pair.b);
  }
  for (const BodyShape& s : model.shapes()) add(solids[static_cast<std::size_t>(s.body.index)], solid_of(s));
  for (int b = 1; b < static_cast<int>(solids.size()); ++b)
    if (solids[static_cast<std::size_t>(b)].empty())
      add_links(model, {b}, solids[static_cast<std::size_t>(b)]);
  return solids;
}

double extent_of(const Solid& solid) {
  switch (solid.kind) {
    case Kind::Plane:
    case Kind::Point:
      return 0;
    case Kind::Box:
      return solid.size.norm() / 2;
    case Kind::Capsule:
      return solid.size.x() + solid.size.y() / 2;
    case Kind::Polygon:
    case Kind::Polyhedron: {
      double most = 0;
      for (const Vector3& v : solid.vertices) most = std::max(most, v.norm());
      return most;
    }
    default:
      return solid.size.cwiseAbs().maxCoeff();
  }
}

}  // namespace perp
