// The second stage of ncp2: the velocity at the step's end, friction that goes on and impacts.
#pragma once

#include "step/impacts/impact_in_step.hpp"
#include "step/implicit/implicit_step.hpp"

namespace perp {

/// A step as its first stage left it.
struct HalfStep {
  const Model& model;
  const Instant& start;
  const Instant& end;
  const State& x;          ///< at the start
  const Vector& gained;    ///< by the loads: h M^-1 k
  const Vector& half;      ///< nu_½
  const Vector& momentum;  ///< T(nu_½) M nu_½ + h/2 f(q+, nu_½, t+), of M at q+
  double h = 0;
  double speed = 0;  ///< that misses are measured by [m/s]
};

/// How a reaction of the second stage came out of the first.
struct Slid {
  double e = 0, u_n_before = 0;  ///< restitution of a contact: u_n at the start of the step
  Vector3 direction =
      Vector3::Zero();  ///< u_½/|u_½| along t, o; zero: it stuck or arrived, and has its law at nu+
  /// Of a contact with moments: -p_f/p_n of what slid at u_½ (t, o, torsion), of what rolled (t, o); zero likewise.
  Vector3 sliding = Vector3::Zero();
  Vector2 rolling = Vector2::Zero();

  bool tied() const { return !direction.isZero(0) || !sliding.isZero(0) || !rolling.isZero(0); }
  void tie(const Reaction& contact, const Reaction& moments, double speed);
  void untie() { direction.setZero(), sliding.setZero(), rolling.setZero(); }
};

/// nu+ at q+, over the contacts that the first stage closed and all joints:
///   M nu+ = momentum + W(q+) p_2,   0 <= p_2n ⟂ u_n+ + e u_n- >= 0,   W_b(q+)ᵀ nu+ + dpsi_b/dt = 0
/// and friction: a contact that slid at nu_½ keeps -mu p_2n u_½/|u_½|, unless that would turn its slip round; one that stuck or
/// arrived has the cone at nu+.
///
/// An impact's law is for all of its impulse: p_1 of the bodies that it changes has moved q+ but gives no momentum, and this stage
/// finds the impulses of the whole step, at all contacts that touch.
class SecondStage {
 public:
  /// Which contacts close, and which bodies impacts change: takes these bodies' p_1 from `first`.
  void close(const HalfStep& step, std::vector<Reaction>& first);
  /// nu from nu_½; of an impact by the first law of `rebounds` that adds no energy. False: it has no answer.
  bool solve(const HalfStep& step, const NonsmoothNewton::Options& how, Vector& nu, int& iterations);

  std::vector<Reaction>& closed() { return closed_; }  ///< p_2
  const StruckBodies& struck() const { return struck_; }
  const NewtonOutcome& outcome() const { return outcome_; }

 private:
  bool take(const HalfStep& step, std::size_t i, const std::vector<Reaction>& first, Reaction& r,
            Vector3& bias, Slid& how) const;
  void pose(Vector& known);
  void read_posed(const Vector& nu);
  bool untie_all();
  bool untie_turned();
  bool solve_posed(const HalfStep& step, const NonsmoothNewton::Options& how, Vector& nu, int& iterations);

  StruckBodies struck_;
  std::vector<Reaction> closed_, posed_;  // p_2; what Newton sees of them
  std::vector<std::size_t> source_;       // of the posed, in the closed
  std::vector<Slid> slid_;                // of the closed
  std::vector<RelativeVelocity> velocities_, posed_velocities_;
  EnergyBefore energy_;
  NonsmoothNewton newton_;
  NewtonOutcome outcome_;
};

}  // namespace perp
