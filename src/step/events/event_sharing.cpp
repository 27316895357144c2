// Forces of redundant contacts and joints at rest: those of the rule with cones, where the flow's would pull or leave theirs.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/certificate/pass_mark.hpp"
#include "step/events/event_run.hpp"

namespace perp {

/// Whether the modes stay as they are by an answer of CP1 in them.
bool EventRun::holds(const Modes& modes, const AccelerationProblem& problem,
                     const AccelerationAnswer& answer) const {
  const double small = 1e-6 * problem.acceleration_scale;
  const Instant& instant = dynamics_.instant();
  for (std::size_t i = 0; i < modes.contacts.size(); ++i) {
    const ClosedContact& mode = modes.contacts[i];
    const ContactInstant& c = instant.contacts[at(problem.contact_index[i])];
    const MomentInstant* m = instant.moments_of(c);
    const Vector3 slip = slip_of(c, m, answer.acceleration[i], answer.angular_acceleration[i], mode.lever),
                  roll = roll_of(c, m, answer.angular_acceleration[i], mode.lever);
    if (answer.acceleration[i].x() > small || (!mode.slides && slip.norm() > small) ||
        (!mode.rolls && roll.norm() > small))
      return false;
  }
  for (std::size_t i = 0; i < modes.joints.size(); ++i)
    if (modes.joints[i] == 0 && std::abs(answer.joint_acceleration[static_cast<Eigen::Index>(i)]) >
                                    answer.joint_small[static_cast<Eigen::Index>(i)])
      return false;
  return true;
}

/// Where contacts at rest are redundant, forces that pull or leave their cones do not say that others would: CP1 knows, by the same rule
/// with cones, and the sample's are then its. Where some slide forces change the motion, and the least ones are a rule.
bool EventRun::take_feasible_forces(EventSample& s) {
  ++feasibility_tests_;
  AccelerationProblem problem;
  const Instant instant = dynamics_.instant();
  Modes modes = modes_;
  for (std::size_t i = 0; i < modes.contacts.size(); ++i)
    if (modes.contacts[i].slides) modes.contacts[i].direction = dynamics_.sliding_direction(s.x, i);
  for (std::size_t i = 0; i < modes.contacts.size(); ++i)
    if (modes.contacts[i].rolls)
      modes.contacts[i].rolling = dynamics_.sliding_direction(s.x, i, Moving::Roll);
  AccelerationAnswer answer;
  for (const bool even : {true, false}) {
    problem.even = even;
    problem.compliance = even ? 0 : slight_give;
    problem.assemble(model_, s.x, instant, modes);
    answer = problem.any_solution(model_);
    if (answer.status != Cp1Status::None) break;
  }
  if (answer.status == Cp1Status::None || !holds(modes, problem, answer)) return false;
  constexpr double same = 1e-6;  // motion, of accelerations
  const Vector change = answer.nu_dot - s.nu_dot;
  Vector force;
  multiply_mass(model_, instant, change, force);
  const auto& bodies = model_.bodies();
  if (std::all_of(bodies.begin(), bodies.end(), [&](const Body& b) {
        return b.nv == 0 || speed_of(b, force, change) <= same * problem.acceleration_scale;
      }))
    take_forces(answer, s);
  return true;
}

void EventRun::take_forces(const AccelerationAnswer& answer, EventSample& s) const {
  const Instant& instant = dynamics_.instant();
  ForceShift& shift = s.shift;
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(modes_.contacts[i].point)])];
    shift.contact.emplace_back(c.frame * (answer.force[i] - s.force[i]));
    s.force[i] = answer.force[i];
    if (s.moment.empty()) continue;
    shift.moment.emplace_back(c.frame * (answer.moment[i] - s.moment[i]));
    s.moment[i] = answer.moment[i];
  }
  shift.joint_reaction = answer.reactions - s.joint_reaction;
  shift.joint_friction = answer.joint_force - s.joint_force;
  s.joint_reaction = answer.reactions;
  s.joint_force = answer.joint_force;
  s.feasible = true;
}

/// What forces that redundant rows take in place of the flow's add to its impulses in a time; they do no work.
void EventRun::add_shift(const ForceShift& shift, double time, RowSums& row) const {
  if (shift.none() || !row.known) return;
  const Instant& instant = dynamics_.instant();
  for (std::size_t i = 0; i < shift.contact.size(); ++i) {
    const ContactInstant& c = instant.contacts[at(instant.contact_of_point[at(modes_.contacts[i].point)])];
    row.normal[i] += time * c.frame.col(0).dot(shift.contact[i]);
    row.impulse[i] += time * shift.contact[i];
    if (!shift.moment.empty()) row.moment[i] += time * shift.moment[i];
  }
  row.joint_reaction += time * shift.joint_reaction;
  row.joint_friction += time * shift.joint_friction;
}

}  // namespace perp
