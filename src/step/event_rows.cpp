// What a run writes down: rows, and events by the change of modes.
#include "step/event_run.hpp"

#include <algorithm>
#include <cmath>

#include "step/step_record.hpp"

namespace perp {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

const Contact& contact_of(const Model& model, int point) {
  const auto& all = model.contacts();
  const auto after = std::upper_bound(all.begin(), all.end(), point,
                                      [](int p, const Contact& c) { return p < c.first_point; });
  return *(after - 1);
}

bool is_stop(const Model& model, int point) { return contact_of(model, point).stop.joint >= 0; }

}  // namespace

ContactMode mode_in(const Modes& modes, const Model& model, int point) {
  const ClosedContact* closed = modes.find(point);
  if (closed == nullptr) return ContactMode::Open;
  return closed->slides || contact_of(model, point).tangents == 0 ? ContactMode::Slip : ContactMode::Stick;
}

void EventRun::log(EventKind kind, const std::string& name, ContactMode before, ContactMode after) {
  out_.events.push_back({.t = now_.x.t, .kind = kind, .contact = name, .before = before, .after = after});
}

void EventRun::log_changes(const Modes& before, const std::vector<Root>& triggers) {
  const auto& names = *model_.point_names();
  for (int p = 0; p < model_.contact_points(); ++p) {
    const ContactMode then = mode_in(before, model_, p), after = mode_in(modes_, model_, p);
    const auto jumped =
        std::find_if(jumped_.begin(), jumped_.end(), [&](const Jumped& j) { return j.point == p; });
    if (jumped != jumped_.end()) {
      log(jumped->kind == EventKind::Impact && is_stop(model_, p) ? EventKind::Stop : jumped->kind,
          names[at(p)], then, after);
      continue;
    }
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
  }
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

/// Residuals at a row: those of the constraints that hold there.
void EventRun::certify(const EventSample& s) {
  report.status = StepStatus::Solved;
  report.solver = integrator_->name();
  report.iterations = static_cast<int>(dynamics_.evaluations - evaluations_before_);
  evaluations_before_ = dynamics_.evaluations;
  const Instant& instant = dynamics_.instant();
  report.gap_min = instant.gap_min();
  report.joint_error = instant.joint_error();
  report.residuals.joints = report.joint_error;
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    report.residuals.normal = std::max(report.residuals.normal, std::abs(s.velocity[i].x()));
    if (!modes_.contacts[i].slides)
      report.residuals.friction = std::max(report.residuals.friction, s.velocity[i].tail<2>().norm());
  }
  report.energy = model_.energy(s.x);
  report.point_names = model_.point_names();
}

/// The row at the end of a step in fixed modes; impulses and work by Simpson's rule.
void EventRun::add_row(const EventSample& from, const EventSample& middle, const EventSample& to) {
  (void)dynamics_.rows(to.x);
  report = {};
  report.t = to.x.t;
  report.h = to.x.t - from.x.t;
  certify(to);
  const Instant& instant = dynamics_.instant();
  const bool no_middle = middle.force.size() != to.force.size();
  const auto mean = [&](const auto& of) -> decltype(of(to)) {
    if (no_middle) return 0.5 * (of(from) + of(to));
    return (of(from) + 4 * of(middle) + of(to)) / 6;
  };
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(modes_.contacts[i].point)])];
    const Vector3 p = report.h * Vector3(mean([&](const EventSample& s) -> Vector3 { return s.force[i]; }));
    report.energy_friction += report.h * mean([&](const EventSample& s) -> double {
                                return s.force[i].tail<2>().dot(s.velocity[i].tail<2>());
                              });
    report.contacts.push_back({.contact = c.contact,
                               .point = c.point,
                               .gap = c.psi_n,
                               .p_n = p.x(),
                               .normal = c.frame.col(0),
                               .position = c.position,
                               .impulse = c.frame * p,
                               .force = c.frame * to.force[i],
                               .mode = mode_in(modes_, model_, c.point)});
  }
  begin_joints(model_, report);
  for (std::size_t i = 0; i < instant.joint_rows.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const double f = mean([&](const EventSample& s) -> double { return s.joint_reaction[j]; });
    add_joint_reaction(instant.joint_rows[i], report.h * f, report);
  }
  for (std::size_t i = 0; i < instant.joint_frictions.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const double f = mean([&](const EventSample& s) -> double { return s.joint_force[j]; });
    add_joint_friction(instant.joint_frictions[i], report.h * f,
                       modes_.joints[i] == 0 ? ContactMode::Stick : ContactMode::Slip, report);
    report.energy_friction +=
        report.h * mean([&](const EventSample& s) -> double { return s.joint_force[j] * s.joint_rate[j]; });
  }
  end_joints(instant, to.x.nu, report);
  out_.add(to.x, report);
}

/// The second row at an event: after it, with the impulses of a jump.
void EventRun::add_jump_row() {
  (void)dynamics_.rows(now_.x);
  report = {};
  report.t = now_.x.t;
  certify(now_);
  report.contacts = jump_rows_;
  report.energy_impact = jump_energy_;
  report.energy_friction = jump_friction_;
  const Instant& instant = dynamics_.instant();
  for (std::size_t i = 0; i < modes_.contacts.size() && jump_rows_.empty(); ++i) {
    const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(modes_.contacts[i].point)])];
    report.contacts.push_back({.contact = c.contact,
                               .point = c.point,
                               .gap = c.psi_n,
                               .normal = c.frame.col(0),
                               .position = c.position,
                               .force = c.frame * now_.force[i],
                               .mode = mode_in(modes_, model_, c.point)});
  }
  begin_joints(model_, report);
  for (std::size_t i = 0; i < instant.joint_rows.size() && jump_reactions_.size() > 0; ++i)
    add_joint_reaction(instant.joint_rows[i], jump_reactions_[static_cast<Eigen::Index>(i)], report);
  end_joints(instant, now_.x.nu, report);
  out_.add(now_.x, report);
  continuation_->stretches.push_back({out_.size() - 1, modes_, scales_.small_speed()});
}

}  // namespace perp
