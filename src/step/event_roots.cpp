// Root functions of a stretch: what is looked for in a step, and where it is found.
#include "step/event_run.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace

double mobility(const Model& model, const Instant& instant, const ContactInstant& c) {
  Vector force = Vector::Zero(model.nv()), response;
  c.W.add_impulse(Vector3::UnitX(), force);
  solve_mass(model, instant, force, response);
  return c.W.velocity(response).x();
}

bool triggered(const std::vector<Root>& triggers, Root::Kind kind, int index) {
  return std::any_of(triggers.begin(), triggers.end(),
                     [&](const Root& r) { return r.kind == kind && r.index == index; });
}

void EventRun::list_roots() {
  roots_.clear();
  constexpr double rounding = 1e-13, force_rounding = 1e-11;
  const double atol = std::isnan(options_.atol) ? options_.rtol : options_.atol;
  const auto add = [&](Root::Kind kind, int index, double scale, bool force) {
    const double small = (force ? force_rounding : rounding) * scale;
    const double error =
        30 * (options_.rtol * scale + (force ? 0 : atol));  // what some first steps may add up to
    roots_.push_back({.kind = kind, .index = index, .small = small, .vague = std::max(small, error)});
  };
  for (int point = 0; point < model_.contact_points(); ++point) {
    const ClosedContact* closed = modes_.find(point);
    if (closed == nullptr) {
      add(Root::Touch, point, scales_.length, false);
      continue;
    }
    const ContactInstant& c = instant_.contacts[at(instant_.contact_of_point[at(point)])];
    const double force = scales_.acceleration / mobility(model_, instant_, c);
    add(Root::Lift, point, force, true);
    if (c.tangents == 0) continue;
    if (closed->slides)
      add(Root::ContactRests, point, scales_.speed, false);
    else
      add(Root::ContactSlips, point, force, true);
  }
  for (std::size_t i = 0; i < modes_.joints.size(); ++i) {
    const JointRowInstant& row = instant_.joint_frictions[i];
    const bool turns = freedom_of(model_, row) == JointFreedom::Rotation;
    if (modes_.joints[i] != 0)
      add(Root::JointRests, static_cast<int>(i), scales_.speed / (turns ? scales_.length : 1), false);
    else
      add(Root::JointSlips, static_cast<int>(i), row.friction, true);
  }
}

EventSample EventRun::sample(const State& x) {
  EventSample s;
  s.x = x;
  if (!dynamics_.evaluate(x)) return s;
  s.nu_dot = dynamics_.nu_dot;
  s.force = dynamics_.force;
  s.joint_force = dynamics_.joint_force;
  s.joint_reaction = dynamics_.multipliers().head(
      static_cast<Eigen::Index>(dynamics_.instant().joint_rows.size()));
  s.joint_rate.resize(s.joint_force.size());
  const Instant& instant = dynamics_.instant();
  for (std::size_t i = 0; i < instant.joint_frictions.size(); ++i)
    s.joint_rate[static_cast<Eigen::Index>(i)] = instant.joint_frictions[i].velocity(x.nu);
  for (const ClosedContact& c : modes_.contacts)
    s.velocity.push_back(instant.contacts[at(instant.contact_of_point[at(c.point)])].velocity(x.nu));
  read_roots(s);
  return s;
}

