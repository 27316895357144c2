// The shortest reactions among those that give one velocity.
#pragma once

#include <optional>

#include "solve/friction/contact_system.hpp"

namespace perp {

/// min |r|² over W r = W r0, r_i in K_i(u): {0} where u_N > 0, the ray of sliding where u_T != 0, the whole set K_i
/// where u = 0. In the dual, r = P_K(u)(Wᵀ λ) with W r = W r0: a semismooth Newton method on λ. All in the problem's
/// own units, W dense. Empty if the method did not come to an answer, and where a block has moments, two coefficients, or
/// a bound of constant size over several rows.
std::optional<Vector> minimum_norm_reactions(const FrictionProblem& problem, const Matrix& W,
                                             const Vector& r0, const Vector& u);

}  // namespace perp
