// What happens between stretches of an event-driven run: jumps, the modes of what follows, and what is carried across.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "perp/step/simulate.hpp"
#include "step/events/event_run.hpp"
#include "step/impacts/inelastic_step.hpp"

namespace perp {
namespace {

/// What of a contact with moments rests and begins to move: it is accelerated, or a trigger says that its friction came to its bound.
void begin_to_move(const ContactInstant& c, const MomentInstant& m, const Vector3& f, const Vector3& moment,
                   const Vector3& a, const Vector3& alpha, double small, const std::vector<Root>& triggers,
                   ClosedContact& contact) {
  constexpr double near = 1 - 1e-6;  // of the bound
  const auto moves = [&](const Vector3& acceleration, double pull, Root::Kind bound) {
    return acceleration.norm() > small ||
           (triggered(triggers, bound, contact.point) && pull > 0 && pull >= near * f.x());
  };
  const Vector3 slip = slip_of(c, &m, a, alpha, contact.lever), roll = roll_of(c, &m, alpha, contact.lever);
  if (!contact.slides && moves(slip, sliding_pull(c, m, f, moment, contact.lever), Root::ContactSlips)) {
    contact.slides = true;
    contact.direction =
        slip.norm() > small ? slip.normalized() : slip_against(c, &m, f, moment, contact.lever);
  }
  if (!contact.rolls && moves(roll, rolling_pull(m, moment), Root::WheelRolls)) {
    contact.rolls = true;
    contact.rolling = roll.norm() > small ? roll.normalized() : roll_against(c, &m, moment);
  }
}

}  // namespace

/// The modes that velocities say: what is at rest but for rounding comes to rest.
Modes EventRun::closed_modes(const State& x) const {
  Modes closed = modes_by_velocity(model_, x, instant_, scales_, closing_);
  const auto in = [](const std::vector<int>& points, int point) {
    return std::find(points.begin(), points.end(), point) != points.end();
  };
  for (ClosedContact& c : closed.contacts) {
    c.slides = c.slides && !in(resting_, c.point);
    c.rolls = c.rolls && !in(held_, c.point);
  }
  return closed;
}

/// Whether a closed contact accelerates into its other body by an answer of CP1: what joints drive there it cannot hold.
bool EventRun::goes_on(const AccelerationAnswer& answer) const {
  constexpr double most = 1e-5;  // of the accelerations
  for (std::size_t i = 0; i < answer.acceleration.size(); ++i)
    if (answer.acceleration[i].x() < -most * problem_.acceleration_scale - answer.small[i]) return true;
  return false;
}

/// CP1 in them; with a slight compliance where rows repeat each other, if it has an answer so.
AccelerationAnswer EventRun::accelerations(const State& x, const Modes& closed) {
  problem_.compliance = dynamics_.basis().size() > 0 ? slight_give : 0;
  // without sliding friction matrices are symmetric and answers that are several a rarity not worth much time
  const bool slides = std::any_of(closed.contacts.begin(), closed.contacts.end(),
                                  [](const ClosedContact& c) { return c.slides || c.rolls; });
  problem_.most_choices = slides ? AccelerationProblem::all_choices : 256;
  problem_.assemble(model_, x, instant_, closed);
  AccelerationAnswer answer = problem_.solve(model_, {});
  const auto none = [&] { return answer.status == Cp1Status::None || goes_on(answer); };
  if (none() && problem_.compliance > 0) {
    problem_.compliance = 0;
    problem_.assemble(model_, x, instant_, closed);
    answer = problem_.solve(model_, {});
  }
  if (none()) answer.status = Cp1Status::None;
  return answer;
}

/// The roots of the new modes. What goes on as it did does not start from zero.
void EventRun::arm_roots(const std::vector<Root>& triggers) {
  const std::vector<Root> last = list_roots();
  now_ = sample(State(now_.x));
  for (std::size_t i = 0; i < roots_.size() && now_.g.size() > 0; ++i) {
    Root& root = roots_[i];
    const bool steady = root.kind == Root::Touch || (!root.of_force() && jump_rows_.empty());
    root.armed = now_.g[static_cast<Eigen::Index>(i)] > root.vague ||
                 (steady && !triggered(triggers, root.kind, root.index) &&
                  std::any_of(last.begin(), last.end(), [&](const Root& r) {
                    return r.armed && r.kind == root.kind && r.index == root.index;
                  }));
  }
}

/// Jumps of velocity until nothing approaches, then the modes that CP1 says.
bool EventRun::settle(const std::vector<Root>& triggers) {
  State& x = now_.x;
  jump_rows_.clear();
  jump_reactions_.resize(0);
  jumped_.clear();
  jump_energy_ = jump_friction_ = 0;
  ambiguous_ = false;
  for (int attempt = 0; attempt < 10; ++attempt) {
    perp::evaluate(model_, x, instant_);
    if (!instant_.fault.empty()) return fail(StepStatus::NotFinite, instant_.fault);
    scales_.widen(scales_of(model_, x, instant_));
    if (instant_.gap_min() < -scales_.small_gap()) {  // one that had hardly opened and closed again
      if (!project_onto_constraints(model_, x).reached)
        return fail(StepStatus::NotSolved, "no state nearby satisfies the constraints");
      perp::evaluate(model_, x, instant_);
    }
    const bool approach =
        std::any_of(instant_.contacts.begin(), instant_.contacts.end(), [&](const ContactInstant& c) {
          return c.psi_n <= scales_.small_gap() && c.velocity(x.nu).x() < -scales_.small_speed();
        });
    if (approach || (attempt == 0 && (disturbed_ || still_) && joint_rate() > scales_.small_speed())) {
      if (!jump(false)) return fail(StepStatus::NotSolved, "an impact was not solved");
      continue;
    }
    const Modes closed = closed_modes(x);
    dynamics_.speed_error = options_.rtol * scales_.speed + atol_;
    if (const std::string fault = dynamics_.begin(x, closed, scales_.small_speed()); !fault.empty())
      return fail(StepStatus::NotFinite, fault);
    if (!std::isfinite(dynamics_.project(x))) return fail(StepStatus::NotFinite, "the state is not finite");
    perp::evaluate(model_, x, instant_);
    const AccelerationAnswer answer = accelerations(x, closed);
    if (answer.status == Cp1Status::None) {
      const std::size_t rows = jump_rows_.size();
      if (!jump(true) || jump_rows_.size() == rows)
        return fail(StepStatus::NotSolved, "CP1 has no solution, and no impact without collision was found");
      continue;
    }
    const Modes before = modes_;
    take_modes(closed, instant_, answer, triggers);
    if (answer.status == Cp1Status::Several)
      for (const ClosedContact& c : closed.contacts)
        if (c.slides)
          log(EventKind::Painleve, (*model_.point_names())[at(c.point)], mode_in(before, model_, c.point),
              mode_in(modes_, model_, c.point));
    if (const std::string fault = dynamics_.begin(x, modes_, scales_.small_speed()); !fault.empty())
      return fail(StepStatus::NotFinite, fault);
    resting_.clear();
    held_.clear();
    closing_.clear();
    arm_roots(triggers);
    if (now_.nu_dot.size() == 0 && model_.nv() > 0)
      return fail(StepStatus::NotFinite, "forces are not finite");
    dynamics_.begin_step(now_.x);
    return true;
  }
  return fail(StepStatus::NotSolved, "impacts follow each other without end at t = " + shortest(x.t));
}

void EventRun::take_modes(const Modes& closed, const Instant& instant, const AccelerationAnswer& answer,
                          const std::vector<Root>& triggers) {
  const double share = (problem_.compliance > 0 ? 1e-6 : 1e-8) * problem_.acceleration_scale;
  modes_.contacts.clear();
  for (std::size_t i = 0; i < closed.contacts.size(); ++i) {
    ClosedContact contact = closed.contacts[i];
    const ContactInstant& c = instant.contacts[at(problem_.contact_index[i])];
    const Vector3 f = answer.force[i], a = answer.acceleration[i];
    const double small = share + answer.small[i];
    if (a.x() > small) continue;
    // redundant contacts that the others leave without a force stay out: their least forces would pull
    const bool may_be_idle = triggered(triggers, Root::Lift, contact.point) || problem_.compliance > 0;
    if (may_be_idle && mobility(model_, instant, c) * f.x() <= small) continue;
    const MomentInstant* m = instant.moments_of(c);
    if (m != nullptr) {
      begin_to_move(c, *m, f, answer.moment[i], a, answer.angular_acceleration[i], small, triggers, contact);
    } else if (!contact.slides && c.tangents > 0) {
      const Vector2 a_f = a.tail<2>(), f_f = f.tail<2>();
      const bool at_limit = triggered(triggers, Root::ContactSlips, contact.point) && f_f.norm() > 0 &&
                            f_f.norm() >= c.mu * f.x() * (1 - 1e-6);
      if (a_f.norm() > small || at_limit) {
        const Vector2 d = a_f.norm() > small ? Vector2(a_f.normalized()) : Vector2(-f_f.normalized());
        contact.slides = true;
        contact.direction = d.x() * c.frame.col(1) + d.y() * c.frame.col(2);
      }
    }
    modes_.contacts.push_back(contact);
  }
  modes_.joints = closed.joints;
  for (std::size_t i = 0; i < closed.joints.size(); ++i) {
    if (closed.joints[i] != 0) continue;
    const double a = answer.joint_acceleration[static_cast<Eigen::Index>(i)];
    const double f = answer.joint_force[static_cast<Eigen::Index>(i)];
    const double most = instant.joint_frictions[i].friction;
    if (std::abs(a) > answer.joint_small[static_cast<Eigen::Index>(i)])
      modes_.joints[i] = a > 0 ? 1 : -1;
    else if (triggered(triggers, Root::JointSlips, static_cast<int>(i)) && std::abs(f) >= most * (1 - 1e-6) &&
             f != 0)
      modes_.joints[i] = f > 0 ? -1 : 1;
  }
}

bool EventRun::jump(bool jam) {
  ImpactOptions options{.restitution = options_.restitution,
                        .order = options_.impacts,
                        .without_collision = jam,
                        .small_gap = scales_.small_gap(),
                        .inelastic = {}};
  State& x = now_.x;
  perp::evaluate(model_, x, instant_);
  for (const ContactInstant& c : instant_.contacts) {
    const double approach = -c.velocity(x.nu).x();
    if (c.e > 0 && c.psi_n <= scales_.small_gap() && approach > scales_.small_speed() &&
        (still_ || inelastic(c.point, approach)))
      options.inelastic.push_back(c.point);
  }
  const Impact impact = solve_impact(model_, x, options);
  if (!impact.solved) return false;
  ambiguous_ = ambiguous_ || impact.ambiguous;
  double friction = 0;
  for (const ImpactContact& c : impact.contacts) {
    if (!(c.p_n > 0)) continue;
    const ContactInstant& s = instant_.contacts[at(instant_.contact_of_point[at(c.point)])];
    friction += c.friction;
    jump_rows_.push_back({.contact = c.contact,
                          .point = c.point,
                          .gap = s.psi_n,
                          .p_n = c.p_n,
                          .normal = s.frame.col(0),
                          .position = s.position,
                          .impulse = c.impulse,
                          .moment = c.moment,
                          .mode = c.mode});
    if (still_) continue;  // what the step before has left is no event
    const bool still =
        std::find(options.inelastic.begin(), options.inelastic.end(), c.point) != options.inelastic.end();
    if (std::none_of(jumped_.begin(), jumped_.end(), [&](const Jumped& j) { return j.point == c.point; }))
      jumped_.push_back({c.point,
                         jam     ? EventKind::Painleve
                         : still ? EventKind::Zeno
                                 : EventKind::Impact,
                         mode_in(modes_, model_, c.point)});
  }
  if (jump_reactions_.size() == 0) jump_reactions_.setZero(impact.joint_reactions.size());
  jump_reactions_ += impact.joint_reactions;
  jump_energy_ += impact.energy - friction;
  jump_friction_ += friction;
  x.nu = impact.nu;
  return true;
}

/// Whether a contact's bounces are as good as over: the last rose by less than is known of it, or they follow each other ever faster
/// and are very many.
bool EventRun::inelastic(int point, double approach) {
  Bounces& b = bounces_[point];
  const double interval = now_.x.t - b.last;
  if (interval <= 0) return false;
  b.chain = interval < b.interval ? b.chain + 1 : 0;
  b.interval = interval;
  b.last = now_.x.t;
  constexpr int very_many = 60;
  const double rise = approach * interval / 4;
  return rise < vague_gap() || b.chain >= very_many;
}

/// A ten-thousandth of the time in which things happen, by the model's scales; of the run, where all is at rest in the origin and says
/// nothing of such a time. It leads to the next jump of a load at most.
double EventRun::step_across(double t_stop) const {
  constexpr double share = 1e-4;
  const double t = now_.x.t, length = t_end_ - t_begin_, jump = just_before_jump();
  const double time = scales_.speed > 0 ? scales_.length / scales_.speed : length;
  const double h = std::min({share * time, t_stop - t, t_end_ - t});
  return jump > t ? std::min(h, jump - t) : h;
}

/// Where modes change for ever, or the equations of the modes have no solution: a step of the time-stepping method, which always has one.
bool EventRun::carry_across(double t_stop, const std::string& why) {
  constexpr int most = 200;
  if (++carried_ > most) return fail(StepStatus::NotSolved, why);
  const Modes before = modes_;
  const double h = step_across(t_stop);
  report = {};
  if (!inelastic_step(model_, now_.x, h, report))
    return fail(StepStatus::NotSolved, why + "; nor could a step across it be made");
  report.t = now_.x.t;
  report.h = h;
  report.status = StepStatus::Solved;
  report.solver = "inelastic-step";
  perp::evaluate(model_, now_.x, instant_);
  report.gap_min = instant_.gap_min();
  report.joint_error = report.residuals.joints = instant_.joint_error();
  report.energy = model_.energy(now_.x);
  report.point_names = model_.point_names();
  out_.add(now_.x, report);
  event_times_.clear();
  restart_ = true;
  natural_step_ = 0;
  short_steps_ = 0;
  still_ = true;
  const bool settled = settle({});
  still_ = false;
  if (!settled) return false;
  log(EventKind::Zeno, "", ContactMode::Open, ContactMode::Open);
  log_changes(before, {});
  add_jump_row();
  return true;
}

}  // namespace perp
