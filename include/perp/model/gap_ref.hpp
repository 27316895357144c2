// The gap of a contact of a model: one that was listed with it, or that of two shapes.
#pragma once

#include <span>

#include "perp/model/gap.hpp"

namespace perp {

struct ShapeGeometry;  // a shape in its body, as pairs look at it

/// Gap's own calls. Refers to what a model has, and lives no longer than it.
class GapRef {
 public:
  explicit GapRef(const Gap& listed) : listed_(&listed) {}
  GapRef(const ShapeGeometry& a, const ShapeGeometry& b) : a_(&a), b_(&b) {}

  int points() const;
  double lever_a() const;
  double lever_b() const;
  const Recipe& recipe() const;  ///< empty of shapes: they say themselves what they are
  void operator()(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactDerivative> out) const;
  /// No point has a smaller gap; -infinity of listed gaps.
  double at_least(const Pose& X_WA, const Pose& X_WB) const;

 private:
  const Gap* listed_ = nullptr;
  const ShapeGeometry *a_ = nullptr, *b_ = nullptr;
};

}  // namespace perp
