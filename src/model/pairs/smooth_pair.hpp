// Two smooth convex solids: ellipsoids and spheres.
#pragma once

#include <span>

#include "model/pairs/witness.hpp"

namespace perp {

/// An ellipsoid blown up by a radius: its support function along the unit vector n is centre . n + √(nᵀ D n) + radius. D = 0: a sphere.
struct SmoothSolid {
  Matrix3 D;  ///< body axes [m^2]
  Vector3 centre;
  double radius;

  static SmoothSolid ellipsoid(const Vector3& semi_axes, const Pose& X);
  static SmoothSolid sphere(double radius, const Pose& X) { return {Matrix3::Zero(), X.p, radius}; }
  double reach() const { return centre.norm() + std::sqrt(D.trace()) + radius; }
};

/// The signed distance of convex solids is a maximum over directions n from A to B,
///   max F(n) = n . (centre_B - centre_A) - √(nᵀ D_A n) - √(nᵀ D_B n) - radii       (negative: the least translation that separates)
/// where b - a, between the points that support along n, is parallel to n. Newton's method on that condition, over the two angles of n,
/// (H_A + H_B + F) dn = P (b - a) with H the Hessian of √(nᵀ D n), each step shortened until F rises; from the line of centres, and
/// where that leads to an overlap also from the axes of both, of which the largest F counts.
class SmoothPair {
 public:
  SmoothPair(const SmoothSolid& a, const SmoothSolid& b) : a_(a), b_(b) {}

  int points() const { return 1; }
  double lever_a() const { return a_.reach(); }
  double lever_b() const { return b_.reach(); }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  SmoothSolid a_, b_;
};

}  // namespace perp
