#include "perp/step/simulate.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "step/dense_output.hpp"

namespace perp {
namespace {

std::string sentence(const StepReport& report) {
  return "the step to t = " + shortest(report.t) + " s did not advance (" +
         std::string(name_of(report.status)) + "): " + report.message;
}

/// Contact rows to make room for: as many a step as the first step had, within bounds.
std::size_t room(std::size_t steps, std::size_t rows_a_step) {
  return std::min<std::size_t>(steps * rows_a_step, 1U << 22U);
}

/// What comes to pass in the step to x: logged, and done to x. Whether the run goes on.
bool pass_events(const Model& model, const std::vector<UserEvent>& events, Trajectory& run, State& x) {
  bool goes_on = true;
  for (const FoundEvent& found : find_events(model, events, run.back(), x)) {
    const UserEvent& event = events[found.index];
    run.events.push_back({.t = found.t, .kind = EventKind::User, .contact = event.name});
    if (event.then) goes_on = event.then(model, x) && goes_on;
  }
  return goes_on;
}

}  // namespace

StepFailure::StepFailure(StepReport report_, Trajectory trajectory_)
    : std::runtime_error(sentence(report_)), report(std::move(report_)), trajectory(std::move(trajectory_)) {}

Trajectory simulate(const Model& model, Stepper& stepper, const State& x0, const SimulateOptions& options) {
  model.check("simulate", x0);
  if (!std::isfinite(options.t_end) || !(options.t_end > x0.t))
    refuse("simulate", "t_end", options.t_end, "needs to be finite and past x.t = " + shortest(x0.t));
  auto* adaptive = dynamic_cast<AdaptiveStepper*>(&stepper);
  const bool no_steps = adaptive != nullptr && std::isnan(options.h);
  if (!no_steps && (!(options.h > 0) || !std::isfinite(options.h)))
    refuse("simulate", "h", options.h, "needs to be positive [s]");
  const double steps = no_steps ? 1 : std::max(1.0, std::round((options.t_end - x0.t) / options.h));
  if (steps > 1e9) refuse("simulate", "h", options.h, "needs more than 1e9 steps to t_end");

  State x = x0;
  model.follow_turns(x);
  StepReport report;
  if (options.project_initial) {
    const Projection projection = project_onto_constraints(model, x);
    if (!projection.reached) {
      report.t = x.t;
      report.gap_min = projection.gap_min;
      report.joint_error = projection.joint_error;
      report.message = "no state near the initial one satisfies its constraints";
      throw StepFailure(report, Trajectory(x0, 0));
    }
  }

  if (adaptive != nullptr) {
    Trajectory run(x, 0);
    report = adaptive->run(model, run,
                           {.t_end = options.t_end,
                            .h = no_steps ? not_set : (options.t_end - x0.t) / steps,
                            .progress = options.progress,
                            .events = options.events});
    if (!report.advanced()) throw StepFailure(std::move(report), std::move(run));
    return run;
  }

  const auto n = static_cast<std::size_t>(steps);
  const double length = options.t_end - x0.t, h = length / steps;
  Trajectory run(x, n);
  run.model = std::make_shared<const Model>(model);
  for (std::size_t k = 1; k <= n; ++k) {
    const double t = k == n ? options.t_end : x0.t + static_cast<double>(k) * length / steps;
    stepper.step(model, x, {.h = h, .t_end = t, .max_correction_speed = options.max_correction_speed},
                 report);
    if (!report.advanced()) throw StepFailure(std::move(report), std::move(run));
    if (k == 1) run.reserve_rows(room(n, report.contacts.size()), n * report.joints.size());
    const bool goes_on = options.events.empty() || pass_events(model, options.events, run, x);
    run.add(x, report);
    if (!goes_on) break;
    if (options.progress && !options.progress(x.t)) break;
  }
  return run;
}

}  // namespace perp
