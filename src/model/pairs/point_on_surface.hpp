// A ball against a surface f = 0.
#pragma once

#include <array>
#include <span>

#include "model/pairs/witness.hpp"
#include "perp/model/shape.hpp"

namespace perp {

/// Where a surface is nearest to a point, in the surface's axes.
struct Foot {
  Vector3 x;        ///< on the surface
  Vector3 n;        ///< unit, outwards
  double distance;  ///< n . (point - x), negative inside [m]
};

/// The nearest foot of a point on a surface and the second nearest, if there is one that is no further by half the distance: a groove, the
/// two flanks of a cam. Newton's method on  x - c + λ ∇f = 0, f = 0  from points that go down to the surface from c, straight and from
/// around it. NaN of a foot that was not found to 1e-13 of the surface's size.
[[nodiscard]] int feet(const ImplicitSurface& surface, const Vector3& c, std::array<Foot, 2>& found);

/// The centre of B's sphere, blown up by its radius, on the surface of A at X_AS. Two points: the nearest feet, in an order of their places
/// and not of their distances, so that neither changes its number as they trade these.
class PointOnSurface {
 public:
  PointOnSurface(const ImplicitSurface& surface, const Pose& X_AS, const Vector3& centre, double radius)
      : surface_(surface), X_AS_(X_AS), centre_(centre), radius_(radius) {}

  int points() const { return 2; }
  double lever_a() const { return infinity; }
  double lever_b() const { return centre_.norm() + radius_; }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  const ImplicitSurface& surface_;
  const Pose& X_AS_;
  Vector3 centre_;
  double radius_;
};

}  // namespace perp
