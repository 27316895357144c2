#include "step/events/event_watch.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "perp/step/impact.hpp"
#include "step/modes/modes.hpp"
#include "step/run/dense_output.hpp"

namespace perp {
namespace {

constexpr int looks = 8;  // a step

Scales scales_at(const Model& model, const State& x) {
  Instant now;
  evaluate(model, x, now);
  return scales_of(model, x, now);
}

/// The state at t between a and b with velocities on a straight line: through an impact the cubics' rates overshoot.
State look_at(const Model& model, const State& a, const State& b, double t) {
  State x = between_states(model, a, b, t);
  x.nu = a.nu + (t - a.t) / (b.t - a.t) * (b.nu - a.nu);
  return x;
}

}  // namespace

void check_events(const std::vector<UserEvent>& events) {
  for (const UserEvent& event : events) {
    if (!event.when) refuse("simulate", "events", event.name, "needs a function `when`");
    if (event.direction < -1 || event.direction > 1)
      refuse("simulate", "events: direction of '" + event.name + "'", static_cast<double>(event.direction),
             "needs to be -1, 0 or 1");
  }
}

std::string not_a_number(const std::string& event, double t) {
  return "`when` of the event '" + event + "' is not a number at t = " + shortest(t) + " s";
}

double variation(const UserEvent& event, const Model& model, const State& x, const Scales& scales) {
  constexpr double part =
      1e-3;  // of a length, a speed, a radian: small enough for what bends, or is not there further on
  const double now = event.when(model, x);
  double most = std::isfinite(now) ? std::abs(now) : 0;
  const auto compare = [&](const State& other) {
    const double change = std::abs(event.when(model, other) - now) / part;
    if (std::isfinite(change)) most = std::max(most, change);
  };
  for (const Body& body : model.bodies())
    for (int i = 0; i < body.nv; ++i) {
      const bool turns = body.kind != BodyKind::Generalized && i >= (body.kind == BodyKind::Planar ? 2 : 3);
      State other = x;
      move(model, Vector::Unit(model.nv(), body.v0 + i), part * (turns ? 1 : scales.length), other.q);
      compare(other);
      other.q = x.q;
      other.nu[body.v0 + i] += part * scales.speed / (turns ? scales.length : 1);
      compare(other);
    }
  State later = x;
  later.t += part * (scales.speed > 0 ? scales.length / scales.speed : 1);
  compare(later);
  return most;
}

EventDone act(const UserEvent& event, const Model& model, State& x, StepReport& report) {
  if (!event.then) return {};
  const State before = x;
  EventDone done;
  done.goes_on = event.then(model, x) == AfterEvent::GoOn;
  model.check("UserEvent::then of '" + event.name + "'", x);
  if (x.t != before.t)
    refuse("UserEvent::then of '" + event.name + "'", "t", x.t, "needs to stay " + shortest(before.t));
  done.changed = x.q != before.q || x.nu != before.nu;
  if (!done.changed) return done;
  model.follow_turns(x);
  Instant now;
  evaluate(model, x, now);
  report = {};
  report.t = x.t;
  report.status = StepStatus::Solved;
  report.solver = "user";
  report.residuals = {not_set, not_set, not_set, not_set, not_set};
  report.gap_min = now.gap_min();
  report.joint_error = now.joint_error();
  report.energy = model.energy(x);
  report.energy_friction = report.energy_impact = not_set;
  report.energy_load = report.energy - model.energy(before);
  report.energy_left = 0;
  report.point_names = model.point_names();
  return done;
}

bool meet_joints(const Model& model, State& x, StepReport& report) {
  Instant now;
  evaluate(model, x, now);
  double rate = 0;
  for (const JointRowInstant& row : now.joint_rows) rate = std::max(rate, std::abs(row.velocity(x.nu)));
  if (rate <= scales_of(model, x, now).small_speed()) return true;
  const Impact impact = solve_impact(model, x);
  if (!impact.solved) return false;
  x.nu = impact.nu;
  report.energy_impact = impact.energy;
  report.energy = model.energy(x);
  return true;
}

EventWatch::EventWatch(const Model& model, const std::vector<UserEvent>& events, const State& start,
                       double before)
    : model_(model), events_(events), sides_(events.size()) {
  check_events(events);
  if (events.empty()) return;
  const Scales scales = scales_at(model, start);
  State past = start;
  past.t -= before;
  move(model, start.nu, -before, past.q);
  constexpr double tolerance = 1e-9;  // what steps leave of resting gaps and joints, of the scale
  for (std::size_t i = 0; i < events.size(); ++i) {
    Side& side = sides_[i];
    side.small = side.noise = tolerance * variation(events[i], model, start, scales);
    double value = events[i].when(model, start);
    if (std::abs(value) <= side.small && before > 0) value = events[i].when(model, past);
    if (std::abs(value) > side.small) side.sign = value > 0 ? 1 : -1;
  }
}

/// Where g leaves the side `sign`, between a time at which it is there and one at which it is not.
double EventWatch::pass(std::size_t index, double sign, const State& a, const State& b, double low,
                        double high) const {
  while (true) {
    const double middle = low + 0.5 * (high - low);
    if (!(middle > low && middle < high)) return high;
    const double g = events_[index].when(model_, look_at(model_, a, b, middle));
    (sign * g < 0 ? high : low) = middle;
  }
}

std::vector<EventWatch::Change> EventWatch::changes(std::size_t index, const State& a,
                                                    const std::vector<State>& states) const {
  std::vector<Change> all;
  const Side& side = sides_[index];
  double sign = side.sign, small = side.small, low = a.t;
  for (const State& x : states) {
    const double g = events_[index].when(model_, x);
    if (std::isnan(g)) throw std::domain_error(not_a_number(events_[index].name, x.t));
    if (sign == 0 && std::abs(g) > small) {
      sign = g > 0 ? 1 : -1;
      small = side.noise;
      all.push_back({.t = x.t, .index = index, .sign = sign, .counts = false});
    } else if (sign * g < -side.noise) {
      const double t = pass(index, sign, a, states.back(), low, x.t);
      const bool counts = events_[index].direction * sign <= 0;
      sign = -sign;
      all.push_back({.t = t, .index = index, .sign = sign, .counts = counts});
    }
    low = x.t;
  }
  return all;
}

std::vector<EventWatch::Found> EventWatch::find(const State& a, const State& b) {
  std::vector<State> states;
  for (int k = 1; k < looks; ++k) states.push_back(look_at(model_, a, b, a.t + (b.t - a.t) * k / looks));
  states.push_back(b);
  std::vector<Change> all;
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const std::vector<Change> more = changes(i, a, states);
    all.insert(all.end(), more.begin(), more.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const Change& x, const Change& y) { return x.t < y.t; });
  std::vector<Found> found;
  for (const Change& change : all) {
    sides_[change.index].sign = change.sign;
    sides_[change.index].small = sides_[change.index].noise;
    if (!change.counts) continue;
    found.push_back({change.t, change.index});
    if (events_[change.index].then) break;  // what follows is another motion
  }
  return found;
}

void EventWatch::arrived(std::size_t index, const State& x) {
  Side& side = sides_[index];
  side.sign = 0;
  side.small = std::max(side.noise, 2 * std::abs(events_[index].when(model_, x)));
}

}  // namespace perp
