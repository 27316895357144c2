#include "perp/step/extrapolated.hpp"

#include <cmath>

#include "perp/core/errors.hpp"
#include "step/extrapolated/extrapolated_flow.hpp"
#include "step/run/run_as_step.hpp"

namespace perp {
namespace {

constexpr int highest_order = 2 * (ExtrapolatedFlow::most_columns - 1);

/// What event thresholds are measured by: the run's tolerance. Of fixed steps it is the default, whatever their errors: a root that
/// starts from zero is judged by rounding and the projection, which they do not spoil.
EventDrivenOptions events_of(const ExtrapolatedOptions& options) {
  return {.rtol = options.rtol,
          .atol = options.atol,
          .restitution = options.restitution,
          .impacts = options.impacts,
          .look = options.look,
          .max_evaluations = options.max_evaluations};
}

MakeIntegrator flow_of(const ExtrapolatedOptions& options) {
  const ExtrapolatedFlow::Options how{.order = options.order,
                                      .rtol = options.rtol,
                                      .atol = std::isnan(options.atol) ? options.rtol : options.atol};
  return [how](ModeDynamics& dynamics) { return std::make_unique<ExtrapolatedFlow>(dynamics, how); };
}

}  // namespace

Extrapolated::Extrapolated(ExtrapolatedOptions options) : options_(options) {
  if (options.order < 0 || options.order > highest_order || options.order % 2 != 0)
    refuse("Extrapolated", "order", static_cast<double>(options.order),
           "needs to be even, from 2 to " + std::to_string(highest_order) + ", or 0: chosen");
  (void)EventDriven(events_of(options));  // refuses the others
}

StepReport Extrapolated::run(const Model& model, Trajectory& run, const RunRequest& request) {
  const EventDrivenOptions events = events_of(options_);
  EventRun event_run(model, events, flow_of(options_), flow_of(options_), run);
  (void)event_run.run(request);
  return event_run.report;
}

void Extrapolated::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Trajectory rows(x, 0);
  take_as_step(rows, run(model, rows, {.t_end = request.t_end}), request.h, x, report);
}

}  // namespace perp
