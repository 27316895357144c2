// What pairs need to know of a shape that sits in a body, made once.
#pragma once

#include <memory>
#include <optional>

#include "model/pairs/polytope.hpp"
#include "model/pairs/round_on_plane.hpp"
#include "model/pairs/smooth_pair.hpp"
#include "perp/model/shape.hpp"

namespace perp {

/// A shape at X_BS, all in the body's axes. The parts that its kind does not have are empty.
struct ShapeGeometry {
  ShapeGeometry(const Shape& shape, const Pose& X_BS);

  Shape::Kind kind;
  std::string_view name;
  Pose place;                        ///< X_BS, its quaternion of unit length
  double radius = 0;                 ///< of hollows
  std::optional<Polytope> polytope;  ///< of what has flat faces, corners and edges, blown up by a radius
  std::optional<SmoothSolid>
      smooth;                  ///< of spheres, ellipsoids, superquadrics; in the plane of discs and ellipses
  std::optional<Rims> rims;    ///< of discs and cylinders
  std::optional<Plane> plane;  ///< the boundary of half spaces and lines
  std::shared_ptr<const ImplicitSurface> surface;  ///< of formulas
  double reach;  ///< of its points from `place.p`; infinity of what has no end [m]
  double lever;  ///< likewise from the body's origin
};

/// Two shapes, either of which may be A: looks at what it needs of them and keeps nothing.
class ShapePair {
 public:
  /// Both outlive it.
  ShapePair(const ShapeGeometry& a, const ShapeGeometry& b);

  bool known() const { return kind_ != Kind::None; }  ///< the others need it
  int points() const;
  double lever_a() const { return a_.lever; }
  double lever_b() const { return b_.lever; }
  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

  /// No point has a smaller gap than this, which costs little [m].
  double at_least(const Pose& X_WA, const Pose& X_WB) const;

 private:
  enum class Kind { None, Polytopes, InHollow, RimsOnPlane, SmoothOnPlane, Smooth, PointOnSurface };
  static Kind kind_of(const ShapeGeometry& first, const ShapeGeometry& second);
  template <class Use>
  auto with(Use use) const;  // use(pair, first in front)

  const ShapeGeometry &a_, &b_;
  Kind kind_;
  bool exchanged_ = false;  // the pair has b_ in front
};

}  // namespace perp
