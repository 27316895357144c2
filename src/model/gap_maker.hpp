// What the makers of gaps share: their arguments, checked and kept; planes in world axes.
#pragma once

#include <cmath>
#include <memory>

#include "perp/core/errors.hpp"
#include "perp/model/gaps.hpp"

namespace perp {

/// A length that a maker was given.
inline double length(const char* where, const char* argument, double value) {
  if (!(value > 0) || !std::isfinite(value))
    refuse(where, argument, value, "needs to be positive and finite [m]");
  return value;
}

/// The arguments of a maker, one after the other.
struct Arguments : std::vector<double> {
  Arguments& operator<<(double x) {
    push_back(x);
    return *this;
  }
  Arguments& operator<<(const Vector3& x) {
    insert(end(), x.begin(), x.end());
    return *this;
  }
  Arguments& operator<<(const Plane& plane) { return *this << plane.normal << plane.point; }
};

/// The gap of a shape with points(), lever_a(), lever_b(), evaluate(X_WA, X_WB, out) and differentiate(X_WA, X_WB, out).
template <class Shape>
Gap gap_of(std::string_view maker, Shape shape, const Arguments& arguments) {
  Gap gap =
      Gap::patch(shape.points(), [shape](const Pose& X_WA, const Pose& X_WB, double,
                                         std::span<ContactPoint> out) { shape.evaluate(X_WA, X_WB, out); });
  gap.differentiated_by(
      [shape](const Pose& X_WA, const Pose& X_WB, double, std::span<ContactDerivative> out) {
        for (ContactDerivative& d : out) d = {};
        shape.differentiate(X_WA, X_WB, out);
      });
  gap.levers(shape.lever_a(), shape.lever_b());
  gap.made_by({maker, arguments, {}});
  return gap;
}

/// The gap of a pair of shapes: the same concept, shared by its copies; its `differentiate` clears what it fills.
template <class Pair>
Gap gap_of_pair(std::string_view maker, Pair made, const Arguments& arguments) {
  const auto pair = std::make_shared<const Pair>(std::move(made));
  Gap gap = Gap::patch(pair->points(), [pair](const Pose& X_WA, const Pose& X_WB, double,
                                              std::span<ContactPoint> out) { pair->evaluate(X_WA, X_WB, out); });
  gap.differentiated_by([pair](const Pose& X_WA, const Pose& X_WB, double, std::span<ContactDerivative> out) {
    pair->differentiate(X_WA, X_WB, out);
  });
  gap.levers(pair->lever_a(), pair->lever_b());
  gap.made_by({maker, arguments, {}});
  return gap;
}

// The twelve columns of a ContactDerivative.
inline auto v_A(ContactDerivative::Columns& columns) { return columns.middleCols<3>(0); }
inline auto w_A(ContactDerivative::Columns& columns) { return columns.middleCols<3>(3); }
inline auto v_B(ContactDerivative::Columns& columns) { return columns.middleCols<3>(6); }
inline auto w_B(ContactDerivative::Columns& columns) { return columns.middleCols<3>(9); }

/// A plane as given, its normal made a unit vector.
inline Plane unit(const char* where, const Plane& plane) {
  const double n = plane.normal.norm();
  if (!(n > 0) || !std::isfinite(n)) refuse(where, "plane.normal", n, "needs a direction");
  if (!plane.point.allFinite()) refuse(where, "plane.point", "not finite", "needs finite entries [m]");
  return {plane.normal / n, plane.point};
}

/// A plane of A in world axes.
struct WorldPlane {
  Vector3 normal;
  double offset;
  WorldPlane(const Plane& plane, const Pose& X_WA)
      : normal(X_WA.q * plane.normal), offset(normal.dot(X_WA * plane.point)) {}
  double distance(const Vector3& x) const { return normal.dot(x) - offset; }
};

}  // namespace perp
