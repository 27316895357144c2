// Energy from nothing: which steps have some, and which of them may stand.
//
// A step may gain energy by the error of its method, which falls with h; one whose gain does not is wrong however well its equations
// hold. So a step whose gain is more than 1 % of the energies in it is computed again in halves, by the same method without memory,
// for the test alone: it stands if the halves gain at most .6 of that, and if on halving on the gain falls below 1 % within ten
// halvings. What the run answers is the step's own answer, to the last bit.
#pragma once

#include "perp/step/stepper.hpp"
#include "step/certificate/step_answer.hpp"

namespace perp {

/// What a step gained: what its works leave, with what pushing out gave unless the overlap is no deeper than that of the run's first
/// state (their sum counts; of a method of linearised gaps without a fifth of `measure`, which curvature explains); what the impulses of
/// an impact gave together (`struck`, Certificate::certify), which only take. Of a body that an impact changes, q moves at nu_q and not at the mean of
/// its velocities: what loads do along the difference is an error of the impact's time, no gain.
/// `measure`: kinetic energy, the sizes of all works, and w p^2/2 of the impulses, which is what they give a body at rest.
[[nodiscard]] StepGain gain_of(const Model& model, const Instant& start, const State& x, const State& moved,
                               const StepAnswer& answer, double struck, const StepRequest& request,
                               const StepReport& r);

}  // namespace perp
