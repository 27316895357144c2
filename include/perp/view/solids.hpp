// What bodies look like: solids made from what a model's contacts and joints say of their bodies.
#pragma once

#include <string>
#include <vector>

#include "perp/model/model.hpp"

namespace perp {

/// A solid to draw, at `place` in its body's axes. Sizes [m]:
///   Sphere         size.x the radius                            HollowSphere    the same, seen from inside
///   Box            full edges
///   Capsule        radius, length of the cylinder between the caps; axis z
///   Cylinder       radius, length; axis z                       HollowCylinder  the same without ends, seen from inside
///   Disc           radius: thin, in the xy plane                Ellipsoid       semi-axes
///   Plane          the half space z < 0; it has no end: a picture shows the part that matters
///   Point          of no size: a dot                            Stick           from the origin to `size`: a link or a leg
///   Ellipse        semi-axes in the xy plane, of planar scenes  Polygon         `vertices` in the xy plane, in order
///   Polyhedron     `vertices`, and `faces` as loops of their numbers, counter-clockwise from outside
struct Solid {
  enum class Kind {
    Sphere,
    HollowSphere,
    Box,
    Capsule,
    Cylinder,
    HollowCylinder,
    Disc,
    Ellipsoid,
    Plane,
    Point,
    Stick,
    Ellipse,
    Polygon,
    Polyhedron
  };
  Kind kind = Kind::Sphere;
  Pose place = {};
  Vector3 size = Vector3::Zero();
  std::vector<Vector3> vertices = {};
  std::vector<std::vector<int>> faces = {};
  bool inferred =
      false;  ///< the box of a body's inertia, where nothing says what it looks like: drawn so that one sees through it
};

[[nodiscard]] std::string_view name_of(Solid::Kind kind);  ///< "sphere", "hollow_sphere", ...

[[nodiscard]] Solid solid_of(const Shape& shape, const Pose& pose);

/// The solids of every body of the model (the ground's first): its shapes, and those that its contacts' gaps are between, each once. Where
/// these do not show a body, sticks from its origin to its joints; of a spatial body with one joint or none also the box that has its mass
/// and inertia. A body that has nothing of these gets an empty list, and is drawn as its axes.
[[nodiscard]] std::vector<std::vector<Solid>> solids_of(const Model& model);

/// What holds a solid: the convex hull of `points`, in its body's axes, with `margin` around it. No points of what has no end.
struct Outline {
  std::vector<Vector3> points;
  double margin = 0;  ///< [m]
};
[[nodiscard]] Outline outline_of(const Solid& solid);

/// How far a solid reaches from its own origin [m]; zero of planes, dots.
[[nodiscard]] double extent_of(const Solid& solid);

}  // namespace perp
