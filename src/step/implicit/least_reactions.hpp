// Reactions of least norm: of redundant contacts and joints those that share what they carry.
#pragma once

#include <vector>

#include "perp/solve/friction_solver.hpp"
#include "step/implicit/nonsmooth_newton.hpp"

namespace perp {

/// Of the reactions with the same sum of W p that the laws allow at the velocities u, those with the least sum of p², N s and
/// N m s counted alike: what sticks within its circular cone, what slides along its ray, joints freely. u below rounding of `speed`
/// is rest. Masses are those of `instant`. Reactions stay as they are where shorter ones are not found. Dense: O(m³) for m rows.
void take_least(const Model& model, const Instant& instant, double speed, std::vector<Reaction>& reactions);

/// Refuses what take_least does not know: `method` with least reactions where contacts have torsion or rolling.
void need_any_reactions(std::string_view method, const Model& model, Reactions reactions);

}  // namespace perp
