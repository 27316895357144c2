// Ellipsoids about the origin: what bounds friction beside a normal reaction, of two or three rows.
//
//   E = {x : sum_k (x_k / a_k)^2 <= 1},   x_k = 0 where a_k = 0                              (1)
// with semi-axes a >= 0: a row that is not there, or that does not push, is an axis of length zero. A normal reaction s makes it s E.
#pragma once

#include "perp/core/types.hpp"

namespace perp {

/// max over x in E of x.u = |diag(a) u|: what friction of unit size can do against u. Its derivative where it has one, else zero.
inline double ellipsoid_support(const Vector3& axes, const Vector3& u) { return axes.cwiseProduct(u).norm(); }
Vector3 ellipsoid_support_gradient(const Vector3& axes, const Vector3& u);

/// The size s at which x lies on the surface of s E; infinite where x sticks out along an axis of length zero.
double ellipsoid_gauge(const Vector3& axes, const Vector3& x);

/// The point of s E next to z, and how it moves with z and s.
struct EllipsoidProjection {
  Vector3 p;
  bool inside = false;    ///< p = z (on the axes that are there)
  double multiplier = 0;  ///< t of z_k - p_k = t p_k / (s a_k)^2; zero inside
};

/// The projection of z on s E, s >= 0. Outside, (1) and z_k - p_k = t p_k / (s a_k)^2 leave one equation in t,
///   |e(t)| = 1,   e_k = s a_k z_k / ((s a_k)^2 + t),                                        (2)
/// solved by Newton's method on 1/|e| - 1, concave in t, from below. For a ball the start solves it.
EllipsoidProjection project_on_ellipsoid(const Vector3& axes, double size, const Vector3& z);

/// Derivatives of p at (z, s), from one side where there are two: with D = diag((s a)^2 / ((s a)^2 + t)) and the normal
/// n = p / (s a)^2, dp/dz = D - D n (D n)ᵀ / (nᵀ D n), dp/ds = (p - dp/dz z) / s, p being homogeneous in (z, s).
struct EllipsoidSlope {
  Matrix3 dz;
  Vector3 ds;
};
EllipsoidSlope differentiate(const EllipsoidProjection& at, const Vector3& axes, double size,
                             const Vector3& z);

}  // namespace perp
