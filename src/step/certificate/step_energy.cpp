#include "step/certificate/step_energy.hpp"

#include "core/index.hpp"

namespace perp {
double power_of_moving_springs(const Model& model, const Instant& s) {
  double power = 0;
  const auto moves = [&](BodyId b) { return model.body(b).kind == BodyKind::Prescribed; };
  for (const Spring& spring : model.springs()) {
    if (!moves(spring.a) && !moves(spring.b)) continue;
    const Pose &X_WA = s.X[at(spring.a.index)], &X_WB = s.X[at(spring.b.index)];
    const Vector3 x_a = X_WA * spring.point_a, x_b = X_WB * spring.point_b, d = x_b - x_a;
    const double l = d.norm();
    if (!(l > 0)) continue;
    const Vector3 force = -spring.stiffness * (1 - spring.length / l) * d;  // on B
    if (moves(spring.b)) power -= force.dot(s.V[at(spring.b.index)].at(x_b - X_WB.p));
    if (moves(spring.a)) power += force.dot(s.V[at(spring.a.index)].at(x_a - X_WA.p));
  }
  for (const JointSpring& spring : model.joint_springs()) {
    const JointRowInstant& c = s.coordinate(spring.joint, spring.coordinate);
    power += spring.stiffness * (c.psi_b - spring.rest) * c.psi_b_t;
  }
  return power;
}

StepEnergy::StepEnergy(const Model& model, const Instant& start, const State& x, const Instant& end,
                       const State& moved, const StepAnswer& answer, Vector& nu)
    : model_(model), start_(start), end_(end), x_(x), moved_(moved), answer_(answer), nu_(&answer.nu_q) {
  if (answer.jumped.empty()) return;
  nu = answer.nu_q;
  for (std::size_t i = 0; i < model.bodies().size(); ++i)
    if (const Body& b = model.bodies()[i]; answer.jumped[i] != 0)
      nu.segment(b.v0, b.nv) = 0.5 * (x.nu.segment(b.v0, b.nv) + moved.nu.segment(b.v0, b.nv));
  nu_ = &nu;
}

void StepEnergy::contact(const ContactInstant& c, const Vector3& p, const Vector3& u) {
  if (strikes(c.W)) return struck_contact(c, p);
  const double along = p.x() * u.x();
  (along > 0 ? overlap_ : impact_) += along;
  tangential(c, p, u);
}

void StepEnergy::struck_contact(const ContactInstant& c, const Vector3& p) {
  const Vector3 u = c.velocity(*nu_);
  impact_ += p.x() * u.x();
  struck_ += p.dot(u);
  tangential(c, p, u);
}

void StepEnergy::tangential(const ContactInstant& c, const Vector3& p, const Vector3& u) {
  friction_ += p.y() * u.y() + p.z() * u.z();
  surface_ -= p.dot(c.bias);
}

void StepEnergy::moments(const MomentInstant& m, const Vector3& p, const Vector3& omega) {
  const bool struck = strikes(m.W);
  const double work = p.dot(struck ? m.velocity(*nu_) : omega);
  friction_ += work;
  if (struck) struck_ += work;
  surface_ -= p.dot(m.bias);
}

void StepEnergy::joint_row(const JointRowInstant& row, const Acting& r) {
  const double p = r.p.x();
  (row.prescribed ? motor_ : surface_) -= p * row.psi_b_t;
  if (strikes(row.W)) {
    impact_ += p * row.velocity(*nu_);
    struck_ += p * row.velocity(*nu_);
  } else if (answer_.scheme == Scheme::Start && !answer_.joints_closed) {
    overlap_ += p * row.velocity(answer_.nu_q);
  } else {
    overlap_ += p * (end_.joint_rows[at(r.source)].psi_b - start_.joint_rows[at(r.source)].psi_b) / answer_.h;
  }
}

void StepEnergy::joint_friction(const JointRowInstant& row, double p, double u) {
  const bool struck = strikes(row.W);
  const double work = p * (struck ? row.velocity(*nu_) : u);
  friction_ += work;
  if (struck) struck_ += work;
  surface_ -= p * row.psi_b_t;
}

void StepEnergy::loads(const Instant& s, double h) {
  if (s.k_load.size() > 0) load_ += h * s.k_load.dot(*nu_);
  if (s.k_motor.size() > 0) motor_ += h * s.k_motor.dot(*nu_);
}

void StepEnergy::generalized(const Instant& s, double h) {
  for (std::size_t i = 0; i < s.masses.size(); ++i) {
    const Body& b = model_.bodies()[at(s.masses[i].body)];
    const Vector nu = nu_->segment(b.v0, b.nv);
    load_ += h * nu.dot(s.k.segment(b.v0, b.nv)) +
             h / answer_.h * 0.5 * nu.dot((end_.masses[i].M - start_.masses[i].M) * nu);
    if (!b.system.potential) continue;
    const auto V = [&](const State& y) { return b.system.potential(y.q.segment(b.q0, b.nq)); };
    load_ += h / answer_.h * (V(moved_) - V(x_));
  }
}

void StepEnergy::fill(double gained, StepReport& report) const {
  report.energy_friction = friction_;
  report.energy_impact = impact_;
  report.energy_load = load_;
  report.energy_motor = motor_;
  report.energy_surface = surface_;
  report.energy_overlap = overlap_;
  report.energy_left = gained - (friction_ + impact_ + load_ + motor_ + surface_ + overlap_);
}

}  // namespace perp
