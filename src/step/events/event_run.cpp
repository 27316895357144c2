#include "step/events/event_run.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perp/core/errors.hpp"
#include "perp/step/simulate.hpp"
#include "step/parts/joint_projection.hpp"

namespace perp {
namespace {

/// Of the system's length: what a run may start with, and what is looked into where a row ends with more [-]. The projection closes joints to
/// 1e-14; the drift of an integrator that has none is the tolerance.
constexpr double start_misfit = 1e-8;

/// Of the system's speed: with what a contact may part whose gap falls by rounding, and count as closed [-]. Ten times less: what hardly
/// rises is followed up and down; ten times more: what is dropped may be seen from outside.
constexpr double dropped = 1e-6;

}  // namespace

State EventContinuation::go_on(const State& from, std::size_t row, double t) const {
  auto stretch = std::upper_bound(stretches.begin(), stretches.end(), row,
                                  [](std::size_t i, const Stretch& s) { return i < s.row; });
  --stretch;
  ModeDynamics dynamics(model);
  (void)dynamics.begin(from, stretch->modes, stretch->small_speed);
  const auto flow = integrator(dynamics);
  State x = from;
  bool fine = flow->start(x, t - x.t);
  while (fine && x.t < t) fine = flow->step(t, x);
  if (flow->thrown) std::rethrow_exception(flow->thrown);
  if (!fine) throw std::runtime_error("Trajectory::at: the integrator failed: " + flow->message);
  model.follow_turns(x);
  return x;
}

EventRun::EventRun(const Model& model, const EventDrivenOptions& options, const MakeIntegrator& flow,
                   const MakeIntegrator& between, Trajectory& out)
    : model_(model),
      options_(options),
      atol_(std::isnan(options.atol) ? options.rtol : options.atol),
      out_(out),
      dynamics_(model),
      loads_(model) {
  integrator_ = flow(dynamics_);
  local_ = flow(dynamics_);
  now_.x = out.back();
  t_begin_ = now_.x.t;
  continuation_ = std::make_shared<EventContinuation>(EventContinuation{model, between, {}, {}});
  out_.locates_events = true;
  out_.between = [kept = continuation_](const Trajectory& run, std::size_t i, double t) {
    return kept->go_on(run.state(i), i, t);
  };
}

bool EventRun::fail(StepStatus status, const std::string& why) {
  report = {};
  report.t = now_.x.t;
  report.status = status;
  report.solver = integrator_ ? integrator_->name() : "none";
  report.message = why;
  report.point_names = model_.point_names();
  return false;
}

bool EventRun::run(const RunRequest& request) {
  if (!integrator_) return fail(StepStatus::NotSolved, "this perp was built without SUNDIALS");
  const double t0 = now_.x.t, length = request.t_end - t0;
  switches_ = Switches(loads_, request.events);
  watch_loads(request.t_end);
  const double rows = std::isnan(request.h) ? 1 : std::max(1.0, std::round(length / request.h));
  const bool reached = begin() && [&] {
    for (double k = 1; k <= rows; ++k) {
      const double stop = k == rows ? request.t_end : t0 + k * length / rows;
      while (now_.x.t < stop) {
        if (!advance(stop)) return false;
        if (!out_.stopped_by.empty()) return true;
        if (request.progress && !request.progress(now_.x.t)) return true;
      }
    }
    return true;
  }();
  out_.evaluations = dynamics_.evaluations;
  out_.unseen = unseen_;
  return reached;
}

/// The first modes. Small violations are moved away, larger ones are the caller's.
bool EventRun::begin() {
  perp::evaluate(model_, now_.x, instant_);
  if (!instant_.fault.empty()) return fail(StepStatus::NotFinite, instant_.fault);
  scales_ = scales_of(model_, now_.x, instant_);
  const double allowed = start_misfit * scales_.length;
  if (instant_.gap_min() < -allowed || instant_.joint_error() > allowed)
    return fail(StepStatus::NotSolved, "the run starts with an overlap of " +
                                           shortest(std::max(0.0, -instant_.gap_min())) +
                                           " m and a joint error of " + shortest(instant_.joint_error()) +
                                           "; project_onto_constraints (project_initial) moves it away");
  if (instant_.gap_min() < -scales_.small_gap() || instant_.joint_error() > scales_.small_gap()) {
    const Projection moved = project_onto_constraints(model_, now_.x);
    if (!moved.reached)
      return fail(StepStatus::NotSolved, "no state near the first one satisfies its constraints");
  }
  modes_.joints.assign(instant_.joint_frictions.size(), 0);
  const std::size_t events = out_.events.size();
  disturbed_ = true;  // velocities are the user's
  if (!settle({})) {
    if (report.status == StepStatus::NotSolved && joint_rate() > scales_.small_speed())
      report.message =
          "a joint is jerked at the start, and no velocities were found that joints, motions and contacts "
          "allow";
    return false;
  }
  out_.events.resize(events);  // modes at the start are no events
  for (const Jumped& j : jumped_)
    log(j.kind, (*model_.point_names())[static_cast<std::size_t>(j.point)], j.before,
        mode_in(modes_, model_, j.point));
  if (jumped())
    add_jump_row();
  else
    continuation_->stretches.push_back({0, modes_, scales_.small_speed()});
  return true;
}

/// The largest velocity that a joint does not allow.
double EventRun::joint_rate() const {
  double rate = 0;
  for (const JointRowInstant& row : instant_.joint_rows)
    rate = std::max(rate, std::abs(row.velocity(now_.x.nu)));
  return rate;
}

/// Time in which no joint between spatial bodies turns by more than a quarter, from rates and accelerations now, with room for these
/// to grow: from half a turn on State::winding would lose count.
double EventRun::time_of_quarter_turn() const {
  using std::numbers::pi;
  double time = infinity;
  const auto add = [&](BodyId id, double& rate, double& growth) {
    const Body& b = model_.body(id);
    rate += model_.angular_velocity(now_.x, id).norm();
    if (b.kind == BodyKind::Spatial && now_.nu_dot.size() > 0)
      growth += now_.nu_dot.segment<3>(b.v0 + 3).norm();
  };
  for (const JointGeometry& j : model_.joints()) {
    const auto counts = [](const auto& row) { return row.winding >= 0; };
    const bool turns = std::any_of(j.rows.begin(), j.rows.end(), counts) ||
                       std::any_of(j.coordinates.begin(), j.coordinates.end(),
                                   [&](const JointCoordinate& c) { return counts(c.row); });
    if (!turns) continue;
    double rate = 0, growth = 0;
    add(j.a, rate, growth);
    add(j.b, rate, growth);
    time =
        std::min(time, pi / (rate + std::sqrt(rate * rate + pi * growth)));  // rate t + growth t^2/2 = pi/2
  }
  return time;
}

/// Why joints are open at the state sampled last, if they contradict each other there: the projection then holds them where they disagree
/// least. Empty if they are closed to what the integrator was asked for, or to what the run may start with, or could be closed.
std::string EventRun::joints_torn(const State& x) const {
  if (!(dynamics_.instant().joint_error() > std::max(start_misfit, options_.rtol) * scales_.length))
    return "";
  State nearest = x;
  const std::string names = contradicting_joints(model_, nearest);
  return names.empty() ? "" : "joints that contradict each other stay open: " + names;
}

/// One step of the integrator, up to the first event in it.
bool EventRun::advance(double t_stop) {
  if (now_.x.t >= look_until_) look_until_ = infinity;
  t_stop = std::min({t_stop, now_.x.t + time_of_quarter_turn(), look_until_});
  const bool load_jumps = jump_.t <= t_stop;
  if (load_jumps) t_stop = just_before_jump();
  if (load_jumps && t_stop <= now_.x.t) {
    return jump_of_loads(EventSample(now_));
  }
  if (spent()) return fail(StepStatus::NotSolved, "max_evaluations is spent");
  if (restart_) {
    if (!integrator_->start(now_.x, std::min(natural_step_, t_stop - now_.x.t)))
      return carry_across(t_stop, integrator_->message);
    restart_ = false;
  }
  State end = now_.x;
  const double time_scale = scales_.speed > 0 ? scales_.length / scales_.speed : infinity;
  if (t_stop - now_.x.t <= std::min(1e-9 * time_scale, 1e-9 * (t_stop - t_begin_))) {
    // too short for the integrator: a Taylor step is exact to rounding
    EventSample last;
    if (!state_at(t_stop, last)) return fail(StepStatus::NotFinite, "the state is not finite");
    end = last.x;
    restart_ = true;
  } else if (!integrator_->step(t_stop, end)) {
    if (integrator_->thrown) std::rethrow_exception(integrator_->thrown);
    return carry_across(t_stop, integrator_->message);
  }
  if (!end.q.allFinite() || !end.nu.allFinite())
    return fail(StepStatus::NotFinite, "the integrator's answer is not finite");
  if (end.t < t_stop) natural_step_ = end.t - now_.x.t;
  constexpr int most_short = 300;  // steps that shrink towards the end of a slide are some thirty
  const bool is_short = std::isfinite(time_scale) && end.t < t_stop && end.t - now_.x.t < 1e-7 * time_scale;
  short_steps_ = is_short ? short_steps_ + 1 : 0;
  if (short_steps_ > most_short) return carry_across(t_stop, "steps have become too short to get anywhere");

  EventSample to = sample(end);
  if (to.nu_dot.size() == 0 && model_.nv() > 0) return carry_across(t_stop, "forces are not finite");
  if (const std::string fault = switch_fault(to); !fault.empty()) return fail(StepStatus::NotFinite, fault);
  if (const std::string torn = joints_torn(to.x); !torn.empty()) return fail(StepStatus::NotSolved, torn);
  if (const RowSums* sums = restart_ ? nullptr : integrator_->sums()) to.row += *sums;
  EventSample middle = sample(half_way(now_, to));
  EventSample high;
  if (switch_passed(middle, to, high) || bracket(middle, to, high)) {
    EventSample found;
    std::vector<Root> triggers;
    if (!locate(high, found, triggers)) return carry_across(t_stop, "an event was not located");
    if (found.x.t > now_.x.t) {
      model_.follow_turns(found.x);
      add_row(now_, near_side(found, triggers), found.x);
    }
    if (only_marks(triggers)) return mark(std::move(found), triggers), true;
    return handle_event(found.x, triggers);
  }
  if (const double seen = seen_until(now_, to); seen < to.x.t) {  // a load did what the step did not see
    look_until_ = std::max(seen, now_.x.t + look_);
    natural_step_ = std::min(natural_step_, look_);
    restart_ = true;
    return true;
  }
  if (load_jumps && to.x.t >= t_stop) return jump_of_loads(to);
  model_.follow_turns(to.x);
  add_row(now_, to, to.x);
  now_ = std::move(to);
  for (std::size_t i = 0; i < roots_.size(); ++i)
    roots_[i].armed = roots_[i].armed || now_.g[static_cast<Eigen::Index>(i)] > roots_[i].vague;
  dynamics_.begin_step(now_.x);
  return true;
}

bool EventRun::handle_event(const State& x, const std::vector<Root>& triggers) {
  now_.x = x;
  restart_ = true;
  continuation_->ends.push_back({out_.size() - 1, triggers});
  if (too_many_events()) return carry_across(infinity, "too many events");
  const Modes before = modes_;
  pass_switches(triggers);
  if (!out_.stopped_by.empty()) return true;
  resting_.clear();
  held_.clear();
  closing_.clear();
  (void)dynamics_.rows(now_.x);
  for (const ContactInstant& c : dynamics_.instant().contacts)
    if (const double u_n = c.velocity(now_.x.nu).x();
        triggered(triggers, Root::Touch, c.point) && u_n >= 0 && u_n <= dropped * scales_.speed)
      closing_.push_back(c.point);
  const bool one_rests = std::any_of(triggers.begin(), triggers.end(),
                                     [](const Root& r) { return r.kind == Root::ContactRests; });
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    const int point = modes_.contacts[i].point;
    // a body on redundant contacts comes to rest at all of them together
    const bool rests = triggered(triggers, Root::ContactRests, point) ||
                       (one_rests && modes_.contacts[i].slides && dynamics_.basis().size() > 0);
    if (rests && dynamics_.as_good_as_stopped(now_.x, i)) resting_.push_back(point);
    if (triggered(triggers, Root::WheelRests, point) && dynamics_.as_good_as_stopped(now_.x, i, Moving::Roll))
      held_.push_back(point);
  }
  if (!settle(triggers)) return false;
  log_changes(before, triggers);
  add_jump_row();
  return true;
}

/// More than forty events in a time that counts for nothing: modes that change for ever.
bool EventRun::too_many_events() {
  event_times_.push_back(now_.x.t);
  if (event_times_.size() > 40) event_times_.pop_front();
  const double time_scale = scales_.length / scales_.speed;
  return event_times_.size() == 40 && event_times_.back() - event_times_.front() < 1e-6 * time_scale;
}

}  // namespace perp