void EventRun::read_roots(EventSample& s) {
  const Instant& instant = dynamics_.instant();
  const auto n = static_cast<Eigen::Index>(roots_.size());
  s.g.setZero(n);
  s.g_rate.setZero(n);
  std::size_t closed = 0;  // modes and roots are both in the order of points
  bool pulls = false;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Root& root = roots_[at(i)];
    const bool contact = root.kind != Root::JointRests && root.kind != Root::JointSlips;
    while (contact && root.kind != Root::Touch && modes_.contacts[closed].point != root.index) ++closed;
    switch (root.kind) {
      case Root::Touch: {
        const int now = instant.contact_of_point[at(root.index)];
        s.g[i] = now < 0 ? infinity : instant.contacts[at(now)].psi_n;
        s.g_rate[i] = now < 0 ? 0 : instant.contacts[at(now)].velocity(s.x.nu).x();
        break;
      }
      case Root::Lift:
        s.g[i] = s.force[closed].x();
        break;
      case Root::ContactRests:
        s.g[i] = dynamics_.sliding_speed(s.x, closed);
        break;
      case Root::ContactSlips: {
        const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(root.index)])];
        s.g[i] = c.mu * s.force[closed].x() - s.force[closed].tail<2>().norm();
        break;
      }
      case Root::JointRests:
        s.g[i] = modes_.joints[at(root.index)] * s.joint_rate[root.index];
        break;
      case Root::JointSlips:
        s.g[i] = instant.joint_frictions[at(root.index)].friction - std::abs(s.joint_force[root.index]);
        break;
    }
    const bool of_force =
        root.kind == Root::Lift || root.kind == Root::ContactSlips || root.kind == Root::JointSlips;
    pulls = pulls || (of_force && s.g[i] < -root.small);
  }
  if (!pulls || dynamics_.basis().size() == 0 || !forces_are_feasible(s)) return;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Root::Kind kind = roots_[at(i)].kind;
    if (kind == Root::Lift || kind == Root::ContactSlips || kind == Root::JointSlips)
      s.g[i] = std::max(s.g[i], 2 * roots_[at(i)].small);
  }
}

bool EventRun::spent() const {
  constexpr long a_test = 300;  // evaluations that a complementarity problem is worth
  return dynamics_.evaluations + a_test * feasibility_tests_ > options_.max_evaluations;
}

/// Where contacts are redundant, forces that pull do not say that others would: CP1 knows.
bool EventRun::forces_are_feasible(const EventSample& s) {
  ++feasibility_tests_;
  AccelerationProblem problem;
  const Instant instant = dynamics_.instant();
  Modes modes = modes_;
  for (std::size_t i = 0; i < modes.contacts.size(); ++i)
    if (modes.contacts[i].slides) modes.contacts[i].direction = dynamics_.sliding_direction(s.x, i);
  problem.assemble(model_, s.x, instant, modes);
  const AccelerationAnswer answer = problem.solve(model_, {});
  if (answer.status == Cp1Status::None) return false;
  const double small = 1e-7 * problem.acceleration_scale;
  bool holds = true;
  for (std::size_t i = 0; i < modes.contacts.size(); ++i) {
    const bool rests = !modes.contacts[i].slides;
    holds = holds && answer.acceleration[i].x() <= small &&
            (!rests || answer.acceleration[i].tail<2>().norm() <= small);
  }
  for (std::size_t i = 0; i < modes.joints.size(); ++i)
    if (modes.joints[i] == 0)
      holds = holds && std::abs(answer.joint_acceleration[static_cast<Eigen::Index>(i)]) <= small;
  return holds;
}

/// Hermite's interpolant: to look for events and to weigh forces by Simpson's rule, not to go on from.
State EventRun::half_way(const EventSample& a, const EventSample& b) const {
  const double h = b.x.t - a.x.t;
  State m;
  m.t = a.x.t + h / 2;
  m.nu = 0.5 * (a.x.nu + b.x.nu) + h / 8 * (a.nu_dot - b.nu_dot);
  Vector rate_a, rate_b;
  dynamics_.kinematic_map(a.x, rate_a);
  dynamics_.kinematic_map(b.x, rate_b);
  m.q = 0.5 * (a.x.q + b.x.q) + h / 8 * (rate_a - rate_b);
  for (const Body& body : model_.bodies()) {
    if (body.nv == 0) continue;
    // all but orientations: their second derivatives are known as well
    const int n = body.kind == BodyKind::Generalized ? body.nq : 3;
    m.q.segment(body.q0, n) = 0.5 * (a.x.q + b.x.q).segment(body.q0, n) +
                              5 * h / 32 * (a.x.nu - b.x.nu).segment(body.v0, n) +
                              h * h / 64 * (a.nu_dot + b.nu_dot).segment(body.v0, n);
    if (body.kind == BodyKind::Spatial) m.q.segment<4>(body.q0 + 3).normalize();
  }
  return m;
}

