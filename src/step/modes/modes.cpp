#include "step/modes/modes.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/parts/contact_blocks.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
JointFreedom freedom_of(const Model& model, const JointRowInstant& friction) {
  return model.joints()[at(friction.joint)].coordinates[at(friction.coordinate)].freedom;
}

const ClosedContact* Modes::find(int point) const {
  for (const ClosedContact& c : contacts)
    if (c.point == point) return &c;
  return nullptr;
}

Modes modes_by_velocity(const Model& model, const State& x, const Instant& instant, const Scales& scales,
                        const std::vector<int>& closing) {
  Modes modes;
  for (const ContactInstant& c : instant.contacts) {
    const Vector3 u = c.velocity(x.nu);
    if (c.psi_n > scales.small_gap()) continue;
    const bool closes = std::find(closing.begin(), closing.end(), c.point) != closing.end();
    if (u.x() > scales.small_speed() && !closes) continue;
    const MomentInstant* m = instant.moments_of(c);
    ClosedContact closed{.point = c.point};
    Vector3 omega = Vector3::Zero();
    if (m != nullptr) {
      closed.lever = lever_of(model, instant, c, *m);
      omega = m->velocity(x.nu);
    }
    const Vector3 slip = slip_of(c, m, u, omega, closed.lever), roll = roll_of(c, m, omega, closed.lever);
    closed.slides = slip.norm() > scales.small_speed();
    if (closed.slides) closed.direction = slip.normalized();
    closed.rolls = roll.norm() > scales.small_speed();
    if (closed.rolls) closed.rolling = roll.normalized();
    modes.contacts.push_back(closed);
  }
  for (const JointRowInstant& row : instant.joint_frictions) {
    const double rate = row.velocity(x.nu);
    const bool rests = std::abs(rate) <= scales.small_rate(freedom_of(model, row));
    modes.joints.push_back(rests ? 0 : rate > 0 ? 1 : -1);
  }
  return modes;
}

}  // namespace perp
