// The points where two solids are nearest to each other, and how they move with them.
#pragma once

#include <cmath>

#include "perp/model/gap.hpp"

namespace perp {

using Columns = ContactDerivative::Columns;  ///< by the twists of A and B

/// Nearest points a of A and b of B before both are blown up by their radii: b - a = distance normal.
struct Witness {
  Vector3 normal, a, b;
  double distance;

  /// The contact point half way between the surfaces.
  ContactPoint contact(double radius_a, double radius_b) const {
    return {.gap = distance - radius_a - radius_b,
            .normal = normal,
            .point = 0.5 * (a + b) + 0.5 * (radius_a - radius_b) * normal};
  }
  Witness in(const Pose& X, const Matrix3& R) const { return {R * normal, X.p + R * a, X.p + R * b, distance}; }
};

/// A vector and its derivative by both twists.
struct Moving {
  Vector3 x;
  Columns d = Columns::Zero();
};

inline Moving operator+(const Moving& p, const Moving& q) { return {p.x + q.x, p.d + q.d}; }
inline Moving operator-(const Moving& p, const Moving& q) { return {p.x - q.x, p.d - q.d}; }
inline Moving operator*(double s, const Moving& p) { return {s * p.x, s * p.d}; }
inline Moving cross(const Moving& p, const Moving& q) { return {p.x.cross(q.x), skew(p.x) * q.d - skew(q.x) * p.d}; }

/// A number and its derivative.
struct MovingNumber {
  double x;
  Eigen::Matrix<double, 1, 12> d;
};
inline MovingNumber dot(const Moving& p, const Moving& q) {
  return {p.x.dot(q.x), p.x.transpose() * q.d + q.x.transpose() * p.d};
}
inline Moving operator*(const MovingNumber& s, const Moving& p) { return {s.x * p.x, s.x * p.d + p.x * s.d}; }
inline Moving unit(const Moving& p) {
  const double norm = p.x.norm();
  const Vector3 n = p.x / norm;
  return {n, (p.d - n * (n.transpose() * p.d).eval()) / norm};
}

/// What is fixed in body A or B, at poses X.
struct FixedIn {
  int first;  ///< column: 0 of A, 6 of B
  const Pose& X;

  Moving point(const Vector3& x) const {
    Moving m{x};
    m.d.middleCols<3>(first).setIdentity();
    m.d.middleCols<3>(first + 3) = -skew(x - X.p);
    return m;
  }
  Moving direction(const Vector3& u) const {
    Moving m{u};
    m.d.middleCols<3>(first + 3) = -skew(u);
    return m;
  }
};

/// Witness points and normal that move.
struct MovingWitness {
  Moving normal, a, b;
  void contact(double radius_a, double radius_b, ContactDerivative& out) const {
    out = {};
    out.normal = normal.d;
    out.point = 0.5 * (a.d + b.d) + 0.5 * (radius_a - radius_b) * normal.d;
  }
};

}  // namespace perp
