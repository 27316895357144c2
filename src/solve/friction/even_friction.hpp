// Contact problems whose reactions are redundant, by the one rule for these.
#pragma once

#include "perp/solve/friction_solver.hpp"

namespace perp {

/// solve_friction of a local problem, and where its W is singular the solution that is the limit of
///   u = (W + eps C) r + q + eps k,   eps -> 0,
/// C (m, m) and k (m) the compliances of the rows (doc/methods/redundant.md): the problem with a small eps tells modes, those the
/// limit. Where there is no one limit, or it is not found, a solution near that of the small eps.
[[nodiscard]] FrictionSolution solve_evenly(const FrictionProblem& problem, const Matrix& C, const Vector& k,
                                            const FrictionOptions& options = {});

}  // namespace perp
