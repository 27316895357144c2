#include "step/sensitivity/event_tangent.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/certificate/certificate.hpp"
#include "step/events/event_run.hpp"
#include "step/sensitivity/mode_flow.hpp"

namespace perp {
namespace {

/// What a root function is at x, where `dynamics` has been evaluated; `d` the direction of sliding of a contact that comes to rest.
double root_value(const Root& root, const ModeDynamics& dynamics, const State& x, const Vector3& d) {
  const Instant& s = dynamics.instant();
  const std::vector<ClosedContact>& closed = dynamics.modes().contacts;
  const auto of = std::find_if(closed.begin(), closed.end(),
                               [&](const ClosedContact& c) { return c.point == root.index; });
  const std::size_t i = at(of - closed.begin());
  const ContactInstant* c = root.of_contact() ? contact_at(s, root.index) : nullptr;
  if (root.of_contact() && (c == nullptr || (root.kind != Root::Touch && of == closed.end()))) return not_set;
  switch (root.kind) {
    case Root::Touch:
      return c->psi_n;
    case Root::Lift:
      return dynamics.force[i].x();
    case Root::ContactRests: {
      const Vector3 u = c->velocity(x.nu);
      return (u.y() * c->frame.col(1) + u.z() * c->frame.col(2)).dot(d);
    }
    case Root::ContactSlips:
      return c->mu * dynamics.force[i].x() - dynamics.force[i].tail<2>().norm();
    case Root::JointRests:
      return s.joint_frictions[at(root.index)].velocity(x.nu);
    case Root::JointSlips:
      return s.joint_frictions[at(root.index)].friction - std::abs(dynamics.joint_force[root.index]);
    case Root::WheelRests:
    case Root::WheelRolls:
    case Root::Switch:
      break;
  }
  return not_set;
}

/// One run and the tangent that goes along with it.
class EventTangent {
 public:
  EventTangent(const Model& model, const EventDriven& stepper, const SensitivityOptions& options,
               ParametersAlong& along, Eigen::Index parameters, StateTangent& tangent, Sensitivity& out)
      : model_(model),
        method_(stepper.options()),
        atol_(std::isnan(method_.atol) ? method_.rtol : method_.atol),
        options_(options),
        along_(along),
        parameters_(parameters),
        tangent_(tangent),
        out_(out),
        here_(model) {}

  State run(const State& x);

 private:
  using Stretch = EventContinuation::Stretch;
  bool flow(const Stretch& stretch, std::size_t last);
  std::size_t reach(std::size_t row, std::size_t last) const;
  bool pass(const std::vector<Root>& triggers, const Stretch* before, const Stretch& after, std::size_t row);
  bool event_times(const std::vector<Root>& triggers, const State& x, Vector& dt);
  double rate(const Root& root, const State& x, const Vector3& d);
  bool jump(const State& before, const State& after);
  void borders(const Stretch& stretch, const State& x, const std::vector<Root>& triggers);
  std::string begin(const Stretch& stretch, const State& x);
  std::string name_of(const Root& root) const;
  bool miss(const std::string& of, const std::string& what) {
    out_.missing.push_back({t_, of, what});
    return false;
  }
  void tell(const State& x) const {
    if (!options_.each) return;
    StateDerivative all = in_coordinates(model_, x, tangent_);
    options_.each(x, {all.q.leftCols(parameters_), all.nu.leftCols(parameters_)});
  }

