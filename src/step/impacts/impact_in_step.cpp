#include "step/impacts/impact_in_step.hpp"

#include <algorithm>

namespace perp {
namespace {

/// Kinetic energy of one body at nu, M nu beside it.
double kinetic_energy(const Body& b, const Vector& nu, const Vector& momentum) {
  return 0.5 * nu.segment(b.v0, b.nv).dot(momentum.segment(b.v0, b.nv));
}

}  // namespace

double restitution_term(Rebound law, double e, double u_n_before) {
  switch (law) {
    case Rebound::Newton:
      return e * std::min(u_n_before, 0.0);
    case Rebound::Moreau:
      return e * u_n_before;
    case Rebound::Inelastic:
      return 0;
  }
  return 0;
}

void EnergyBefore::set(const Model& model, const Instant& instant, const Vector& nu, const Vector& nu_free,
                       const std::function<bool(std::size_t body)>& struck) {
  Vector momentum, momentum_free;
  multiply_mass(model, instant, nu, momentum);
  multiply_mass(model, instant, nu_free, momentum_free);
  energy_ = 0;
  counts_.assign(model.bodies().size(), 0);
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv == 0 || !struck(i)) continue;
    counts_[i] = 1;
    energy_ += std::max(kinetic_energy(b, nu, momentum), kinetic_energy(b, nu_free, momentum_free));
  }
  moved_ = std::any_of(instant.contacts.begin(), instant.contacts.end(),
                       [](const ContactInstant& c) { return !c.bias.isZero(0); }) ||
           std::any_of(instant.joint_rows.begin(), instant.joint_rows.end(),
                       [](const JointRowInstant& row) { return row.psi_b_t != 0; });
}

bool EnergyBefore::exceeded(const Model& model, const Instant& instant, const Vector& nu) const {
  constexpr double rounding = 1e-12;  // of the energy
  if (moved_) return false;
  Vector momentum;
  multiply_mass(model, instant, nu, momentum);
  double energy = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i)
    if (counts_[i] != 0) energy += kinetic_energy(model.bodies()[i], nu, momentum);
  return energy > energy_ * (1 + rounding);
}

}  // namespace perp
