// Two smooth convex solids, or one on a plane.
#pragma once

#include <span>

#include "model/pairs/smooth_distance.hpp"
#include "model/pairs/witness.hpp"
#include "perp/model/gaps.hpp"

namespace perp {

/// Ellipsoids, superquadrics and spheres: one point, where they are nearest (smooth_distance).
class SmoothPair {
 public:
  SmoothPair(const SmoothSolid& a, const SmoothSolid& b) : a_(a), b_(b) {}

  int points() const { return 1; }
  double lever_a() const { return a_.reach(); }
  double lever_b() const { return b_.reach(); }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  const SmoothSolid &a_, &b_;
};

/// The lowest point of a smooth solid of B over a plane of A.
class SmoothOnPlane {
 public:
  SmoothOnPlane(const Plane& plane, const SmoothSolid& b) : plane_(plane), b_(b) {}

  int points() const { return 1; }
  double lever_a() const { return infinity; }
  double lever_b() const { return b_.reach(); }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  const Plane& plane_;
  const SmoothSolid& b_;
};

}  // namespace perp
