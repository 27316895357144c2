// What a run writes down: rows, and events by the change of modes.
#include "step/events/event_run.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/certificate/certificate.hpp"
#include "step/events/row_quadrature.hpp"
#include "step/run/step_record.hpp"

namespace perp {
namespace {

const Contact& contact_of(const Model& model, int point) {
  return model.contact(model.contact_of_point(point)).law;
}

bool is_stop(const Model& model, int point) { return contact_of(model, point).stop.joint >= 0; }

}  // namespace

ContactMode mode_in(const Modes& modes, const Model& model, int point) {
  const ClosedContact* closed = modes.find(point);
  if (closed == nullptr) return ContactMode::Open;
  const Contact& contact = contact_of(model, point);
  const bool smooth = contact.mu == 0 && contact.torsion == 0 && !contact.friction_axes;
  return closed->slides || smooth ? ContactMode::Slip : ContactMode::Stick;
}

void EventRun::log(EventKind kind, const std::string& name, ContactMode before, ContactMode after) {
  const bool impact = kind == EventKind::Impact || kind == EventKind::Stop || kind == EventKind::Zeno;
  out_.events.push_back({.t = now_.x.t,
                         .kind = kind,
                         .contact = name,
                         .before = before,
                         .after = after,
                         .ambiguous = impact && ambiguous_});
}

/// Rolling against rolling friction that ends or begins, of a contact that stays closed.
void EventRun::log_rolling(const Modes& before, int point) {
  const ClosedContact *then = before.find(point), *now = modes_.find(point);
  if (then == nullptr || now == nullptr || then->rolls == now->rolls) return;
  const auto mode = [](bool rolls) { return rolls ? ContactMode::Slip : ContactMode::Stick; };
  log(now->rolls ? EventKind::Slip : EventKind::Stick, (*model_.point_names())[at(point)], mode(then->rolls),
      mode(now->rolls));
}

void EventRun::log_changes(const Modes& before, const std::vector<Root>& triggers) {
  const auto& names = *model_.point_names();
  model_.each_point([&](int p) {
    const ContactMode then = mode_in(before, model_, p), after = mode_in(modes_, model_, p);
    const auto jumped =
        std::find_if(jumped_.begin(), jumped_.end(), [&](const Jumped& j) { return j.point == p; });
    if (jumped != jumped_.end()) {
      log(jumped->kind == EventKind::Impact && is_stop(model_, p) ? EventKind::Stop : jumped->kind,
          names[at(p)], then, after);
      return;
    }
    log_rolling(before, p);
    if (then != after) {
      const EventKind kind = then == ContactMode::Open
                                 ? is_stop(model_, p) ? EventKind::Stop : EventKind::Touch
                             : after == ContactMode::Open  ? EventKind::Lift
                             : after == ContactMode::Stick ? EventKind::Stick
                                                           : EventKind::Slip;
      log(kind, names[at(p)], then, after);
    } else if (after == ContactMode::Slip && before.find(p)->slides &&
               triggered(triggers, Root::ContactRests, p)) {
      log(EventKind::Reverse, names[at(p)], then, after);
    }
  });
  for (std::size_t i = 0; i < modes_.joints.size(); ++i) {
    if (before.joints[i] == modes_.joints[i]) continue;
    const std::string& name = model_.joints()[at(instant_.joint_frictions[i].joint)].name;
    const auto mode = [](int sign) { return sign == 0 ? ContactMode::Stick : ContactMode::Slip; };
    log(modes_.joints[i] == 0   ? EventKind::Stick
        : before.joints[i] == 0 ? EventKind::Slip
                                : EventKind::Reverse,
        name, mode(before.joints[i]), mode(modes_.joints[i]));
  }
}

/// The part of a row's certificate that is about its end: the constraints of the modes in positions, velocities and accelerations
/// (19)-(23), these from the row's own forces, times h; and the bounds of friction.
void EventRun::certify(const EventSample& s) {
  report.status = StepStatus::Solved;
  report.solver = integrator_->name();
  report.iterations = static_cast<int>(dynamics_.evaluations - evaluations_before_);
  evaluations_before_ = dynamics_.evaluations;
  const Instant& instant = dynamics_.instant();
  report.gap_min = instant.gap_min();
  report.joint_error = instant.joint_error();
  report.energy = model_.energy(s.x);
  report.point_names = model_.point_names();

  const double h = report.h;
  Vector f = instant.k, nu_dot;
  std::vector<int> asked;
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    asked.push_back(instant.contact_of_point[at(modes_.contacts[i].point)]);
    const ContactInstant& c = instant.contacts[at(asked.back())];
    c.W.add_impulse(s.force[i], f);
    if (const MomentInstant* m = instant.moments_of(c)) m->W.add_impulse(s.moment[i], f);
  }
  for (Eigen::Index i = 0; i < s.joint_reaction.size(); ++i)
    instant.joint_rows[at(i)].W.add_impulse(s.joint_reaction.segment<1>(i), f);
  for (Eigen::Index i = 0; i < s.joint_force.size(); ++i)
    instant.joint_frictions[at(i)].W.add_impulse(s.joint_force.segment<1>(i), f);
  solve_mass(model_, instant, f, nu_dot);
  AccelerationBiases biases;
  biases.evaluate(model_, s.x, instant, asked);

