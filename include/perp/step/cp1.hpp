// CP1, the instantaneous model: accelerations and forces at one state, as a complementarity problem.
#pragma once

#include <string_view>
#include <vector>

#include "perp/step/stepper.hpp"

namespace perp {

/// How many accelerations the model allows.
enum class Cp1Status {
  Unique,   ///< one; or, if not Cp1Solution::complete, one was found and others were not looked for
  Several,  ///< more than one, of which that with the least forces was taken
  None,     ///< none that is finite: Painlevé's paradox. What happens then is an impact without collision
};

[[nodiscard]] std::string_view name_of(Cp1Status status);  ///< "unique", "several", "none"

struct Cp1Options {
  int edges =
      0;  ///< 0: circular cones, by solve_friction; else a friction polygon of so many edges (>= 3), by Lemke's method
  bool relaxed = false;  ///< friction of sliding contacts need not dissipate the most [PT96]: see solve_cp1
};

/// A closed contact: psi_n = 0 and u_n = 0, to 1e-10 of the largest length and 1e-9 of the largest speed of the system.
struct Cp1Contact {
  int contact = 0;                         ///< in Model::contacts()
  int point = 0;                           ///< among all points of the model
  bool sliding = false;                    ///< u_f != 0 at this instant, or it spins against torsion
  bool rolls = false;                      ///< against rolling friction, now or from here on
  ContactMode mode = ContactMode::Open;    ///< from here on: it opens, sticks or slips
  double c_n = 0;                          ///< normal force >= 0 [N]
  Vector3 force = Vector3::Zero();         ///< on b, world axes [N]
  Vector3 moment = Vector3::Zero();        ///< of torsion and rolling on b, world axes [N m]
  Vector3 acceleration = Vector3::Zero();  ///< of b relative to a along n, t, o [m/s^2]
};

struct Cp1Joint {
  int joint = 0;        ///< in Model::joints()
  int coordinate = 0;   ///< of its coordinates
  double friction = 0;  ///< along its freedom [N, N m]
  bool slips = false;   ///< moves, or begins to
};

struct Cp1Solution {
  Cp1Status status = Cp1Status::None;
  bool complete = false;             ///< whether `status` is proved: every choice of modes was looked through
  Vector acceleration;               ///< nu' (nv) [m/s^2, rad/s^2]; empty if there is none
  std::vector<Cp1Contact> contacts;  ///< the closed ones, in the model's order
  std::vector<Cp1Joint> joints;      ///< those with friction, in the model's order
  Vector reactions;                  ///< of each joint row [N, N m]
  double residual = not_set;         ///< of the complementarity problem, relative [-]
};

/// CP1, Definition 3 of the seed with errata 8-15: find nu' and forces with
///   M nu' = k + W_n c_n + W_f c_f + W_b c_b + W_bf c_bf                                   (24)
///   W_b^T nu' + b_b = 0                                                                   (19)
///   0 <= c_n ⟂ W_n^T nu' + b_n >= 0          at closed contacts; c_n = 0 at others        (20), (21)
///   c_f = -mu c_n u_f/|u_f|                  where u_f != 0                               (17)
///   c_f of largest dissipation against a_f = W_f^T nu' + b_f,  |c_f| <= mu c_n,  else     (22)
/// and the same with the interval |c_bf| <= c_max in joints (18), (23). b are the terms of second order: turning normals, W'^T nu,
/// rheonomic terms, moving surfaces (erratum 30).
///
/// Sliding friction is eliminated, and the rest goes to solve_friction (the circular cone) or as an LCP to Lemke's method.
/// With at most 4096 choices of modes and no contact of two tangents at rest all choices are looked through besides, so that
/// the status is proved.
///
/// `relaxed`: friction only has to dissipate. Then a solution always exists without joints [PT96]; of the many, where Coulomb's
/// law leaves none, that without friction at sliding contacts is taken.
///
/// Throws std::invalid_argument for x that does not fit the model, and for edges of 1 or 2.
[[nodiscard]] Cp1Solution solve_cp1(const Model& model, const State& x, const Cp1Options& options = {});

}  // namespace perp
