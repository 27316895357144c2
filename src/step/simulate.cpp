#include "perp/step/simulate.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"

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

}  // namespace

StepFailure::StepFailure(StepReport report_, Trajectory trajectory_)
    : std::runtime_error(sentence(report_)), report(std::move(report_)), trajectory(std::move(trajectory_)) {}

namespace {

/// What the options say once they are checked.
struct Plan {
  double t_start = 0, length = 0;
  double steps = 1;  ///< a whole number, of t_start to t_end
  double h = not_set;
  AdaptiveStepper* adaptive = nullptr;
};

Plan plan_of(const Model& model, Stepper& stepper, const State& x, const SimulateOptions& options) {
  model.check("simulate", x);
  if (!std::isfinite(options.t_end) || !(options.t_end > x.t))
    refuse("simulate", "t_end", options.t_end, "needs to be finite and past x.t = " + shortest(x.t));
  Plan plan;
  plan.adaptive = dynamic_cast<AdaptiveStepper*>(&stepper);
  plan.t_start = std::isnan(options.t_start) ? x.t : options.t_start;
  plan.length = options.t_end - plan.t_start;
  const bool no_steps = plan.adaptive != nullptr && std::isnan(options.h);
  if (!no_steps && (!(options.h > 0) || !std::isfinite(options.h)))
    refuse("simulate", "h", options.h, "needs to be positive [s]");
  if (!no_steps) plan.steps = std::max(1.0, std::round(plan.length / options.h));
  if (plan.steps > 1e15) refuse("simulate", "h", options.h, "needs more than 1e15 steps to t_end");
  if (!no_steps) plan.h = plan.length / plan.steps;
  if (!(plan.t_start <= x.t) || static_cast<double>(options.taken) >= plan.steps + (plan.adaptive != nullptr))
    refuse("simulate", "taken", static_cast<double>(options.taken),
           "needs to be a step before t_end, and t_start no later than x.t");
  return plan;
}

/// x as the run starts from it.
State first_state(const Model& model, const State& x0, const SimulateOptions& options) {
  State x = x0;
  model.follow_turns(x);
  if (!options.project_initial) return x;
  const Projection projection = project_onto_constraints(model, x);
  if (projection.reached) return x;
  StepReport report;
  report.t = x.t;
  report.gap_min = projection.gap_min;
  report.joint_error = projection.joint_error;
  report.message = "no state near the initial one satisfies its constraints";
  throw StepFailure(report, Trajectory(x0, 0));
}

/// Steps of fixed size from x, each given to `keep`, until one fails or `progress` ends it. The report is that of the last.
template <class Keep>
StepReport take_steps(const Model& model, Stepper& stepper, State& x, const SimulateOptions& options,
                      const Plan& plan, Keep keep) {
  StepReport report;
  const auto n = static_cast<std::size_t>(plan.steps);
  double first_overlap = options.first_overlap;
  if (std::isnan(first_overlap)) first_overlap = overlap(model, x);
  const std::size_t last = options.most > 0 ? std::min(n, options.taken + options.most) : n;
  for (std::size_t k = options.taken + 1; k <= last; ++k) {
    const double t =
        k == n ? options.t_end : plan.t_start + static_cast<double>(k) * plan.length / plan.steps;
    stepper.step(model, x,
                 {.h = plan.h,
                  .t_end = t,
                  .max_correction_speed = options.max_correction_speed,
                  .first_overlap = first_overlap},
                 report);
    if (!report.advanced()) break;
    keep(x, report);
    if (options.progress && !options.progress(x.t)) break;
  }
  return report;
}

}  // namespace

double overlap(const Model& model, const State& x) {
  Instant now;
  evaluate(model, x, now);
  return std::max({0.0, -now.gap_min(), now.joint_error()});
}

Trajectory simulate(const Model& model, Stepper& stepper, const State& x0, const SimulateOptions& options) {
  const Plan plan = plan_of(model, stepper, x0, options);
  State x = first_state(model, x0, options);
  const std::size_t n = plan.adaptive != nullptr ? 0 : static_cast<std::size_t>(plan.steps) - options.taken;
  Trajectory run(x, std::min<std::size_t>(n, 1U << 20U));
  StepReport report;
  if (plan.adaptive != nullptr)
    report =
        plan.adaptive->run(model, run, {.t_end = options.t_end, .h = plan.h, .progress = options.progress});
  else
    report = take_steps(model, stepper, x, options, plan, [&](const State& now, const StepReport& step) {
      if (run.steps() == 0) run.reserve_rows(room(n, step.contacts.size()), room(n, step.joints.size()));
      run.add(now, step);
    });
  if (!report.advanced()) throw StepFailure(std::move(report), std::move(run));
  return run;
}

RunEnd simulate(const Model& model, Stepper& stepper, const State& x0, const SimulateOptions& options,
                RunSink& sink) {
  const Plan plan = plan_of(model, stepper, x0, options);
  RunEnd end{.x = first_state(model, x0, options)};
  StepReport report;
  if (plan.adaptive == nullptr) {
    report = take_steps(model, stepper, end.x, options, plan, [&](const State& x, const StepReport& step) {
      sink.step(x, step);
      ++end.steps;
    });
  } else {
    Trajectory run(end.x, 0);
    const auto hand_on = [&] {
      for (std::size_t i = 0; i < run.steps(); ++i) sink.step(run.state(i + 1), run.report(i));
      for (const Event& event : run.events) sink.event(event);
      end.steps += run.steps();
      run = Trajectory(State(run.back()), 0);
    };
    report = plan.adaptive->run(model, run, {.t_end = options.t_end, .h = plan.h, .progress = [&](double t) {
                                               hand_on();
                                               return !options.progress || options.progress(t);
                                             }});
    end.evaluations = run.evaluations;
    hand_on();
    end.x = run.back();
  }
  if (!report.advanced()) throw StepFailure(std::move(report), Trajectory(end.x, 0));
  end.reached = end.x.t == options.t_end;
  return end;
}

}  // namespace perp