  Residuals& e = report.residuals;
  e.newton_euler = e.kinematic = not_set;  // of a row's length: add_row and add_jump_row have them
  e.joints = report.joint_error;
  for (std::size_t i = 0; i < instant.joint_rows.size(); ++i) {
    const JointRowInstant& row = instant.joint_rows[i];
    const double u = row.velocity(s.x.nu), a = row.W.velocity(nu_dot)[0] + biases.joint_rows[i];
    e.joints = std::max({e.joints, h * std::abs(u), h * h * std::abs(a)});
  }
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    const ContactInstant& c = instant.contacts[at(asked[i])];
    const Vector3 u = c.velocity(s.x.nu), a = c.W.velocity(nu_dot) + biases.contacts[at(asked[i])];
    const Vector3& force = s.force[i];
    const double w = h * mobility(model_, instant, c);  // forces as speeds
    const double f_f = force.tail<2>().norm(), bound = c.mu * force.x();
    e.normal = std::max({e.normal, std::abs(u.x()), h * std::abs(a.x()), -w * force.x()});
    if (const MomentInstant* m = instant.moments_of(c)) {
      const Vector3 alpha = m->W.velocity(nu_dot) + biases.moments[at(c.moments)];
      e.friction = std::max(e.friction, moments_miss(c, *m, s, i, a, alpha, w));
    } else if (!modes_.contacts[i].slides) {
      const int n = c.tangents;
      e.friction =
          std::max({e.friction, u.segment(1, n).norm(), h * a.segment(1, n).norm(), w * (f_f - bound)});
    } else if (c.tangents > 0) {
      const Vector3 d = c.frame.transpose() * dynamics_.sliding_direction(s.x, i);
      e.friction = std::max(e.friction, w * (force.tail<2>() + bound * d.tail<2>()).norm());
    }
  }
  for (std::size_t i = 0; i < modes_.joints.size(); ++i) {
    if (modes_.joints[i] != 0) continue;
    const JointRowInstant& row = instant.joint_frictions[i];
    const double a = row.W.velocity(nu_dot)[0] + biases.joint_frictions[i];
    e.friction = std::max({e.friction, std::abs(row.velocity(s.x.nu)), h * std::abs(a)});
  }
}

/// How far friction and moments of closed contact i are from their laws, as speeds [m/s]: what rests by its velocity, acceleration and
/// bound, what moves by the difference to its friction. `w` turns forces into speeds.
double EventRun::moments_miss(const ContactInstant& c, const MomentInstant& m, const EventSample& s,
                              std::size_t i, const Vector3& a, const Vector3& alpha, double w) const {
  const ClosedContact& mode = modes_.contacts[i];
  const Vector3 &force = s.force[i], &moment = s.moment[i];
  const double lever = mode.lever, h = report.h;
  const FrictionShare share = dynamics_.sliding_share(s.x, i);
  double worst = 0;
  const auto rests = [&](const Vector3& speed, const Vector3& acceleration, double pull, double bound) {
    worst = std::max({worst, speed.norm(), h * acceleration.norm(), w * bound * (pull - force.x())});
  };
  const Vector3 u = c.velocity(s.x.nu), omega = m.velocity(s.x.nu);
  const double bound = std::max({c.mu, m.mu_o, m.torsion / lever});
  if (mode.slides)
    worst = w * std::hypot((force.tail<2>() - force.x() * share.force).norm(),
                           (moment.x() - force.x() * share.moment.x()) / lever);
  else
    rests(slip_of(c, &m, u, omega, lever), slip_of(c, &m, a, alpha, lever),
          sliding_pull(c, m, force, moment, lever), bound);
  if (mode.rolls)
    worst = std::max(worst, w / lever * (moment - force.x() * share.moment).tail<2>().norm());
  else
    rests(roll_of(c, &m, omega, lever), roll_of(c, &m, alpha, lever), rolling_pull(m, moment),
          m.rolling / lever);
  return worst;
}

