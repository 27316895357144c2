#include "step/events/row_sums.hpp"

#include <cmath>

#include "core/index.hpp"
#include "step/certificate/step_energy.hpp"

namespace perp {
namespace {

enum Work { Friction, Load, Motor, Surface, works };

/// Of a closed contact: along n, and the vector; with moments theirs too.
Eigen::Index of_contact(const Instant& s) { return s.moments.empty() ? 4 : 7; }

}  // namespace

RowSums& RowSums::operator+=(const RowSums& next) {
  if (!known) return *this = next;
  for (std::size_t i = 0; i < normal.size(); ++i) normal[i] += next.normal[i];
  for (std::size_t i = 0; i < impulse.size(); ++i) impulse[i] += next.impulse[i];
  for (std::size_t i = 0; i < moment.size(); ++i) moment[i] += next.moment[i];
  joint_reaction += next.joint_reaction;
  joint_friction += next.joint_friction;
  friction += next.friction;
  load += next.load;
  motor += next.motor;
  surface += next.surface;
  momentum_residual = std::max(momentum_residual, next.momentum_residual);
  kinematic_residual = std::max(kinematic_residual, next.kinematic_residual);
  return *this;
}

Eigen::Index RowRates::size(const ModeDynamics& dynamics) {
  const Instant& s = dynamics.instant();
  return of_contact(s) * static_cast<Eigen::Index>(dynamics.modes().contacts.size()) +
         static_cast<Eigen::Index>(s.joint_rows.size() + s.joint_frictions.size()) + works;
}

void RowRates::begin(const ModeDynamics& dynamics) {
  M_.clear();
  for (const Instant::GeneralizedMass& mass : dynamics.instant().masses) M_.push_back(mass.M);
}

void RowRates::assemble(const ModeDynamics& dynamics, const State& x) {
  const Instant& s = dynamics.instant();
  const Eigen::Index size = RowRates::size(dynamics), work = size - works;
  Q_.setZero(size, dynamics.row_count());
  q_.setZero(size);
  Eigen::Index sum = 0, z = 0;  // places of what is written next, among sums and impulses
  const auto joints = static_cast<Eigen::Index>(s.joint_rows.size());
  const auto& closed = dynamics.modes().contacts;
  z = joints;
  for (std::size_t i = 0; i < closed.size(); ++i, sum += of_contact(s)) {
    const ContactInstant& c = s.contacts[at(s.contact_of_point[at(closed[i].point)])];
    const MomentInstant* m = s.moments_of(c);
    const Vector3 u = c.velocity(x.nu);
    dynamics.for_columns(x, i, [&](const Vector3& f, const Vector3& moment) {
      Q_(sum, z) = f.x();
      Q_.block<3, 1>(sum + 1, z) = c.frame * f;
      Q_(work + Friction, z) = f.tail<2>().dot(u.tail<2>());
      Q_(work + Surface, z) = -f.dot(c.bias);
      if (m != nullptr) {
        Q_.block<3, 1>(sum + 4, z) = c.frame * moment;
        Q_(work + Friction, z) += moment.dot(m->velocity(x.nu));
        Q_(work + Surface, z) -= moment.dot(m->bias);
      }
      ++z;
    });
  }
  for (Eigen::Index i = 0; i < joints; ++i, ++sum) {
    const JointRowInstant& row = s.joint_rows[at(i)];
    Q_(sum, i) = 1;
    Q_(work + (row.prescribed ? Motor : Surface), i) = -row.psi_b_t;
  }
  for (std::size_t i = 0; i < s.joint_frictions.size(); ++i, ++sum) {
    const JointRowInstant& row = s.joint_frictions[i];
    const int sign = dynamics.modes().joints[i];
    const auto column = [&] { return Q_.col(z++); };
    const auto fill = [&](auto&& to, double force) {
      to[sum] += force;
      to[work + Friction] += force * row.velocity(x.nu);
      to[work + Surface] -= force * row.psi_b_t;
    };
    if (sign == 0)
      fill(column(), 1);
    else
      fill(q_, -sign * row.friction);
  }
  if (s.k_load.size() > 0) q_[work + Load] = s.k_load.dot(x.nu);
  if (s.k_motor.size() > 0) q_[work + Motor] = s.k_motor.dot(x.nu);
  q_[work + Surface] += power_of_moving_springs(dynamics.model(), s);
  for (const Instant::GeneralizedMass& mass : s.masses) {
    const Body& b = dynamics.model().bodies()[at(mass.body)];
    q_[work + Load] += x.nu.segment(b.v0, b.nv).dot(s.k.segment(b.v0, b.nv));
  }
}

void RowRates::add(const ModeDynamics& dynamics, const State& x, const Vector& z, double dt,
                   Eigen::Ref<Vector> sums) {
  sums += dt * q_;
  sums.noalias() += Q_ * z;
  const auto& masses = dynamics.instant().masses;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const Body& b = dynamics.model().bodies()[at(masses[i].body)];
    const Vector nu = x.nu.segment(b.v0, b.nv);
    sums[sums.size() - works + Load] += 0.5 * nu.dot((masses[i].M - M_[i]) * nu);
    M_[i] = masses[i].M;
  }
}

RowSums RowRates::unpack(const ModeDynamics& dynamics, const Vector& sums, const State& a, const State& b) {
  const Instant& s = dynamics.instant();
  RowSums row;
  row.known = true;
  Eigen::Index i = 0;
  for (std::size_t k = 0; k < dynamics.modes().contacts.size(); ++k, i += of_contact(s)) {
    row.normal.push_back(sums[i]);
    row.impulse.emplace_back(sums.segment<3>(i + 1));
    if (!s.moments.empty()) row.moment.emplace_back(sums.segment<3>(i + 4));
  }
  const auto take = [&](std::size_t n) {
    const Vector part = sums.segment(i, static_cast<Eigen::Index>(n));
    i += static_cast<Eigen::Index>(n);
    return part;
  };
  row.joint_reaction = take(s.joint_rows.size());
  row.joint_friction = take(s.joint_frictions.size());
  row.friction = sums[i + Friction];
  row.load = sums[i + Load];
  row.motor = sums[i + Motor];
  row.surface = sums[i + Surface];
  for (const Body& body : dynamics.model().bodies()) {
    if (body.kind != BodyKind::Generalized || !body.system.potential) continue;
    const auto V = [&](const State& x) { return body.system.potential(x.q.segment(body.q0, body.nq)); };
    row.load += V(b) - V(a);
  }
  return row;
}

}  // namespace perp
