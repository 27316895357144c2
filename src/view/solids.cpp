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
  /// A corner: what is between it and the body's origin is all that is known of the body.
  Solid stick(std::size_t i) const {
    return {.kind = vector(i).isZero(0) ? Kind::Point : Kind::Stick, .size = vector(i)};
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
         return Pair{x.plane(3), x.stick(0)};
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

bool same(const Solid& x, const Solid& y) {
  return x.kind == y.kind && x.size == y.size && x.place.p == y.place.p &&
         x.place.q.coeffs() == y.place.q.coeffs() && x.vertices == y.vertices;
}

void add(std::vector<Solid>& solids, Solid solid) {
  const bool there =
      std::any_of(solids.begin(), solids.end(), [&](const Solid& s) { return same(s, solid); });
  if (!there) solids.push_back(std::move(solid));
}

/// The solid box that has a body's mass and inertia, along its principal axes: edges a of m/12 (b² + c²), ...
Solid box_of_inertia(const Body& body) {
  const Inertia inertia(body.mass, body.J);
  const Vector3& I = inertia.principal_moments();
  Vector3 size;
  for (int i = 0; i < 3; ++i)
    size[i] = std::sqrt(std::max(0.0, 6 / body.mass * (I[(i + 1) % 3] + I[(i + 2) % 3] - I[i])));
  return {.kind = Kind::Box,
          .place = {Vector3::Zero(), Quaternion(inertia.principal_axes())},
          .size = size,
          .inferred = true};
}

/// The joints that a body turns about, in its axes: of one that slides along a guide no point is its own.
std::vector<Vector3> pivots_of(const Model& model, BodyId body) {
  std::vector<Vector3> pivots;
  for (const JointGeometry& joint : model.joints()) {
    if (joint.kind == JointKind::Prismatic) continue;
    if (joint.a == body) pivots.push_back(joint.anchor_a);
    if (joint.b == body) pivots.push_back(joint.anchor_b);
  }
  return pivots;
}

/// Sticks from the body's origin to its joints where these are not on its solids.
void add_links(const Model& model, BodyId body, std::vector<Solid>& solids) {
  const std::size_t own = solids.size();
  for (const Vector3& p : pivots_of(model, body)) {
    const bool held = std::any_of(solids.begin(), solids.begin() + static_cast<std::ptrdiff_t>(own),
                                  [&](const Solid& s) { return (p - s.place.p).norm() <= extent_of(s); });
    if (!held && !p.isZero(0)) add(solids, {.kind = Kind::Stick, .size = p});
  }
}

/// The box of the inertia of a body that is not a link between joints: of a top, of a pad on a guide, of a body that flies.
void add_box(const Model& model, BodyId id, std::vector<Solid>& solids) {
  const Body& body = model.body(id);
  const std::vector<Vector3> pivots = pivots_of(model, id);
  if (body.kind != BodyKind::Spatial || pivots.size() > 1) return;
  const Solid box = box_of_inertia(body);
  constexpr double stout = 1.2;  // a box that reaches further is that of a link whose mass is along it
  const double reach = pivots.empty() ? infinity : pivots[0].norm();
  if (reach == 0 || extent_of(box) <= stout * reach) add(solids, box);
}

/// Whether a picture of the solid alone shows where its body is.
bool shows_a_body(const Solid& s) { return s.kind != Kind::Plane; }

}  // namespace

std::string_view name_of(Solid::Kind kind) {
  constexpr std::string_view names[] = {
      "sphere",    "hollow_sphere", "box",   "capsule", "cylinder", "hollow_cylinder", "disc",
      "ellipsoid", "plane",         "point", "stick",   "ellipse",  "polygon",         "polyhedron"};
  return names[static_cast<std::size_t>(kind)];
}

Solid solid_of(const Shape& shape, const Pose& pose) {
  using Of = Shape::Kind;
  const std::vector<double>& x = shape.sizes();
  const auto with = [&](Kind kind, const Vector3& size = Vector3::Zero()) {
    return Solid{.kind = kind, .place = pose, .size = size};
  };
  const auto round = [&](Kind kind) { return with(kind, {x[0], x.size() > 1 ? x[1] : 0, 0}); };
  switch (shape.kind()) {
    case Of::Sphere:
      return round(Kind::Sphere);
    case Of::HalfSpace:
      return with(Kind::Plane);
    case Of::Line: {
      Solid plane = with(Kind::Plane);
      plane.place = pose * Pose{Vector3::Zero(), rotation({-0.5 * 3.14159265358979323846, 0, 0})};
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
  Solid solid = with(shape.planar() ? Kind::Polygon : Kind::Polyhedron);
  solid.vertices = shape.vertices();
  solid.faces = shape.faces();
  return solid;
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
  for (const BodyShape& s : model.shapes())
    add(solids[static_cast<std::size_t>(s.body.index)], solid_of(s.shape, s.pose));
  for (int b = 1; b < static_cast<int>(solids.size()); ++b) {
    std::vector<Solid>& own = solids[static_cast<std::size_t>(b)];
    if (std::none_of(own.begin(), own.end(), shows_a_body)) add_box(model, {b}, own);
    add_links(model, {b}, own);
  }
  return solids;
}

Outline outline_of(const Solid& solid) {
  const auto corners = [&](const Vector3& half) {
    std::vector<Vector3> all;
    for (int k = 0; k < 8; ++k)
      all.emplace_back(half.x() * (k & 1 ? 1 : -1), half.y() * (k & 2 ? 1 : -1), half.z() * (k & 4 ? 1 : -1));
    return all;
  };
  const Vector3 across(solid.size.x(), solid.size.x(), 0);  // of what is round about z
  Outline outline;
  switch (solid.kind) {
    case Kind::Plane:
      break;
    case Kind::Point:
      outline.points = {Vector3::Zero()};
      break;
    case Kind::Stick:
      outline.points = {Vector3::Zero(), solid.size};
      break;
    case Kind::Sphere:
    case Kind::HollowSphere:
      outline = {{Vector3::Zero()}, solid.size.x()};
      break;
    case Kind::Box:
      outline.points = corners(0.5 * solid.size);
      break;
    case Kind::Ellipsoid:
    case Kind::Ellipse:
      outline.points = corners(solid.size);
      break;
    case Kind::Capsule:
      outline = {{{0, 0, -0.5 * solid.size.y()}, {0, 0, 0.5 * solid.size.y()}}, solid.size.x()};
      break;
    case Kind::Cylinder:
    case Kind::HollowCylinder:
      outline.points = corners(across + Vector3(0, 0, 0.5 * solid.size.y()));
      break;
    case Kind::Disc:
      outline.points = corners(across);
      break;
    case Kind::Polygon:
    case Kind::Polyhedron:
      outline.points = solid.vertices;
      break;
  }
  for (Vector3& p : outline.points) p = solid.place * p;
  return outline;
}

double extent_of(const Solid& solid) {
  double most = 0;
  const Outline outline = outline_of({.kind = solid.kind, .size = solid.size, .vertices = solid.vertices});
  for (const Vector3& p : outline.points) most = std::max(most, p.norm() + outline.margin);
  return most;
}

}  // namespace perp
