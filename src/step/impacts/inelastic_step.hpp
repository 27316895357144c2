// A time step that always has an answer: for a state where accelerations do not.
#pragma once

#include "perp/step/stepper.hpp"

namespace perp {

/// The seed's (25), (26), (28), (32) over h with the circular cone and e = 0, all at once, by solve_friction; then the projection onto
/// the constraints. Order 1: for steps that are short beside everything else. False if it has no answer; x is then as it was.
[[nodiscard]] bool inelastic_step(const Model& model, State& x, double h, StepReport& report);

}  // namespace perp
