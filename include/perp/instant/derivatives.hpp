// How the system changes with its configuration: what a Newton method at the end of a step needs, and accelerations.
#pragma once

#include <span>

#include "perp/instant/instant.hpp"

namespace perp {

/// First derivatives of a pair's wrench map and relative velocity by xi, a small motion of bodies a and b in nu's
/// coordinates (q ⊕ xi), at fixed nu. Columns: six for a, six for b, those past a body's velocities zero.
template <int C>
struct PairDerivative {
  Eigen::Matrix<double, 12, 12> force;     ///< of W p; rows as the columns
  Eigen::Matrix<double, C, 12> velocity;   ///< of W^T nu + (explicit part)
  Eigen::Matrix<double, C, 1> velocity_t;  ///< its explicit time derivative, prescribed bodies moving [m/s^2]
};

/// Contact c at the state x, impulse p along its n, t, o. `geometry` is that of its point, from Gap::differentiate; a generalized
/// body's own gap needs none: its columns are differentiated here, by central differences of order 8.
void differentiate(const Model& model, const State& x, const Instant& instant, const ContactInstant& c,
                   const ContactDerivative& geometry, const Vector3& p, PairDerivative<3>& out);

/// The moments of contact c, which has some, as Instant::moments has them; p their impulses about n, t, o.
void differentiate_moments(const Model& model, const State& x, const Instant& instant,
                           const ContactInstant& c, const ContactDerivative& geometry, const Vector3& p,
                           PairDerivative<3>& out);

/// A joint's equation or its motion with friction, impulse p.
void differentiate(const Model& model, const Instant& instant, const JointRowInstant& row, double p,
                   PairDerivative<1>& out);

/// b with d/dt (W^T nu + explicit part) = W^T nu' + b along the motion: the second-order terms of the gap, of the turning
/// contact frame, of W, of prescribed bodies and moving surfaces [m/s^2].
[[nodiscard]] Vector3 acceleration_bias(const Model& model, const State& x, const Instant& instant,
                                        const ContactInstant& c, const ContactDerivative& geometry);
/// The same of its moments' angular velocities [rad/s^2].
[[nodiscard]] Vector3 moments_acceleration_bias(const Model& model, const State& x, const Instant& instant,
                                                const ContactInstant& c, const ContactDerivative& geometry);
[[nodiscard]] double acceleration_bias(const Model& model, const State& x, const Instant& instant,
                                       const JointRowInstant& row);

/// All contact points of one contact share a call to its gap; this keeps them, in the order of Instant::contacts.
class ContactDerivatives {
 public:
  /// Of the contacts `which`, one contact's points one after the other; of all, in the second form.
  void evaluate(const Model& model, const Instant& instant, std::span<const int> which);
  void evaluate(const Model& model, const Instant& instant);
  const ContactDerivative& operator[](std::size_t i) const { return all_[i]; }

 private:
  std::vector<ContactDerivative> all_, points_;
};

/// A block of the loads' derivatives: of body `row`'s part of Instant::k by the motion and the velocity of body `column`.
struct LoadDerivative {
  int row = 0, column = 0;             ///< bodies
  Eigen::Matrix<double, 6, 6> xi, nu;  ///< by xi, by nu; past the bodies' velocities zero
  bool gyroscopic = false;             ///< of -w x J w
};

/// Of all loads and gyroscopic terms: springs exactly, functions of one's own (add_force, generalized bodies) by central
/// differences. Several blocks may share row and column; out is cleared first.
void differentiate_loads(const Model& model, const State& x, const Instant& instant,
                         std::vector<LoadDerivative>& out);

/// The same of M(q) y, y fixed: blocks of generalized bodies, the only ones whose M moves.
void differentiate_mass(const Model& model, const State& x, const Vector& y,
                        std::vector<LoadDerivative>& out);

}  // namespace perp
