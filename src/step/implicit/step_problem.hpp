// The nonsmooth equations of an implicit step, as its Newton sees them: one form for all methods.
//
//   R(nu) - sum_i W_i p_i = 0                                   momentum, one block a body            (1)
//   p_i ∈ C_i(p_i),  u_i(nu) against p_i by the law of i        one or more rows a reaction            (2)
// with nu a velocity of the whole system and p_i impulses.
#pragma once

#include <span>
#include <vector>

#include "perp/instant/instant.hpp"
#include "perp/solve/friction_problem.hpp"

namespace perp {

/// What ties an impulse to its velocity. Rows used: n, t, o of p and u.
enum class Law {
  Equality,  ///< u_n = 0, p_n free: a joint's equation
  HalfLine,  ///< 0 <= p_n ⟂ u_n >= 0
  Planar,    ///< and |p_t| <= mu p_n with maximum work
  Cone,      ///< and |(p_t, p_o)| <= mu p_n with maximum work
  Interval,  ///< |p_t| <= mu, u_t = 0 inside, of the sign of -p_t at the ends: dry friction of a joint
  Moments,  ///< of the contact in front of it: torsion, rolling t, o, whose bounds its p_n sets (step/parts/moment_laws.hpp)
};

/// The same law in contact problems; an equality has none.
BlockKind kind_of(Law law);
/// First of the rows n, t, o in use, and how many.
std::pair<int, int> rows_of(Law law);

/// One contact point, joint row or joint friction.
struct Reaction {
  using Slope = Eigen::Matrix<double, 3, 12>;
  Law law = Law::HalfLine;
  double mu = 0;  ///< coefficient [-], of an interval its bound [N s]
  enum class Of { Contact, JointRow, JointFriction, Moments } of = Of::Contact;
  int source = 0;           ///< contact point of the model, or index among an instant's rows or frictions
  WrenchMap<3> W;           ///< columns n, t, o: p acts as W p
  Slope G = Slope::Zero();  ///< du/dnu, columns of both bodies' velocities
  static constexpr double no_point = 1e300;  ///< u_n where a contact point is not there: it stays open
  Vector3 u = Vector3::Zero();               ///< [m/s]
  Vector3 p = Vector3::Zero();               ///< [N s]
  double w = 1;         ///< velocity that a unit impulse gives, tr(Wᵀ M^-1 W)/rows; scales p to u [1/kg]
  double length = 1;    ///< that a unit of u is worth, of angles [m]
  double speed = 0;     ///< that it brings into its island, of the step's data alone (StepSpeeds) [m/s]
  double rounding = 0;  ///< of u: what psi/h cannot go below
  bool has_moments = false;  ///< of a contact: the next reaction is that of its moments
  double lever = 1;  ///< of moments: p is the moment's impulse over it, u the angular velocity times it [m]
  double mu_o = 0;   ///< of moments: their contact's coefficient along o; its mu is that along t
  double torsion = 0, rolling = 0;  ///< of moments, as the contact has them [m]
};

/// dR/dnu by pairs of bodies; those at the same place add up.
struct Coupling {
  int row = 0, column = 0;  ///< bodies
  Eigen::Matrix<double, 6, 6> value;
};

/// M of the instant on the diagonal.
void add_mass(const Model& model, const Instant& instant, std::vector<Coupling>& K);

/// The equations, at a guess. Implemented once a method.
class StepProblem {
 public:
  virtual ~StepProblem() = default;
  /// At nu and the reactions' p: R of (1) and u of every reaction; W where it moves with nu. False if something is not finite.
  virtual bool evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) = 0;
  /// At the guess evaluated last: K = d(R - sum W p)/dnu and every reaction's G.
  virtual void differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) = 0;
};

}  // namespace perp
