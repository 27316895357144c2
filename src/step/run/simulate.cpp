#include "perp/step/simulate.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "step/events/event_watch.hpp"
#include "step/run/dense_output.hpp"

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
  stepper.need_known_laws(model);
  if (!std::isfinite(options.t_end) || !(options.t_end > x.t))
    refuse("simulate", "t_end", options.t_end, "needs to be finite and past x.t = " + shortest(x.t));
  check_events(options.events);
  Plan plan;
  plan.adaptive = dynamic_cast<AdaptiveStepper*>(&stepper);
  plan.t_start = std::isnan(options.t_start) ? x.t : options.t_start;
  plan.length = options.t_end - plan.t_start;
  const bool no_steps = chooses_steps(stepper) && std::isnan(options.h);
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

/// Steps of fixed size, each given to a sink, and what the user's events do between them.
class FixedSteps {
 public:
  FixedSteps(const Model& model, Stepper& stepper, const SimulateOptions& options, const Plan& plan,
             RunSink& sink)
      : model_(model), stepper_(stepper), options_(options), plan_(plan), sink_(sink) {}

  /// From x until one fails, `progress` or an event ends it.
  void take(State& x);

  StepReport report;       ///< of the last step
  std::size_t taken = 0;   ///< of the grid's
  std::string stopped_by;  ///< the event that ended it

 private:
  bool step(State& x, double h, double t_end);
  bool fail(StepStatus status, const std::string& why);
  bool through_events(EventWatch& watch, State a, State& x);
  bool act_at(EventWatch& watch, std::size_t index, State& x);
  void log(const EventWatch& watch, const std::vector<EventWatch::Found>& found);

  const Model& model_;
  Stepper& stepper_;
  const SimulateOptions& options_;
  const Plan& plan_;
  RunSink& sink_;
  double first_overlap_ = not_set;
};

bool FixedSteps::step(State& x, double h, double t_end) {
  stepper_.step(model_, x,
                {.h = h,
                 .t_end = t_end,
                 .max_correction_speed = options_.max_correction_speed,
                 .first_overlap = first_overlap_},
                report);
  return report.advanced();
}

bool FixedSteps::fail(StepStatus status, const std::string& why) {
  report.status = status;
  report.message = why;
  return false;
}

void FixedSteps::take(State& x) {
  const auto n = static_cast<std::size_t>(plan_.steps);
  first_overlap_ = std::isnan(options_.first_overlap) ? overlap(model_, x) : options_.first_overlap;
  EventWatch watch(model_, options_.events, x, options_.taken > 0 ? plan_.h / 8 : 0);
  const std::size_t last = options_.most > 0 ? std::min(n, options_.taken + options_.most) : n;
  for (std::size_t k = options_.taken + 1; k <= last; ++k) {
    const double t =
        k == n ? options_.t_end : plan_.t_start + static_cast<double>(k) * plan_.length / plan_.steps;
    const State before = options_.events.empty() ? State{} : x;
    if (!step(x, plan_.h, t)) return;
    if (options_.events.empty())
      sink_.step(x, report);
    else if (!through_events(watch, before, x))
      return;
    ++taken;
    if (options_.progress && !options_.progress(x.t)) return;
  }
}

void FixedSteps::log(const EventWatch& watch, const std::vector<EventWatch::Found>& found) {
  for (const auto& [t, index] : found)
    sink_.event({.t = t, .kind = EventKind::User, .contact = watch.event(index).name});
}

/// What an event does to x; whether the run goes on.
bool FixedSteps::act_at(EventWatch& watch, std::size_t index, State& x) {
  watch.arrived(index, x);
  StepReport changed;
  const EventDone done = act(watch.event(index), model_, x, changed);
  if (done.changed && !meet_joints(model_, x, changed))
    return fail(StepStatus::NotSolved, "event '" + watch.event(index).name +
                                           "' has set velocities that joints do not allow, and none were "
                                           "found that they do");
  if (done.changed) sink_.step(x, changed);
  if (!done.goes_on) stopped_by = watch.event(index).name;
  return done.goes_on;
}

