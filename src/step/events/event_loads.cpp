// What loads and the user do to a run: loads jump at times that they name and where their switches are, and do what no step looked at;
// the user's events are marks, changes of the state, and ends.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/events/event_run.hpp"
#include "step/events/event_watch.hpp"

namespace perp {
namespace {

/// The next double.
double beyond(double t) { return std::nextafter(t, infinity); }

}  // namespace

/// Begins to look: how often, and for the first jump.
void EventRun::watch_loads(double t_end) {
  constexpr double looks = 4096;
  t_end_ = t_end;
  look_ = std::isnan(options_.look) ? (t_end - now_.x.t) / looks : options_.look;
  jump_ = loads_.next(now_.x.t, beyond(t_end_), look_);
}

/// Where the integrator must stop so that none of its stages sees a load past its jump: a few roundings earlier.
double EventRun::just_before_jump() const {
  constexpr double roundings = 8 * 2.3e-16;
  return jump_.t - roundings * std::max(std::abs(jump_.t), std::abs(now_.x.t));
}

/// From just before the jump to it, by a Taylor step that is exact to rounding; then what it changes.
bool EventRun::jump_of_loads(const EventSample& before) {
  State x = before.x;
  const double dt = jump_.t - x.t;
  move(model_, x.nu, dt, x.q);
  x.nu += dt * before.nu_dot;
  x.t = jump_.t;
  model_.follow_turns(x);
  if (x.t > now_.x.t) add_row(now_, before, x);
  now_.x = x;
  log(EventKind::Load, jump_.name, ContactMode::Open, ContactMode::Open);
  jump_ = loads_.next(x.t, beyond(t_end_), look_);
  return handle_event(x, {{.kind = Root::Switch, .index = -1}});
}

/// What was found, past the switch of a load, as it is just before.
EventSample EventRun::near_side(const EventSample& found, const std::vector<Root>& triggers) {
  for (const Root& root : triggers) {
    if (root.kind != Root::Switch || root.index < 0 || switches_.of_user(at(root.index))) continue;
    constexpr int most = 30;
    double back =
        2.3e-16 * std::max(std::abs(found.x.t), scales_.speed > 0 ? scales_.length / scales_.speed : 0);
    for (int k = 0; k < most && back < found.x.t - now_.x.t; ++k, back *= 2) {
      State x = found.x;
      move(model_, x.nu, -back, x.q);
      x.nu -= back * found.nu_dot;
      x.t -= back;
      if (switches_.value(at(root.index), model_, x) > 0) return sample(x);
    }
  }
  return found;
}

/// Where a switch is passed within the step, looked for in the cubics between its ends: `high` is a state past it, integrated. Events that
/// began at their zeros are on the side to which they go.
bool EventRun::switch_passed(EventSample& middle, EventSample& end, EventSample& high) {
  if (switches_.empty() || middle.g.size() != end.g.size()) return false;
  constexpr double least = 4, most = 1e6;
  const double h = end.x.t - now_.x.t, looks = std::clamp(std::ceil(h / look_), least, most);
  const auto of_step = {&now_, &middle, &end};
  for (double k = 1; k < looks; ++k) {
    const State x = between(now_, end, now_.x.t + k * h / looks);
    for (std::size_t i = 0; i < roots_.size(); ++i) {
      Root& root = roots_[i];
      if (root.kind != Root::Switch) continue;
      const std::size_t index = at(root.index);
      if (!switches_.known(index)) {
        const double g = switches_.g(index, model_, x);
        if (!(std::abs(g) > root.vague)) continue;
        switches_.learn(index, g);
        root.armed = true;
        for (EventSample* s : of_step)
          s->g[static_cast<Eigen::Index>(i)] = switches_.value(index, model_, s->x);
      } else if (root.fell(switches_.value(index, model_, x), 0) && state_at(x.t, high) && fell(i, high)) {
        return true;
      }
    }
  }
  return false;
}

/// What is wrong with a user's function; empty if nothing is.
std::string EventRun::switch_fault(const EventSample& s) const {
  for (std::size_t i = 0; i < roots_.size() && s.g.size() > 0; ++i)
    if (roots_[i].kind == Root::Switch && std::isnan(s.g[static_cast<Eigen::Index>(i)]))
      return not_a_number(switches_.name(at(roots_[i].index)), s.x.t);
  return {};
}

/// Whether nothing is done there but to write it down, if that.
bool EventRun::only_marks(const std::vector<Root>& triggers) const {
  return std::all_of(triggers.begin(), triggers.end(), [&](const Root& r) {
    return r.kind == Root::Switch && r.index >= 0 && !switches_.acts(at(r.index));
  });
}

/// Goes on from where it passed such switches, in the same modes.
void EventRun::mark(EventSample&& found, const std::vector<Root>& triggers) {
  now_ = std::move(found);
  restart_ = true;
  pass_switches(triggers);
  for (std::size_t i = 0; i < roots_.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const bool passed = triggered(triggers, roots_[i].kind, roots_[i].index);
    if (passed) now_.g[j] = -now_.g[j];
    roots_[i].armed = !passed && (roots_[i].armed || now_.g[j] > roots_[i].vague);
  }
  jump_rows_.clear();
  jump_reactions_.resize(0);
  jump_energy_ = jump_friction_ = 0;
  add_jump_row();
  dynamics_.begin_step(now_.x);
}

/// Switches that were passed are on the other side from here on; what the user does at his is done.
void EventRun::pass_switches(const std::vector<Root>& triggers) {
  disturbed_ = false;
  for (const Root& root : triggers) {
    if (root.kind != Root::Switch || root.index < 0) continue;
    const std::size_t index = at(root.index);
    const bool user = switches_.of_user(index), counts = switches_.counts(index);
    switches_.pass(index);
    if (counts)
      log(user ? EventKind::User : EventKind::Load, switches_.name(index), ContactMode::Open,
          ContactMode::Open);
    if (user && counts) act_at(index);
  }
}

void EventRun::act_at(std::size_t index) {
  const UserEvent& event = switches_.event(index);
  StepReport changed;
  const EventDone done = act(event, model_, now_.x, changed);
  if (!done.goes_on) out_.stopped_by = event.name;
  if (!done.changed) return;
  report = std::move(changed);
  out_.add(now_.x, report);
  disturbed_ = true;
  // where others are now that a step has not led there
  for (std::size_t i = 0; i < switches_.size(); ++i)
    if (switches_.of_user(i)) switches_.forget(i);
}

/// Switches in units of the largest value that each has had.
void EventRun::list_switches() {
  constexpr double rounding = 1e-13;
  const double vague = some_steps * options_.rtol;
  switches_.measure(model_, now_.x, scales_, vague);
  for (std::size_t i = 0; i < switches_.size(); ++i)
    roots_.push_back({.kind = Root::Switch,
                      .index = static_cast<int>(i),
                      .small = rounding * switches_.scale(i),
                      .vague = vague * switches_.scale(i),
                      .vague_rate = infinity});
}

/// Cubic Hermite's state at t between a and b: to look at loads with, not to go on from.
State EventRun::between(const EventSample& a, const EventSample& b, double t) const {
  const double h = b.x.t - a.x.t, s = (t - a.x.t) / h, r = 1 - s;
  const double from = r * r * (1 + 2 * s), to = s * s * (1 + 2 * r), from_rate = h * s * r * r,
               to_rate = -h * s * s * r;
  State x = a.x;
  x.t = t;
  x.nu = from * a.x.nu + to * b.x.nu + from_rate * a.nu_dot + to_rate * b.nu_dot;
  Vector rate_a, rate_b;
  dynamics_.kinematic_map(a.x, rate_a);
  dynamics_.kinematic_map(b.x, rate_b);
  x.q = from * a.x.q + to * b.x.q + from_rate * rate_a + to_rate * rate_b;
  for (const Body& body : model_.bodies())
    if (body.kind == BodyKind::Spatial) x.q.segment<4>(body.q0 + 3).normalize();
  return x;
}

/// Up to when loads did in the step what the step could see of them.
double EventRun::seen_until(const EventSample& a, const EventSample& b) {
  if (loads_.empty()) return b.x.t;
  const double h = b.x.t - a.x.t;
  unseen_ = std::max(unseen_, h / std::max(1.0, std::ceil(h / look_)));
  if (h <= look_) return b.x.t;
  constexpr double tolerances = 10;
  const double small = tolerances * (options_.rtol * scales_.speed + atol_);
  return loads_.seen_until(model_, a.x.t, b.x.t, look_, small, small / scales_.length,
                           [&](double t) { return between(a, b, t); });
}

}  // namespace perp
