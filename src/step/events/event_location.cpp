// Where in a step a root function falls through zero.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/events/event_run.hpp"

namespace perp {

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
  RowSums row;
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
      if (const RowSums* sums = local_->sums()) row += *sums;
    }
  }
  s = sample(x);
  s.row = std::move(row);
  return s.nu_dot.size() > 0 || model_.nv() == 0;
}

/// A state within [a, b] where a gap or a speed, which falls at a and rises at b, is below zero; false where the tangents at both
/// ends say that it stays above, or where it is not found. Where a normal turns far the bodies passed each other: it is looked
/// at in halves.
bool EventRun::dips(std::size_t root, EventSample a, EventSample b, EventSample& high, int halvings) {
  const auto i = static_cast<Eigen::Index>(root);
  constexpr int most_halvings = 12;
  if (roots_[root].kind == Root::Touch && halvings < most_halvings &&
      a.normal[root].dot(b.normal[root]) < 0.5 && std::isfinite(a.g[i]) && std::isfinite(b.g[i])) {
    EventSample middle;
    if (!state_at(0.5 * (a.x.t + b.x.t), middle)) return false;
    high = middle;
    return fell(root, middle) || dips(root, a, middle, high, halvings + 1) ||
           dips(root, middle, b, high, halvings + 1);
  }
  for (int k = 0; k < 30; ++k) {
    const double fall = a.g_rate[i], rise = b.g_rate[i], h = b.x.t - a.x.t;
    if (!(fall < 0 && rise > 0) || !std::isfinite(a.g[i]) || !std::isfinite(b.g[i])) return false;
    const double share = (b.g[i] - a.g[i] - h * rise) / (h * (fall - rise));  // where the tangents meet
    if (!(a.g[i] + share * h * fall < -roots_[root].small)) return false;
    const double t = a.x.t + h * std::clamp(share, 0.01, 0.99);
    if (!(t > a.x.t && t < b.x.t) || !state_at(t, high)) return false;
    if (fell(root, high)) return true;
    (high.g_rate[i] < 0 ? a : b) = high;
  }
  return false;
}

bool EventRun::any_dips(const EventSample& a, const EventSample& b, EventSample& high) {
  for (std::size_t i = 0; i < roots_.size(); ++i)
    if (!roots_[i].of_force() && dips(i, a, b, high)) return true;
  return false;
}

bool EventRun::fell(std::size_t root, const EventSample& s, double share) const {
  const auto i = static_cast<Eigen::Index>(root);
  return roots_[root].fell(share * s.g[i], s.g_rate[i]);
}

/// Whether some root fell below zero in the step; then `high` is a state after its fall, integrated.
bool EventRun::bracket(const EventSample& middle, const EventSample& end, EventSample& high) {
  const auto any_fell = [&](const EventSample& s) {
    for (std::size_t i = 0; i < roots_.size(); ++i)
      if (fell(i, s)) return true;
    return false;
  };
  if (middle.g.size() == end.g.size() && any_fell(middle) && state_at(middle.x.t, high) && any_fell(high))
    return true;
  if (middle.g.size() == end.g.size() && (any_dips(now_, middle, high) || any_dips(middle, end, high)))
    return true;
  if (!any_fell(end)) return false;
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
      if (!fell(i, high)) continue;
      const double g0 = std::max(now_.g[j], 0.0), share = std::isfinite(g0) ? g0 / (g0 - high.g[j]) : 1;
      if (share < least) least = share, first = i;
    }
    if (first == roots_.size()) return false;
    if (!solve_root(first, now_, high, found)) return false;
    bool earlier = false;
    for (std::size_t i = 0; i < roots_.size(); ++i) earlier = earlier || (i != first && fell(i, found, 0.1));
    if (earlier && found.x.t > now_.x.t) {
      high = found;
      continue;
    }
    EventSample dip;
    if (found.x.t > now_.x.t && any_dips(now_, found, dip)) {
      high = dip;
      continue;
    }
    triggers.clear();
    // forces that are not unique do not say which of them came to its limit
    const bool any_force = dynamics_.basis().size() > 0 && roots_[first].of_force();
    for (std::size_t i = 0; i < roots_.size(); ++i) {
      const auto j = static_cast<Eigen::Index>(i);
      if (i == first || (fell(i, after) && found.g[j] < 1e3 * roots_[i].small) ||
          (any_force && roots_[i].of_force()))
        triggers.push_back(roots_[i]);
    }
    return true;
  }
  return false;
}

/// Where root i falls through zero between now_ (g >= 0) and high (g < 0), by the Illinois variant of the secant method; now_ itself if
/// it is zero there and nowhere positive after. Where g jumps, the state before the jump.
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
  const bool to_the_far_side = roots_[i].far_side();
  EventSample before = start, beyond = end;
  for (int k = 0; k < 100; ++k) {
    double t = high - g_high * (high - low) / (g_high - g_low);
    const bool may_jump = g_low == feasible_root * small;
    if (!(t > low && t < high) || k > 40 || may_jump) t = 0.5 * (low + high);
    if (spent() || !state_at(t, s)) return false;
    found = s;
    const double g = s.g[j];
    if (g <= 0) beyond = s;
    if (std::abs(g) <= 2e-2 * small && (g <= 0 || !to_the_far_side)) return true;
    if (high - low <= 4e-16 * std::max(std::abs(high), 1e-3 * (end.x.t - start.x.t))) {
      if (g < 0 && may_jump) found = before;
      if (to_the_far_side) found = beyond;
      return true;
    }
    if (g > 0) {
      before = s;
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
