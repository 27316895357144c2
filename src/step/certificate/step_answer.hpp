// What a step found, as its equations have it: values, apart from the method that found them.
#pragma once

#include <vector>

#include "step/implicit/step_problem.hpp"

namespace perp {

/// Where in a step a method takes M, k and W, and what its laws are about. doc/certificate.md writes the equations out.
enum class Scheme {
  Start,            ///< `lcp`, `lcp-ap`, steps across of `event`: all at the start; laws of linearised gaps
  End,              ///< `ncp`: all at the end
  StartDirections,  ///< `ncp-start`: W at the start, the rest at the end
  Halves,           ///< `ncp2`: p_1 with W(q), p_2 with W(q+)
};

/// An impulse of a step along the rows of a contact (n, t, o), a joint's equation or a joint's friction (x); of a contact's moments
/// (n, t, o), which stand behind it, [N m s].
struct Acting {
  Reaction::Of of = Reaction::Of::Contact;
  int source = 0;  ///< contact point of the model, or index among an instant's joint rows or frictions
  Vector3 p = Vector3::Zero();
  double w = not_set;  ///< speed that a unit impulse gives, by which impulses count as speeds [1/kg]
  double gap = 0;      ///< Scheme::Start: what its law has beside u_n [m/s]
  double lever = 1;    ///< of moments: that by which they count as impulses [m]
};

/// What a step found, as its equations have it: values, that may be disturbed and certified again.
struct StepAnswer {
  Scheme scheme = Scheme::Start;
  double h = 0, max_correction_speed = infinity;
  Vector nu_q;     ///< (nv) the velocity that moved q
  Vector q_moved;  ///< (nq) q ⊕ h nu_q, before a projection onto joints
  /// Impulses that go with nu_q, and with nu+. Of steps without impact the same, and `second` is empty; of Halves p_1 and p_2.
  std::vector<Acting> first, second;
  /// Bodies whose velocity an impact within the step finds by itself, from that at the start; empty: no impact.
  std::vector<char> struck;
  /// Bodies whose velocity jumps in the step, these and those that meet without a gap: their works are at (nu + nu+)/2. Empty: none.
  std::vector<char> jumped;
  std::vector<Vector2> polygon;  ///< vertices of the friction polygon; empty: the circular cone
  Vector joint_bias;             ///< Scheme::Start: psi_b/h + dpsi_b/dt of (28), as solved [m/s, rad/s]
  bool joints_closed = false;    ///< Scheme::Start: psi_b(q_moved, t+) = 0 in place of (28)
};

}  // namespace perp
