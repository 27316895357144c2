// Whether linear inequalities can be met, answered by a point or by a proof that none exists.
#pragma once

#include "perp/core/types.hpp"

namespace perp {

enum class Feasibility { Feasible, Infeasible, Unknown };

struct FeasibilityAnswer {
  Feasibility status = Feasibility::Unknown;
  Vector z{};  ///< (n): a point z >= 0 with A z + b >= 0 and least cᵀ z, if Feasible; else empty
  Vector y{};  ///< (m): y >= 0, Aᵀ y <= 0, bᵀ y < 0, if Infeasible; else empty
  int pivots = 0;
};

/// The linear program: min cᵀ z over z >= 0 with A z + b >= 0, for c >= 0. Its conditions for an optimum,
///   0 <= z ⟂ c - Aᵀ y >= 0,   0 <= y ⟂ A z + b >= 0,
/// are an LCP with a skew matrix, for which Lemke's method ends at an optimum or on a ray that gives the
/// certificate; Unknown is rounding alone. A (m, n), b (m), c (n).
[[nodiscard]] FeasibilityAnswer find_feasible(const Matrix& A, const Vector& b, const Vector& c);

}  // namespace perp
