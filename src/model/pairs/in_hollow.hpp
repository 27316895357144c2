// What is inside a hollow sphere or a hollow cylinder.
#pragma once

#include <span>

#include "model/pairs/polytope.hpp"
#include "model/pairs/witness.hpp"

namespace perp {

/// Corners of B, which outlives the pair, blown up by its radius, within the distance R of A's origin, or of A's z axis: a convex solid is inside when they are.
class InHollow {
 public:
  InHollow(double radius, bool cylinder, const Pose& X_AS, const Polytope& b);

  int points() const { return static_cast<int>(b_.corners.size()); }
  double lever_a() const { return cylinder_ ? infinity : X_AS_.p.norm(); }
  double lever_b() const { return b_.reach(); }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  double radius_;
  bool cylinder_;
  Pose X_AS_;
  const Polytope& b_;
};

}  // namespace perp