/// Gives the step from a to x to the sink; where an event does something in it, up to there, and then again what is left of it.
bool FixedSteps::through_events(EventWatch& watch, State a, State& x) {
  const double t_end = x.t;
  constexpr double nearly = 1e-6;  // of a step: what is nearer to its end happens there
  constexpr int most = 40;
  for (int n = 0; n < most; ++n) {
    std::vector<EventWatch::Found> found;
    try {
      found = watch.find(a, x);
    } catch (const std::domain_error& error) {
      return fail(StepStatus::NotFinite, error.what());
    }
    if (found.empty() || !watch.event(found.back().index).then) {
      sink_.step(x, report);
      log(watch, found);
      return true;
    }
    const auto [t, index] = found.back();
    if (t - a.t < nearly * plan_.h) {
      x = a;  // its row is there
    } else {
      if (t_end - t >= nearly * plan_.h) {
        x = a;
        if (!step(x, t - a.t, t)) return false;
      }
      sink_.step(x, report);
    }
    log(watch, found);
    if (!act_at(watch, index, x)) return false;
    if (x.t == t_end) return true;
    a = x;
    if (!step(x, t_end - a.t, t_end)) return false;
  }
  return fail(StepStatus::NotSolved, "more than 40 events that do something in one step");
}

/// Rows that are kept.
class KeptRows final : public RunSink {
 public:
  KeptRows(Trajectory& run, std::size_t steps) : run_(run), steps_(steps) {}
  void step(const State& x, const StepReport& report) override {
    if (run_.steps() == 0)
      run_.reserve_rows(room(steps_, report.contacts.size()), room(steps_, report.joints.size()));
    run_.add(x, report);
  }
  void event(const Event& event) override { run_.events.push_back(event); }

 private:
  Trajectory& run_;
  std::size_t steps_;
};

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
  if (plan.adaptive != nullptr) {
    report = plan.adaptive->run(
        model, run,
        {.t_end = options.t_end, .h = plan.h, .progress = options.progress, .events = options.events});
  } else {
    run.between = cubics(model);
    KeptRows rows(run, n);
    FixedSteps steps(model, stepper, options, plan, rows);
    steps.take(x);
    run.stopped_by = steps.stopped_by;
    report = std::move(steps.report);
  }
  if (!report.advanced()) throw StepFailure(std::move(report), std::move(run));
  return run;
}

RunEnd simulate(const Model& model, Stepper& stepper, const State& x0, const SimulateOptions& options,
                RunSink& sink) {
  const Plan plan = plan_of(model, stepper, x0, options);
  RunEnd end{.x = first_state(model, x0, options), .stopped_by = {}};
  StepReport report;
  if (plan.adaptive == nullptr) {
    FixedSteps steps(model, stepper, options, plan, sink);
    steps.take(end.x);
    end.steps = steps.taken;
    end.stopped_by = steps.stopped_by;
    report = std::move(steps.report);
  } else {
    Trajectory run(end.x, 0);
    const auto hand_on = [&] {
      for (std::size_t i = 0; i < run.steps(); ++i) sink.step(run.state(i + 1), run.report(i));
      for (const Event& event : run.events) sink.event(event);
      end.steps += run.steps();
      run = Trajectory(State(run.back()), 0);
    };
    const auto progress = [&](double t) {
      hand_on();
      return !options.progress || options.progress(t);
    };
    report = plan.adaptive->run(
        model, run, {.t_end = options.t_end, .h = plan.h, .progress = progress, .events = options.events});
    end.evaluations = run.evaluations;
    end.stopped_by = run.stopped_by;
    end.unseen = run.unseen;
    hand_on();
    end.x = run.back();
  }
  if (!report.advanced()) throw StepFailure(std::move(report), Trajectory(end.x, 0));
  end.reached = end.x.t == options.t_end;
  return end;
}

}  // namespace perp
