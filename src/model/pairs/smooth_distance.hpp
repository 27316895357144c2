// The signed distance of two smooth convex solids, as a maximum over directions.
#pragma once

#include "perp/core/pose.hpp"
#include "perp/core/types.hpp"

namespace perp {

/// A convex solid by its support function along unit vectors n, in its body's axes: centre . n + s(n) + radius, where s is
///   √(nᵀ D n)                                            of an ellipsoid, and of a point (D = 0)
///   ‖(‖(a m_x, b m_y)‖_q2, c m_z)‖_q1,  m = Rᵀ n         of a superquadric: the dual norms, q = 2/(2 - e), of those that it is made of
/// and s(-n) = s(n).
struct SmoothSolid {
  Matrix3 D = Matrix3::Zero();  ///< [m^2]
  Vector3 centre = Vector3::Zero();
  double radius = 0;
  bool superquadric = false;
  Vector3 semi_axes = Vector3::Zero();
  Vector2 exponents = Vector2::Ones();  ///< e_1, e_2
  Matrix3 R = Matrix3::Identity();      ///< its own axes in the body's

  static SmoothSolid ellipsoid(const Vector3& semi_axes, const Pose& X);
  static SmoothSolid sphere(double radius, const Pose& X);
  static SmoothSolid make_superquadric(const Vector3& semi_axes, const Vector2& exponents, const Pose& X);
  double extent() const;  ///< no point is further from the centre [m]
  double reach() const { return centre.norm() + extent(); }
  SmoothSolid turned(const Matrix3& R_WB) const;  ///< in axes of the world, the centre left where it is
};

/// s, its gradient: the point that supports along n, and its Hessian. A superquadric's curvature vanishes along its axes where an exponent
/// is less than 1, and H has no bound; it is taken at directions no nearer to them than 1e-12.
struct Support {
  Support(const SmoothSolid& solid, const Vector3& n);
  double value = 0;
  Vector3 point = Vector3::Zero();
  Matrix3 H = Matrix3::Zero();
};

/// Where F(n) = n . (c_B - c_A) - s_A(n) - s_B(n) is largest over unit vectors n: the distance of the solids, or, negative, the least
/// translation that separates them.
struct SmoothDistance {
  Vector3 n = Vector3::UnitZ();  ///< from A to B
  double value = 0;              ///< F, without the radii [m]
  double residual =
      0;  ///< |P (b - a)|, P across n: how far the supporting points are from lying along n, over the solids' size [-]
  bool by_nlopt = false;
};

struct SmoothDistanceOptions {
  int newton_steps = 100;    ///< of each climb
  double tolerance = 1e-13;  ///< of the residual [-]: beyond, NLopt looks further
};

/// Newton's method on P (b - a) = 0: dn = -(P (H_A + H_B) P + F)⁻¹ P (b - a) uphill, shortened until F rises; from the line of centres,
/// and where that leads to an overlap, in which F has several maxima, also from the axes of both. Where it does not get to the tolerance,
/// NLopt's sequential quadratic programming goes on from there, and Newton from its end. `a` and `b` have axes of the world; d is c_B - c_A.
[[nodiscard]] SmoothDistance smooth_distance(const SmoothSolid& a, const SmoothSolid& b, const Vector3& d,
                                             const SmoothDistanceOptions& options = {});

}  // namespace perp
