#include "step/events/acceleration_biases.hpp"

namespace perp {

void AccelerationBiases::evaluate(const Model& model, const State& x, const Instant& instant,
                                  std::span<const int> asked) {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  contacts.assign(instant.contacts.size(), Vector3::Zero());
  moments.assign(instant.moments.size(), Vector3::Zero());
  int last = -1;
  for (const int i : asked) {
    const ContactInstant& c = instant.contacts[at(i)];
    if (c.contact != last) {
      const ContactView contact = model.contact(c.contact);
      points_.resize(at(contact.gap.points()));
      if (contact.law.stop.joint < 0 &&
          !contact.law.own)  // of a stop the joint's coordinate has them, of others their body
        contact.gap.differentiate(instant.X[at(contact.a.index)], instant.X[at(contact.b.index)], instant.t,
                                  points_);
      last = c.contact;
    }
    const ContactDerivative& geometry = points_[at(c.slot)];
    contacts[at(i)] = acceleration_bias(model, x, instant, c, geometry);
    if (c.moments >= 0) moments[at(c.moments)] = moments_acceleration_bias(model, x, instant, c, geometry);
  }
  const auto of_rows = [&](const std::vector<JointRowInstant>& rows, std::vector<double>& out) {
    out.resize(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) out[i] = acceleration_bias(model, x, instant, rows[i]);
  };
  of_rows(instant.joint_rows, joint_rows);
  of_rows(instant.joint_frictions, joint_frictions);
}

}  // namespace perp