/// The row of a step in fixed modes that ends at `end`; impulses, works and what they are checked against by the flow itself, or by
/// RowQuadrature of one that does not sum them. What is seen
/// of its end is `to`, the same but for rounding: where loads jump there it is on this side of the jump.
void EventRun::add_row(const EventSample& from, const EventSample& to, const State& end) {
  RowQuadrature quadrature;
  RowSums row = to.row;
  if (!row.known && quadrature.integrate(dynamics_, from.x, to.x, options_.rtol))
    row = quadrature.sums(model_);
  (void)dynamics_.rows(to.x);
  report = {};
  report.t = end.t;
  report.h = end.t - from.x.t;
  certify(to);
  report.residuals.newton_euler = row.known ? row.momentum_residual : not_set;
  report.residuals.kinematic = row.known ? row.kinematic_residual : not_set;
  const Instant& instant = dynamics_.instant();
  for (const EventSample* sample : {&from, &to}) add_shift(sample->shift, 0.5 * report.h, row);
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(modes_.contacts[i].point)])];
    ContactRow& contact =
        report.contacts.emplace_back(contact_row(c, Vector3::Zero(), mode_in(modes_, model_, c.point)));
    const Vector3 force = c.frame * to.force[i];
    if (to.feasible) contact.force = force;
    contact.p_n = row.known ? row.normal[i] : report.h * to.force[i].x();
    contact.impulse = row.known ? row.impulse[i] : report.h * force;
    if (c.moments >= 0) contact.moment = row.known ? row.moment[i] : report.h * (c.frame * to.moment[i]);
  }
  begin_joints(model_, report);
  const Vector reaction = row.known ? row.joint_reaction : report.h * to.joint_reaction;
  const Vector friction = row.known ? row.joint_friction : report.h * to.joint_force;
  for (std::size_t i = 0; i < instant.joint_rows.size(); ++i)
    add_joint_reaction(instant.joint_rows[i], reaction[static_cast<Eigen::Index>(i)], report);
  for (std::size_t i = 0; i < instant.joint_frictions.size(); ++i)
    add_joint_friction(instant.joint_frictions[i], friction[static_cast<Eigen::Index>(i)],
                       modes_.joints[i] == 0 ? ContactMode::Stick : ContactMode::Slip, report);
  end_joints(instant, to.x.nu, report);
  report.energy_friction = row.known ? row.friction : not_set;
  report.energy_load = row.known ? row.load : not_set;
  report.energy_motor = row.known ? row.motor : not_set;
  report.energy_surface = row.known ? row.surface : not_set;
  report.energy_overlap = not_set;  // closed contacts are closed: nothing is pushed out
  report.energy_left = report.energy - model_.energy(from.x) - report.energy_friction - report.energy_load -
                       report.energy_motor - report.energy_surface;
  out_.add(end, report);
}

/// The second row at an event: after it, with the impulses of a jump, whose momentum and energy are checked from the row before.
void EventRun::add_jump_row() {
  (void)dynamics_.rows(now_.x);
  report = {};
  report.t = now_.x.t;
  certify(now_);
  report.contacts = jump_rows_;
  const Instant& instant = dynamics_.instant();
  const State before = out_.back();
  Vector impulse = Vector::Zero(model_.nv()), momentum;
  double surface = 0, motor = 0;
  for (const ContactRow& row : jump_rows_) {
    const int i = instant.contact_of_point[at(row.point)];
    if (i < 0) continue;
    const ContactInstant& c = instant.contacts[at(i)];
    const Vector3 p = c.frame.transpose() * row.impulse;
    c.W.add_impulse(p, impulse);
    surface -= p.dot(c.bias);
    const MomentInstant* m = instant.moments_of(c);
    if (m != nullptr) {
      const Vector3 p_m = c.frame.transpose() * row.moment;
      m->W.add_impulse(p_m, impulse);
      surface -= p_m.dot(m->bias);
    }
    const double w = mobility(model_, instant, c);
    report.residuals.normal = std::max({report.residuals.normal, -c.velocity(now_.x.nu).x(), -w * row.p_n});
    if (m == nullptr)
      report.residuals.friction =
          std::max(report.residuals.friction, w * (p.tail<2>().norm() - c.mu * row.p_n));
  }
  for (std::size_t i = 0; i < modes_.contacts.size() && jump_rows_.empty(); ++i) {
    const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(modes_.contacts[i].point)])];
    report.contacts.push_back(contact_row(c, Vector3::Zero(), mode_in(modes_, model_, c.point)));
    if (now_.feasible) report.contacts.back().force = c.frame * now_.force[i];
  }
  begin_joints(model_, report);
  for (std::size_t i = 0; i < instant.joint_rows.size() && jump_reactions_.size() > 0; ++i) {
    const double p = jump_reactions_[static_cast<Eigen::Index>(i)];
    instant.joint_rows[i].W.add_impulse(WrenchMap<1>::Columns(p), impulse);
    (instant.joint_rows[i].prescribed ? motor : surface) -= p * instant.joint_rows[i].psi_b_t;
    add_joint_reaction(instant.joint_rows[i], p, report);
  }
  end_joints(instant, now_.x.nu, report);
  multiply_mass(model_, instant, now_.x.nu - before.nu, momentum);
  report.residuals.newton_euler =
      (momentum - impulse).size() > 0 ? (momentum - impulse).lpNorm<Eigen::Infinity>() : 0;
  report.residuals.kinematic = kinematic_residual(model_, before.q, before.nu, 0, now_.x.q);
  report.energy_surface = surface;
  report.energy_motor = motor;
  report.energy_impact =
      jump_energy_ - surface - motor;  // jump_energy_: change of kinetic energy, without friction's work
  report.energy_friction = jump_friction_;
  report.energy_load = report.energy_overlap = not_set;  // none in no time
  report.energy_left =
      report.energy - model_.energy(before) - report.energy_impact - report.energy_friction - surface - motor;
  out_.add(now_.x, report);
  continuation_->stretches.push_back({out_.size() - 1, modes_, scales_.small_speed()});
}

}  // namespace perp
