// A system that comes with its own generalized coordinates: joints that a user has eliminated by hand, as one body.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "perp/core/types.hpp"

namespace perp {

/// M(q) nu' = force(q, nu, t) + W p, q' = nu, with n coordinates, 1 <= n <= 6 (a wrench map's blocks have six rows).
struct GeneralizedSystem {
  std::function<Matrix(const Vector& q)> mass;  ///< (n, n), symmetric positive definite
  /// All but M nu' and contacts: weight, springs, and the terms of Coriolis and centrifugal forces that M(q) brings.
  std::function<Vector(const Vector& q, const Vector& nu, double t)> force;
  std::function<double(const Vector& q)> potential = {};  ///< [J], for Model::energy; empty: none
};

/// One contact of such a system with the ground, as functions of its coordinates.
struct GeneralizedPoint {
  double gap = infinity;  ///< psi_n(q, t) [m]; infinity: no such point now
  Vector normal = {};     ///< (n) its gradient by q: the column W_n
  Vector tangent = {};    ///< (n) the column W_t, of friction: sliding velocity tangent . nu + tangent_t
  double gap_t = 0;       ///< explicit time derivative of the gap [m/s]
  double tangent_t = 0;   ///< and of the sliding velocity [m/s]
};
/// Smooth in (q, t): what its columns add to accelerations is found by central differences over 4e-3 of each coordinate's unit
/// (and 4e-3 s); measure in units in which that is little. Where the point is not there all around, they count as constant.
using GeneralizedGap = std::function<GeneralizedPoint(const Vector& q, double t)>;

}  // namespace perp
