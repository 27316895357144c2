#include "step/penalty/penalty_laws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "step/implicit/implicit_step.hpp"

namespace perp {
namespace {

constexpr double stiff =
    0.5;  // h times the frequency of a contact whose stiffness is not set: an explicit step follows 2

/// The damping ratio with which a body bounces from a spring and damper with the restitution e.
double damping_ratio(double e) {
  if (!(e > 0)) return 1;
  const double l = std::log(e);
  return -l / std::sqrt(std::numbers::pi * std::numbers::pi + l * l);
}

}  // namespace

PenaltyContact::PenaltyContact(const Model& model, const Instant& s, const ContactInstant& contact,
                               const PenaltyOptions& options, double h, double slip_speed)
    : psi_n_(contact.psi_n), mu_(contact.mu), h_(h), slip_(slip_speed), tangents_(contact.tangents) {
  w = inverse_mass(model, s, contact.W, Law::Equality);
  k = std::isnan(options.stiffness) ? stiff * stiff / (h * h * w) : options.stiffness;
  c = std::isnan(options.damping) ? 2 * damping_ratio(contact.e) * std::sqrt(k / w) : options.damping;
}

Vector3 PenaltyContact::impulse(const Vector3& u, bool end, Matrix3& slope) const {
  Vector3 p = Vector3::Zero();
  slope.setZero();
  // implicit: the damper acts for the part of the step in which the contact is closed, without which p_n would jump
  const double by_end = -h_ * k * psi_n_ - (h_ * k + c) * h_ * u.x() - c * std::max(psi_n_, 0.0);
  const double by_start = psi_n_ < 0 ? -h_ * (k * psi_n_ + c * u.x()) : 0;
  p.x() = std::max(0.0, end ? by_end : by_start);
  if (p.x() == 0) return p;
  slope(0, 0) = end ? -h_ * (h_ * k + c) : 0;  // of constants nobody asks
  if (tangents_ == 0 || mu_ == 0) return p;
  const Vector2 u_f = u.tail<2>();
  const double speed = u_f.norm(), by = std::max(speed, slip_);
  const Vector2 along = u_f / by;
  p.tail<2>() = -mu_ * p.x() * along;
  slope.block<2, 1>(1, 0) = -mu_ * slope(0, 0) * along;
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity() / by;
  if (speed > slip_) turn -= along * along.transpose() / by;
  slope.block<2, 2>(1, 1) = -mu_ * p.x() * turn;
  return p;
}

double regularised_friction(double most, double u, double slip, double& slope) {
  slope = std::abs(u) < slip ? -most / slip : 0;
  return -most * u / std::max(std::abs(u), slip);
}

}  // namespace perp