  const Model& model_;
  const EventDrivenOptions method_;
  const double atol_;
  const SensitivityOptions& options_;
  ParametersAlong& along_;
  Eigen::Index parameters_;
  StateTangent& tangent_;
  Sensitivity& out_;
  Trajectory rows_;
  ModeDynamics here_;
  std::vector<FlowPair> pairs_;
  Scales scales_;
  double t_ = 0;
};

std::string EventTangent::name_of(const Root& root) const {
  if (root.of_contact()) return (*model_.point_names())[at(root.index)];
  if (root.kind == Root::Switch) return "";
  return model_.joint({here_.instant().joint_frictions[at(root.index)].joint}).name;
}

/// The run's own dynamics from the first state of a stretch.
std::string EventTangent::begin(const Stretch& stretch, const State& x) {
  Instant s;
  evaluate(model_, x, s);
  scales_.widen(scales_of(model_, x, s));
  here_.speed_error = method_.rtol * scales_.speed + atol_;
  return here_.begin(x, stretch.modes, stretch.small_speed);
}

/// How many rows one step of the differences goes over: twice the run's steps at most.
std::size_t EventTangent::reach(std::size_t row, std::size_t last) const {
  constexpr double longer =
      2.05;  // the run's tolerance is that of a pair's lower order; the higher has room for 2^9
  if (options_.each) return row + 1;
  double least = rows_.t(row + 1) - rows_.t(row);
  std::size_t to = row + 1;
  while (to < last) {
    least = std::min(least, rows_.t(to + 1) - rows_.t(to));
    if (rows_.t(to + 1) - rows_.t(row) > longer * least) break;
    ++to;
  }
  return to;
}

/// The tangent from the stretch's first row to its last.
bool EventTangent::flow(const Stretch& stretch, std::size_t last) {
  const State x = rows_.state(stretch.row);
  t_ = x.t;
  if (const std::string fault = begin(stretch, x); !fault.empty()) return miss("", fault);
  if (stretch.row == 0) borders(stretch, x, {});
  const std::vector<ParameterSides>& sides = along_.at(x, tangent_);
  pairs_.resize(sides.size());
  for (std::size_t j = 0; j < sides.size(); ++j) {
    FlowPair& pair = pairs_[j];
    const auto column = static_cast<Eigen::Index>(j);
    pair.eps = sides[j].eps > 0 ? sides[j].eps : half_width(model_, x, tangent_, column);
    const Vector xi = tangent_.xi.col(column), dnu = tangent_.nu.col(column);
    pair.plus.model = sides[j].plus;
    pair.minus.model = sides[j].minus;
    pair.plus.x = displaced(model_, x, xi, dnu, pair.eps);
    pair.minus.x = displaced(model_, x, xi, dnu, -pair.eps);
    const std::string fault = pair.begin(stretch.modes, stretch.small_speed, here_.speed_error);
    if (!fault.empty()) return miss("", fault);
  }
  const auto read_all = [&](const State& there) {
    for (std::size_t j = 0; j < pairs_.size(); ++j)
      read(model_, there, pairs_[j], static_cast<Eigen::Index>(j), tangent_);
  };
  for (std::size_t row = stretch.row; row < last;) {
    const std::size_t to = reach(row, last);
    const State there = rows_.state(to);
    t_ = there.t;
    for (FlowPair& pair : pairs_) {
      if (!pair.step(there.t)) return miss("", "the flow cannot be evaluated on one side");
      if (to == last && !pair.project()) return miss("", "the state is not finite on one side");
    }
    if (rows_.state(row).t < there.t && here_.rows(rows_.state(to - 1)))
      here_.begin_step(rows_.state(to - 1));
    row = to;
    if (options_.each || row == last) read_all(there);
    tell(there);
  }
  return true;
}

/// dg/dt along the run's flow in the modes that end.
double EventTangent::rate(const Root& root, const State& x, const Vector3& d) {
  if (!here_.evaluate(x)) return not_set;
  const Vector nu = x.nu, nu_dot = here_.nu_dot;
  const double dt = 1e-6 * (scales_.speed > 0 ? scales_.length / scales_.speed : 1);
  const auto value = [&](double t) {
    State there = displaced(model_, x, nu, nu_dot, t);
    there.t = x.t + t;
    return here_.evaluate(there) ? root_value(root, here_, there, d) : not_set;
  };
  return (value(dt) - value(-dt)) / (2 * dt);
}

/// By how much the event comes later for a unit of each column.
bool EventTangent::event_times(const std::vector<Root>& triggers, const State& x, Vector& dt) {
  bool known = false;
  dt.setZero(static_cast<Eigen::Index>(pairs_.size()));
  if (!here_.evaluate(x)) return miss("", "the flow cannot be evaluated");
  for (const Root& root : triggers) {
    Vector later = Vector::Zero(dt.size());
    if (root.kind != Root::Switch) {
      Vector3 d = Vector3::Zero();
      const std::vector<ClosedContact>& closed = here_.modes().contacts;
      for (std::size_t i = 0; i < closed.size(); ++i)
        if (root.kind == Root::ContactRests && closed[i].point == root.index)
          d = here_.sliding_direction(x, i);
      const double speed = rate(root, x, d);
      constexpr double grazing = 1e-7;  // of the speeds
      if (root.kind == Root::Touch && !(std::abs(speed) > grazing * scales_.speed))
        return miss(name_of(root), "grazes: it is reached without speed, or just not");
      for (std::size_t j = 0; j < pairs_.size(); ++j) {
        FlowPair& pair = pairs_[j];
        if (!pair.plus.dynamics->evaluate(pair.plus.x) || !pair.minus.dynamics->evaluate(pair.minus.x))
          return miss("", "the flow cannot be evaluated on one side");
        const double slope = (root_value(root, *pair.plus.dynamics, pair.plus.x, d) -
                              root_value(root, *pair.minus.dynamics, pair.minus.x, d)) /
                             (2 * pair.eps);
        later[static_cast<Eigen::Index>(j)] = -slope / speed;
      }
      if (!later.allFinite()) return miss(name_of(root), "has an event whose time has no derivative");
    }
    constexpr double same = 1e-5;  // events of contacts that repeat each other come together
    if (known && (later - dt).norm() > same * std::max(later.norm(), dt.norm()))
      return miss(name_of(root), "has its event together with another that comes later or sooner by itself");
    if (!known) dt = later;
    known = true;
  }
  (void)here_.evaluate(x);
  return true;
}

/// Velocities behind an impact, of both sides.
bool EventTangent::jump(const State& before, const State& after) {
  constexpr double same = 1e-8;  // of the speeds
  ++out_.impacts;
  ImpactOptions how{.restitution = method_.restitution, .small_gap = scales_.small_gap()};
  Impact impact = solve_impact(model_, before, how);
  if (!((impact.nu - after.nu).cwiseAbs().maxCoeff() <= same * scales_.speed)) {
    for (const ImpactContact& c : impact.contacts) how.inelastic.push_back(c.point);
    impact = solve_impact(model_, before, how);
    if (!((impact.nu - after.nu).cwiseAbs().maxCoeff() <= same * scales_.speed))
      return miss("", "velocities jump more than once at one time");
  }
  how.small_gap = std::max(how.small_gap, 1e-8 * scales_.length);
  for (FlowPair& pair : pairs_)
    for (FlowPair::Side* side : {&pair.plus, &pair.minus}) {
      const Impact there = solve_impact(*side->model, side->x, how);
      if (!there.solved || there.contacts.size() != impact.contacts.size())
        return miss("", "other contacts have a part in the impact on one side");
      for (std::size_t i = 0; i < impact.contacts.size(); ++i)
        if (there.contacts[i].mode != impact.contacts[i].mode)
          return miss((*model_.point_names())[at(impact.contacts[i].point)],
                      "is on the border of its modes in an impact");
      side->x.nu = there.nu;
    }
  return true;
}

/// What sticks at its bound when a stretch begins, and did not just begin to slip or stop.
void EventTangent::borders(const Stretch& stretch, const State& x, const std::vector<Root>& triggers) {
  constexpr double near = 1e-9;
  if (!here_.evaluate(x)) return;
  for (std::size_t i = 0; i < stretch.modes.contacts.size(); ++i) {
    const ClosedContact& closed = stretch.modes.contacts[i];
    const ContactInstant* c = contact_at(here_.instant(), closed.point);
    const bool began = std::any_of(triggers.begin(), triggers.end(),
                                   [&](const Root& r) { return r.of_contact() && r.index == closed.point; });
    const Vector3& f = here_.force[i];
    if (began || c == nullptr || c->tangents == 0 || !(c->mu > 0)) continue;
    const double pull = mobility(model_, here_.instant(), *c) * f.x();
    const bool stays = closed.slides && here_.speed(x, i) <= stretch.small_speed &&
                       std::abs(here_.sliding_acceleration(i)) <= near * pull;
    if (stays || (!closed.slides && std::abs(c->mu * f.x() - f.tail<2>().norm()) <= near * c->mu * f.x()))
      miss((*model_.point_names())[at(closed.point)],
           "is at the bound of its friction without sliding, so that it may stick or slip");
  }
}

/// Across the event between a row and the next, which begins the stretch `after`.
bool EventTangent::pass(const std::vector<Root>& triggers, const Stretch* before, const Stretch& after,
                        std::size_t row) {
  const State x = rows_.state(row), next = rows_.state(row + 1);
  t_ = x.t;
  Vector dt, acceleration;
  if (before == nullptr) {
    dt.setZero(tangent_.xi.cols());
    acceleration.setZero(model_.nv());
    const std::vector<ParameterSides>& sides = along_.at(x, tangent_);
    pairs_.resize(sides.size());
    for (std::size_t j = 0; j < sides.size(); ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      FlowPair& pair = pairs_[j];
      pair.eps = sides[j].eps > 0 ? sides[j].eps : half_width(model_, x, tangent_, column);
      pair.plus = {sides[j].plus,
                   displaced(model_, x, tangent_.xi.col(column), tangent_.nu.col(column), pair.eps), nullptr};
      pair.minus = {sides[j].minus,
                    displaced(model_, x, tangent_.xi.col(column), tangent_.nu.col(column), -pair.eps),
                    nullptr};
    }
  } else {
    if (!event_times(triggers, x, dt)) return false;
    acceleration = here_.nu_dot;
  }
  const auto shift = [&](const Vector& nu, const Vector& nu_dot, double sign) {
    for (std::size_t j = 0; j < pairs_.size(); ++j) {
      FlowPair& pair = pairs_[j];
      const double t = sign * pair.eps * dt[static_cast<Eigen::Index>(j)];
      for (const auto& [side, s] : {std::pair(&pair.plus, t), std::pair(&pair.minus, -t)}) {
        side->x = displaced(model_, side->x, nu, nu_dot, s);
        side->x.t += s;
      }
    }
  };
  shift(x.nu, acceleration, 1);
  constexpr double still = 1e-9;  // of the speeds
  if ((next.nu - x.nu).cwiseAbs().maxCoeff() > still * scales_.speed && !jump(x, next)) return false;
  if (const std::string fault = begin(after, next); !fault.empty()) return miss("", fault);
  if (!here_.evaluate(next)) return miss("", "the flow cannot be evaluated");
  acceleration = here_.nu_dot;
  shift(next.nu, acceleration, -1);
  for (std::size_t j = 0; j < pairs_.size(); ++j)
    read(model_, next, pairs_[j], static_cast<Eigen::Index>(j), tangent_);
  borders(after, next, triggers);
  tell(next);
  return true;
}

State EventTangent::run(const State& x0) {
  rows_ = Trajectory(x0, 0);
  const auto by = [this](Integrator kind) {
    return
        [this, kind](ModeDynamics& dynamics) { return make_integrator(kind, dynamics, method_.rtol, atol_); };
  };
  EventRun run(model_, method_, by(method_.integrator), by(Integrator::Arkode), rows_);
  if (!run.run({.t_end = options_.t_end, .h = options_.h})) throw StepFailure(run.report, rows_);
  out_.steps = static_cast<long>(rows_.steps());
  const EventContinuation& c = run.continuation();
  Instant s;
  evaluate(model_, x0, s);
  scales_ = scales_of(model_, x0, s);
  const std::vector<Stretch>& stretches = c.stretches;
  tell(rows_.front());
  bool alive = stretches.front().row == 0 || pass({}, nullptr, stretches.front(), stretches.front().row - 1);
  for (std::size_t k = 0; alive && k < stretches.size(); ++k) {
    const bool end = k + 1 == stretches.size();
    const std::size_t last = end ? rows_.size() - 1 : stretches[k + 1].row - 1;
    alive = flow(stretches[k], last);
    if (!alive || end) break;
    const auto ended =
        std::find_if(c.ends.begin(), c.ends.end(), [&](const auto& e) { return e.row == last; });
    if (ended == c.ends.end())
      alive = miss("", "events without end were carried across");
    else
      alive = pass(ended->triggers, &stretches[k], stretches[k + 1], last);
  }
  if (!alive) tangent_.xi.setConstant(not_set), tangent_.nu.setConstant(not_set);
  return rows_.back();
}

}  // namespace

State carry_through_events(const Model& model, const EventDriven& stepper, const State& x,
                           const SensitivityOptions& options, ParametersAlong& along, Eigen::Index parameters,
                           StateTangent& tangent, Sensitivity& out) {
  return EventTangent(model, stepper, options, along, parameters, tangent, out).run(x);
}

}  // namespace perp
