// CP1 with the modes of velocity known: accelerations and forces as a friction problem of their own.
#pragma once

#include <string>
#include <vector>

#include "perp/instant/reduced_system.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/step/cp1.hpp"
#include "step/events/acceleration_biases.hpp"
#include "step/modes/modes.hpp"

namespace perp {

/// Forces and accelerations of all closed contacts.
struct AccelerationAnswer {
  Cp1Status status = Cp1Status::None;
  bool complete = false;                              ///< all modes were looked through
  Vector nu_dot;                                      ///< (nv)
  std::vector<Vector3> force;                         ///< of each closed contact, along n, t, o [N]
  std::vector<Vector3> acceleration;                  ///< relative, along n, t, o [m/s^2]
  std::vector<Vector3> moment, angular_acceleration;  ///< about n, t, o [N m, rad/s^2]; zero without moments
  std::vector<double> small;  ///< of each closed contact: what rounding leaves of an acceleration [m/s^2]
  Vector joint_force;         ///< of each joint friction [N, N m]
  Vector joint_acceleration;  ///< of each joint friction [m/s^2, rad/s^2]
  Vector
      joint_small;  ///< below it the acceleration of a joint friction is zero but for rounding and compliance
  Vector reactions;           ///< of each joint row
  double residual = not_set;  ///< of the friction problem or the LCP, relative [-]
};

constexpr double slight_give = 1e-7;  ///< compliance that picks forces where rows repeat each other [-]

/// u' = W c + q over the rows that are free to choose: n of every closed contact, t and o of those that stick, the frictions of
/// joints that stick. Sliding friction is eliminated: (17) makes it -mu c_n u_f/|u_f|, a part of the column of c_n, and (18)
/// a known force. W is then unsymmetric and need not be a P-matrix: Painlevé.
class AccelerationProblem {
 public:
  void assemble(const Model& model, const State& x, const Instant& instant, const Modes& modes);

  [[nodiscard]] AccelerationAnswer solve(const Model& model, const Cp1Options& options) const;

  /// One of them, if there are several; without looking whether there are.
  [[nodiscard]] AccelerationAnswer any_solution(const Model& model) const;

  /// The answer for forces c along the rows.
  [[nodiscard]] AccelerationAnswer read(const Model& model, const Vector& c) const;

  /// Forces that redundant rows leave open are those of the one rule (VanishingCompliance), exactly; off: any.
  bool even = false;
  /// Beside W's own, that of each row: among forces that redundant rows leave open, a small one picks those next to the rule's [-].
  double compliance = 0;

  /// All modes are looked through where they are this many at most [-]; more, to 4096, only if the solver finds no answer.
  double most_choices = all_choices;
  static constexpr double all_choices = 4096;

  FrictionProblem problem;         ///< local form
  double acceleration_scale = 0;   ///< of q, before joints and contacts act [m/s^2]
  std::vector<int> contact_index;  ///< of each closed contact in Instant::contacts

 private:
  [[nodiscard]] std::vector<Vector> enumerate(bool& one_limit) const;
  [[nodiscard]] FrictionSolution solve_friction() const;
  double choices() const;  // of modes; infinite with circular cones

  Instant accelerations_;  // the instant with biases of accelerations in place of explicit velocities
  AccelerationBiases biases_;
  Island island_;
  ReducedSystem reduced_;
  Modes modes_;
  Vector free_;  // M^-1 k
  Matrix
      columns_;  // (rows of reduced_, rows of problem): what a force along a row of problem is along those of reduced_
  Vector known_;  // (rows of reduced_): forces of joints that slide
  Matrix C_;      // compliances of the rows of problem
  Vector k_;      // their constant part
  Vector give_;   // (rows of reduced_): what a force gives along its own row, by `compliance`
};

}  // namespace perp
