#include "perp/step/cp1.hpp"

#include <cmath>

#include "perp/core/errors.hpp"
#include "step/modes/acceleration_problem.hpp"
#include "step/modes/modes.hpp"
#include "step/parts/contact_blocks.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {

std::string_view name_of(Cp1Status status) {
  switch (status) {
    case Cp1Status::Unique:
      return "unique";
    case Cp1Status::Several:
      return "several";
    case Cp1Status::None:
      return "none";
  }
  return "";
}

Cp1Solution solve_cp1(const Model& model, const State& x, const Cp1Options& options) {
  model.check("solve_cp1", x);
  if (options.edges != 0 && options.edges < 3)
    refuse("solve_cp1", "edges", options.edges, "needs to be 0 (the circular cone), or 3 at least");
  if (options.edges != 0) need_no_moments("solve_cp1 with edges", model);
  if (options.relaxed) need_no_moments("solve_cp1, relaxed,", model);
  Instant instant;
  evaluate(model, x, instant);
  if (!instant.fault.empty()) refuse("solve_cp1", "x", "a state", instant.fault);
  const Scales scales = scales_of(model, x, instant);
  const Modes modes = modes_by_velocity(model, x, instant, scales);

  AccelerationProblem problem;
  problem.even = true;
  problem.assemble(model, x, instant, modes);
  AccelerationAnswer answer = problem.solve(model, options);
  if (options.relaxed && answer.status == Cp1Status::None) {
    for (ContactInstant& c : instant.contacts) {
      const ClosedContact* closed = modes.find(c.point);
      if (closed != nullptr && closed->slides) c.mu = 0;
    }
    problem.assemble(model, x, instant, modes);
    answer = problem.solve(model, options);
  }

  Cp1Solution solution;
  solution.status = answer.status;
  solution.complete = answer.complete;
  solution.residual = answer.residual;
  solution.acceleration = answer.nu_dot;
  solution.reactions = answer.reactions;
  const double small = 1e-8 * problem.acceleration_scale;
  for (std::size_t i = 0; i < modes.contacts.size(); ++i) {
    const ContactInstant& c = instant.contacts[static_cast<std::size_t>(problem.contact_index[i])];
    Cp1Contact row{.contact = c.contact, .point = c.point, .sliding = modes.contacts[i].slides};
    if (answer.status != Cp1Status::None) {
      row.c_n = answer.force[i].x();
      row.force = c.frame * answer.force[i];
      row.acceleration = answer.acceleration[i];
      const double zero = small + answer.small[i];
      const MomentInstant* m = instant.moments_of(c);
      const double lever = modes.contacts[i].lever;
      row.moment = c.frame * answer.moment[i];
      const Vector3 slip = slip_of(c, m, answer.acceleration[i], answer.angular_acceleration[i], lever);
      const bool slips = c.tangents == 0 || row.sliding || slip.norm() > zero;
      row.rolls =
          modes.contacts[i].rolls || roll_of(c, m, answer.angular_acceleration[i], lever).norm() > zero;
      row.mode = row.acceleration.x() > zero ? ContactMode::Open
                 : slips                     ? ContactMode::Slip
                                             : ContactMode::Stick;
    }
    solution.contacts.push_back(row);
  }
  for (std::size_t i = 0; i < modes.joints.size(); ++i) {
    const JointRowInstant& along = instant.joint_frictions[i];
    Cp1Joint row{.joint = along.joint, .coordinate = along.coordinate, .slips = modes.joints[i] != 0};
    if (answer.status != Cp1Status::None) {
      const auto j = static_cast<Eigen::Index>(i);
      row.friction = answer.joint_force[j];
      row.slips = row.slips || std::abs(answer.joint_acceleration[j]) > small;
    }
    solution.joints.push_back(row);
  }
  return solution;
}

}  // namespace perp
