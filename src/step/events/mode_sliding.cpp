// How the contacts of a stretch slide and roll: speeds, and the directions that friction opposes.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/events/mode_dynamics.hpp"

namespace perp {
namespace {

// times the error of a velocity [-]
constexpr double uncertain = 300;  // its direction is known to a few thousandths
constexpr double unknown = 30;  // to a few hundredths: friction that turns with it would follow what is noise

}  // namespace

/// u_f of a contact without moments; with them slip_of or roll_of. World axes.
Vector3 ModeDynamics::velocity_of(const State& x, std::size_t i, Moving what) const {
  const ContactInstant& c = contact(i);
  const MomentInstant* m = s_.moments_of(c);
  const double lever = modes_.contacts[i].lever;
  const Vector3 omega = m == nullptr ? Vector3::Zero().eval() : m->velocity(x.nu);
  return what == Moving::Slip ? slip_of(c, m, c.velocity(x.nu), omega, lever) : roll_of(c, m, omega, lever);
}

void ModeDynamics::begin_step(const State& x) {
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i)
    for (const Moving what : {Moving::Slip, Moving::Roll})
      if (moves(i, what)) begin_step(x, i, what);
  // of joints alone the motion does not depend on which of their forces are taken, and a loop turns away from those of its start
  if (V_.size() > 0 && modes_.contacts.empty()) find_basis();
}

void ModeDynamics::begin_step(const State& x, std::size_t i, Moving what) {
  constexpr double stopped = 1e-7;  // of the largest speed: what direction it then has changes nothing [-]
  const ContactInstant& c = contact(i);
  Sliding& s = (what == Moving::Slip ? slips_ : rolls_)[i];
  if (c.tangents == 0) return;
  if (c.tangents == 1) {
    const Vector3 line = c.frame.col(what == Moving::Slip ? 1 : 2);
    s.direction = (line.dot(s.direction) > 0 ? 1 : -1) * line;
    return;
  }
  const Vector3 u_f = velocity_of(x, i, what);
  const double speed = u_f.norm();
  s.fastest = std::max(s.fastest, speed);
  s.straight = speed < s.speed && speed < std::max(stopped * s.fastest, uncertain * speed_error);
  s.speed = speed;
  if (s.from_rest ? speed > slow() : speed > small_speed_ && u_f.dot(s.direction) > 0)
    s.direction = u_f / speed;
  if (speed > slow()) s.from_rest = false;
}

/// What begins to slide keeps its direction up to this speed.
double ModeDynamics::slow() const { return std::max(small_speed_, unknown * speed_error); }

double ModeDynamics::sliding_speed(const State& x, std::size_t i, Moving what) const {
  const Vector3 u_f = velocity_of(x, i, what);
  const Sliding& s = sliding(i, what);
  return contact(i).tangents == 2 && s.from_rest ? u_f.norm() : u_f.dot(s.direction);
}

double ModeDynamics::sliding_acceleration(std::size_t i, Moving what) const {
  const ContactInstant& c = contact(i);
  const Vector3 a = c.W.velocity(nu_dot) + biases_.contacts[at(asked_[i])], d = sliding(i, what).direction;
  const MomentInstant* m = s_.moments_of(c);
  if (m == nullptr) {
    double along = 0;
    for (int t = 1; t <= c.tangents; ++t) along += a[t] * c.frame.col(t).dot(d);
    return along;
  }
  const Vector3 alpha = m->W.velocity(nu_dot) + biases_.moments[at(c.moments)];
  const double lever = modes_.contacts[i].lever;
  return (what == Moving::Slip ? slip_of(c, m, a, alpha, lever) : roll_of(c, m, alpha, lever)).dot(d);
}

double ModeDynamics::joint_acceleration(std::size_t i) const {
  return s_.joint_frictions[i].W.velocity(nu_dot)[0] + biases_.joint_frictions[i];
}

bool ModeDynamics::as_good_as_stopped(const State& x, std::size_t i, Moving what) const {
  return sliding(i, what).straight || speed(x, i, what) <= uncertain * speed_error;
}

Vector3 ModeDynamics::sliding_direction(const State& x, std::size_t i, Moving what) const {
  return friction_direction(contact(i), i, what, velocity_of(x, i, what));
}

FrictionShare ModeDynamics::sliding_share(const State& x, std::size_t i) const {
  const ContactInstant& c = contact(i);
  const MomentInstant* m = s_.moments_of(c);
  const ClosedContact& mode = modes_.contacts[i];
  FrictionShare share;
  if (m == nullptr) {
    if (mode.slides && c.tangents > 0)
      share.force = -c.mu * (c.frame.transpose() * sliding_direction(x, i)).tail<2>();
    return share;
  }
  const auto along = [&](Moving what) {
    return moves(i, what) ? sliding_direction(x, i, what) : Vector3::Zero().eval();
  };
  return friction_share(c, *m, along(Moving::Slip), along(Moving::Roll), mode.lever);
}

/// The direction of u_f, kept as it was at the step's start past the point where u_f goes through zero: so that the right-hand
/// side is smooth there, and what slides straight does so to the last bit.
Vector3 ModeDynamics::friction_direction(const ContactInstant& c, std::size_t i, Moving what,
                                         const Vector3& u_f) const {
  const Sliding& s = sliding(i, what);
  if (c.tangents == 1) {
    const Vector3 line = c.frame.col(what == Moving::Slip ? 1 : 2);
    return (line.dot(s.direction) > 0 ? 1 : -1) * line;
  }
  if (s.straight) return s.direction;
  constexpr double straight = 1e-11;  // a turn of less than this in the step is rounding [-]
  const double along = u_f.dot(s.direction), size = u_f.norm();
  if (size <= (s.from_rest ? slow() : small_speed_) ||
      (u_f - along * s.direction).norm() <= straight * std::max(size, s.speed))
    return s.direction;
  return (along >= 0 || s.from_rest ? 1 : -1) / size * u_f;
}

}  // namespace perp
