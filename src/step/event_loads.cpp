// What loads do to a run: they jump at times that they name and where their switches are, and do what no step looked at.
#include <algorithm>
#include <cmath>

#include "step/event_run.hpp"

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

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
bool EventRun::jump_of_loads(EventSample& to, const EventSample& middle) {
  const double dt = jump_.t - to.x.t;
  move(model_, to.x.nu, dt, to.x.q);
  to.x.nu += dt * to.nu_dot;
  to.x.t = jump_.t;
  model_.follow_turns(to.x);
  if (to.x.t > now_.x.t) add_row(now_, middle, to);
  const std::string name = jump_.name;
  jump_ = loads_.next(to.x.t, beyond(t_end_), look_);
  now_.x = to.x;
  log(EventKind::Load, name, ContactMode::Open, ContactMode::Open);
  return handle_event(State(to.x), {{.kind = Root::LoadJumps, .index = -1}});
}

double EventRun::switch_value(const Root& root, const State& x) const {
  const std::size_t loads = loads_.switches().size();
  return root.kind == Root::LoadJumps ? loads_.switches()[at(root.index)].value(model_, x)
                                      : user_events_[at(root.index) - loads].when(model_, x);
}

/// Switches that were passed are on the other side from here on; what the user does at his.
void EventRun::pass_switches(const std::vector<Root>& triggers) {
  const std::size_t loads = loads_.switches().size();
  for (const Root& root : triggers) {
    if (!root.far_side() || root.index < 0) continue;
    Side& side = sides_[at(root.index)];
    side.sign *= -1;
    if (root.kind == Root::LoadJumps) {
      log(EventKind::Load, loads_.switches()[at(root.index)].name, ContactMode::Open, ContactMode::Open);
      continue;
    }
    const UserEvent& event = user_events_[at(root.index) - loads];
    if (event.direction * side.sign < 0) continue;  // the other way
    log(EventKind::User, event.name, ContactMode::Open, ContactMode::Open);
    if (!event.then) continue;
    stopped_ = !event.then(model_, now_.x) || stopped_;
    model_.check("UserEvent::then", now_.x);
  }
}

/// Switches of loads and the user's events, in units of the largest value that each has had.
void EventRun::list_switches() {
  const std::size_t loads = loads_.switches().size();
  sides_.resize(loads + user_events_.size());
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    Side& side = sides_[i];
    Root root{.kind = i < loads ? Root::LoadJumps : Root::UserZero, .index = static_cast<int>(i)};
    const double value = switch_value(root, now_.x);
    if (side.sign == 0) side.sign = value < 0 ? -1 : 1;
    side.scale = std::max(side.scale, std::abs(value));
    constexpr double rounding = 1e-13;
    root.small = rounding * side.scale;
    root.vague = some_steps * options_.rtol * side.scale;
    roots_.push_back(root);
  }
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
double EventRun::seen_until(const EventSample& a, const EventSample& b) const {
  if (loads_.empty() || b.x.t - a.x.t <= look_) return b.x.t;
  constexpr double tolerances = 10;
  const double small = tolerances * (options_.rtol * scales_.speed + atol_);
  return loads_.seen_until(model_, a.x.t, b.x.t, look_, small, small / scales_.length,
                           [&](double t) { return between(a, b, t); });
}

}  // namespace perp
