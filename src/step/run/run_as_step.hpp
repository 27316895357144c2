// A run of a method that locates events, as one step.
#pragma once

#include "step/events/event_run.hpp"

namespace perp {

/// Rows of a run, and the report of its last, as one step of h: impulses and works are sums, residuals the largest. x moves to the end
/// of the rows if the run came to its end.
void take_as_step(const Trajectory& rows, const StepReport& last, double h, State& x, StepReport& report);

}  // namespace perp
