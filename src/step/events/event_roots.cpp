// Root functions of a stretch: what is looked for in a step.
#include "step/events/event_run.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"

namespace perp {
double EventRun::vague_gap() const { return some_steps * (options_.rtol * scales_.length + atol_); }

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

/// Returns those of before.
std::vector<Root> EventRun::list_roots() {
  std::vector<Root> last;
  last.swap(roots_);
  constexpr double rounding = 1e-13, force_rounding = 1e-11;
  const auto add = [&](Root::Kind kind, int index, double scale, bool force) {
    const double small = (force ? force_rounding : rounding) * scale;
    const double error = some_steps * (options_.rtol * scale + (force ? 0 : atol_));
    roots_.push_back({.kind = kind,
                      .index = index,
                      .small = small,
                      .vague = std::max(small, error),
                      .vague_rate = kind == Root::Touch ? some_steps * (options_.rtol * scales_.speed + atol_)
                                                        : infinity});
  };
  model_.each_point([&](int point) {
    const ClosedContact* closed = modes_.find(point);
    if (closed == nullptr) return add(Root::Touch, point, scales_.length, false);
    const ContactInstant& c = instant_.contacts[at(instant_.contact_of_point[at(point)])];
    const double force = scales_.acceleration / mobility(model_, instant_, c);
    add(Root::Lift, point, force, true);
    if (c.tangents == 0) return;
    const MomentInstant* m = instant_.moments_of(c);
    if (closed->slides)
      add(Root::ContactRests, point, scales_.speed, false);
    else if (m == nullptr || m->has_sliding(c.mu))
      add(Root::ContactSlips, point, force, true);
    if (m != nullptr && m->rolling > 0)
      add(closed->rolls ? Root::WheelRests : Root::WheelRolls, point, closed->rolls ? scales_.speed : force,
          !closed->rolls);
  });
  for (std::size_t i = 0; i < modes_.joints.size(); ++i) {
    const JointRowInstant& row = instant_.joint_frictions[i];
    const bool turns = freedom_of(model_, row) == JointFreedom::Rotation;
    if (modes_.joints[i] != 0)
      add(Root::JointRests, static_cast<int>(i), scales_.speed / (turns ? scales_.length : 1), false);
    else
      add(Root::JointSlips, static_cast<int>(i), row.friction, true);
  }
  list_switches();
  return last;
}

EventSample EventRun::sample(const State& x) {
  EventSample s;
  s.x = x;
  if (!dynamics_.evaluate(x)) return s;
  s.nu_dot = dynamics_.nu_dot;
  s.force = dynamics_.force;
  s.moment = dynamics_.moment;
  s.joint_force = dynamics_.joint_force;
  s.joint_reaction =
      dynamics_.multipliers().head(static_cast<Eigen::Index>(dynamics_.instant().joint_rows.size()));
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
  s.normal.assign(roots_.size(), Vector3::Zero());
  std::size_t closed = 0;  // modes and roots are both in the order of points
  bool pulls = false, slider_pulls = false;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Root& root = roots_[at(i)];
    while (root.of_contact() && root.kind != Root::Touch && modes_.contacts[closed].point != root.index)
      ++closed;
    switch (root.kind) {
      case Root::Touch: {
        const int now = instant.contact_of_point[at(root.index)];
        s.g[i] = now < 0 ? infinity : instant.contacts[at(now)].psi_n;
        if (now < 0) break;
        s.g_rate[i] = instant.contacts[at(now)].velocity(s.x.nu).x();
        s.normal[at(i)] = instant.contacts[at(now)].frame.col(0);
        break;
      }
      case Root::Lift:
        s.g[i] = s.force[closed].x();
        break;
      case Root::ContactRests:
      case Root::WheelRests: {
        const Moving what = root.kind == Root::ContactRests ? Moving::Slip : Moving::Roll;
        s.g[i] = dynamics_.sliding_speed(s.x, closed, what);
        if (!root.armed && s.g[i] < 0) s.g[i] = -dynamics_.speed(s.x, closed, what);
        s.g_rate[i] = dynamics_.sliding_acceleration(closed, what);
        break;
      }
      case Root::ContactSlips:
      case Root::WheelRolls: {
        const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(root.index)])];
        const MomentInstant* m = instant.moments_of(c);
        if (m == nullptr)
          s.g[i] = c.mu * s.force[closed].x() - s.force[closed].tail<2>().norm();
        else
          s.g[i] = s.force[closed].x() - (root.kind == Root::WheelRolls
                                              ? rolling_pull(*m, s.moment[closed])
                                              : sliding_pull(c, *m, s.force[closed], s.moment[closed],
                                                             modes_.contacts[closed].lever));
        break;
      }
      case Root::JointRests:
        s.g[i] = modes_.joints[at(root.index)] * s.joint_rate[root.index];
        s.g_rate[i] = modes_.joints[at(root.index)] * dynamics_.joint_acceleration(at(root.index));
        break;
      case Root::JointSlips:
        s.g[i] = instant.joint_frictions[at(root.index)].friction - std::abs(s.joint_force[root.index]);
        break;
      case Root::Switch:
        s.g[i] = switches_.value(at(root.index), model_, s.x);
        break;
    }
    if (!root.of_force() || !(s.g[i] < -root.small)) continue;
    pulls = true;
    s.feasible = s.feasible && s.g[i] >= -root.vague;
    slider_pulls = slider_pulls || (root.kind == Root::Lift && modes_.contacts[closed].slides);
  }
  if (!pulls || slider_pulls || dynamics_.basis().size() == 0 || !take_feasible_forces(s)) return;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (roots_[at(i)].of_force()) s.g[i] = std::max(s.g[i], feasible_root * roots_[at(i)].small);
  }
}

bool EventRun::spent() const {
  constexpr long a_test = 300;  // evaluations that a complementarity problem is worth
  return dynamics_.evaluations + a_test * feasibility_tests_ > options_.max_evaluations;
}

}  // namespace perp