/// The state at t within the step that starts at now_, integrated from there.
bool EventRun::state_at(double t, EventSample& s) {
  State x = now_.x;
  const double time_scale = scales_.speed > 0 ? scales_.length / scales_.speed : 1;
  if (const double dt = t - x.t; dt <= 1e-8 * time_scale || dt < 64 * 2.3e-16 * std::abs(t)) {
    State start = x;
    x.nu += dt * now_.nu_dot;
    move(model_, start.nu + 0.5 * dt * now_.nu_dot, dt, x.q);
    x.t = t;
    if (!std::isfinite(dynamics_.project(x))) return false;
  } else {
    if (!local_->start(x, t - x.t)) return false;
    constexpr int most = 300;  // for a part of one step; a multistep method begins it with short ones
    for (int k = 0; x.t < t; ++k) {
      const double before = x.t;
      const bool stepped = k < most && local_->step(t, x);
      if (local_->thrown) std::rethrow_exception(local_->thrown);
      if (!stepped || !(x.t > before)) return false;
    }
  }
  s = sample(x);
  return s.nu_dot.size() > 0 || model_.nv() == 0;
}

/// The time within [a, b] where an open contact's gap is least, by the cubic through gaps and rates at the ends; not set
/// where it does not fall below zero inside.
double EventRun::lowest_touch(std::size_t root, const EventSample& a, const EventSample& b) const {
  const auto i = static_cast<Eigen::Index>(root);
  const double h = b.x.t - a.x.t, g0 = a.g[i], g1 = b.g[i], d0 = h * a.g_rate[i], d1 = h * b.g_rate[i];
  if (!(d0 < 0 && d1 > 0) || !std::isfinite(g0) || !std::isfinite(g1)) return not_set;
  // derivative: d0 + (6 (g1 - g0) - 4 d0 - 2 d1) s + (3 d0 + 3 d1 - 6 (g1 - g0)) s^2, one zero in (0, 1)
  double low = 0, high = 1;
  const auto value = [&](double s) {
    const double c2 = 3 * (g1 - g0) - 2 * d0 - d1, c3 = d0 + d1 - 2 * (g1 - g0);
    return g0 + s * (d0 + s * (c2 + s * c3));
  };
  const auto slope = [&](double s) {
    return d0 + s * (6 * (g1 - g0) - 4 * d0 - 2 * d1 + s * (3 * d0 + 3 * d1 - 6 * (g1 - g0)));
  };
  for (int k = 0; k < 40; ++k) (slope(0.5 * (low + high)) < 0 ? low : high) = 0.5 * (low + high);
  return value(low) < 0 ? a.x.t + low * h : not_set;
}

/// Whether some root fell below zero in the step; then `high` is a state after its fall, integrated.
bool EventRun::bracket(const EventSample& middle, const EventSample& end, EventSample& high) {
  const auto fell = [&](const EventSample& s) {
    for (std::size_t i = 0; i < roots_.size(); ++i)
      if (roots_[i].fell(s.g[static_cast<Eigen::Index>(i)])) return true;
    return false;
  };
  if (middle.g.size() == end.g.size() && fell(middle) && state_at(middle.x.t, high) && fell(high))
    return true;
  for (std::size_t i = 0; i < roots_.size() && middle.g.size() == end.g.size(); ++i) {
    if (roots_[i].kind != Root::Touch) continue;
    for (const double t : {lowest_touch(i, now_, middle), lowest_touch(i, middle, end)})
      if (!std::isnan(t) && state_at(t, high) && fell(high)) return true;
  }
  if (!fell(end)) return false;
  high = end;
  return true;
}

