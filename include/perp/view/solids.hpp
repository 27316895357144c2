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
};

[[nodiscard]] std::string_view name_of(Solid::Kind kind);  ///< "sphere", "hollow_sphere", ...

/// The solids of every body of the model (the ground's first): its shapes, and those that its contacts' gaps are between, each once; where a
/// body has none, sticks from its origin to its joints. A body that has neither gets an empty list, and is drawn as its axes.
[[nodiscard]] std::vector<std::vector<Solid>> solids_of(const Model& model);

/// Half of the longest of a solid's edges, as a measure of it; zero of planes, dots.
[[nodiscard]] double extent_of(const Solid& solid);

}  // namespace perp
