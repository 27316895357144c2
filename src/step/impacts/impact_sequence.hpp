// Impacts one pair of bodies after the other.
#pragma once

#include "perp/step/impact.hpp"

namespace perp {

/// solve_impact with ImpactOrder::Sequential.
[[nodiscard]] Impact solve_in_sequence(const Model& model, const State& x, const ImpactOptions& options);

}  // namespace perp