/// The first root between now_ and `high`, and all that fall there together.
bool EventRun::locate(const EventSample& after, EventSample& found, std::vector<Root>& triggers) {
  EventSample high = after;
  for (int round = 0; round < 50; ++round) {
    // of the roots that fell, the first by a straight line
    std::size_t first = roots_.size();
    double least = infinity;
    for (std::size_t i = 0; i < roots_.size(); ++i) {
      const auto j = static_cast<Eigen::Index>(i);
      if (!roots_[i].fell(high.g[j])) continue;
      const double g0 = std::max(now_.g[j], 0.0), share = std::isfinite(g0) ? g0 / (g0 - high.g[j]) : 1;
      if (share < least) least = share, first = i;
    }
    if (first == roots_.size()) return false;
    if (!solve_root(first, now_, high, found)) return false;
    bool earlier = false;
    for (std::size_t i = 0; i < roots_.size(); ++i)
      earlier = earlier || (i != first && roots_[i].fell(0.1 * found.g[static_cast<Eigen::Index>(i)]));
    if (earlier && found.x.t > now_.x.t) {
      high = found;
      continue;
    }
    triggers.clear();
    for (std::size_t i = 0; i < roots_.size(); ++i) {
      const auto j = static_cast<Eigen::Index>(i);
      if (i == first || (roots_[i].fell(after.g[j]) && found.g[j] < 1e3 * roots_[i].small))
        triggers.push_back(roots_[i]);
    }
    return true;
  }
  return false;
}

/// Where root i falls through zero between now_ (g >= 0) and high (g < 0), by the Illinois variant of the secant method; now_ itself if
/// it is zero there and nowhere positive after.
bool EventRun::solve_root(std::size_t i, const EventSample& start, const EventSample& end,
                          EventSample& found) {
  const auto j = static_cast<Eigen::Index>(i);
  const double small = roots_[i].small;
  double low = start.x.t, high = end.x.t, g_low = start.g[j], g_high = end.g[j];
  EventSample s;
  if (!(g_low > small)) {  // zero at the start: it must first rise
    // a gap that opens is highest where the parabola through it is; else look ever nearer
    const double h = high - low, bend = 2 * (g_high - g_low - start.g_rate[j] * h) / (h * h);
    double t = start.g_rate[j] > 0 && bend < 0 ? low - start.g_rate[j] / bend : low + 0.5 * h;
    bool rose = false;
    for (int k = 0; k < 40 && !rose && t > low; ++k, t = low + 0.5 * (t - low)) {
      if (!state_at(t, s)) return false;
      rose = s.g[j] > small;
      if (!rose && s.g[j] < -small) high = t, g_high = s.g[j];
    }
    if (!rose) {
      found = start;
      return true;
    }
    low = s.x.t;
    g_low = s.g[j];
  }
  if (!std::isfinite(g_low)) g_low = -g_high;
  int side = 0;
  for (int k = 0; k < 100; ++k) {
    double t = high - g_high * (high - low) / (g_high - g_low);
    if (!(t > low && t < high) || k > 40) t = 0.5 * (low + high);
    if (spent() || !state_at(t, s)) return false;
    found = s;
    const double g = s.g[j];
    if (std::abs(g) <= 2e-2 * small ||
        high - low <= 4e-16 * std::max(std::abs(high), 1e-3 * (end.x.t - start.x.t)))
      return true;
    if (g > 0) {
      low = t;
      g_low = std::isfinite(g) ? g : -g_high;
      if (side > 0) g_high *= 0.5;
      side = 1;
    } else {
      high = t;
      g_high = g;
      if (side < 0) g_low *= 0.5;
      side = -1;
    }
  }
  return true;
}

}  // namespace perp
