// The derivative of a run that locates events.
#pragma once

#include "perp/step/event_driven.hpp"
#include "step/sensitivity/parameters_along.hpp"

namespace perp {

/// Runs `stepper` from x and carries the tangent from there to the end, whose state it returns; out.missing and out.steps are added to.
/// Throws StepFailure where the run does not come to t_end.
State carry_through_events(const Model& model, const EventDriven& stepper, const State& x,
                           const SensitivityOptions& options, ParametersAlong& along, Eigen::Index parameters,
                           StateTangent& tangent, Sensitivity& out);

}  // namespace perp
