// What a row of a run in fixed modes sums up: impulses and works between two states.
#pragma once

#include <vector>

#include "step/events/mode_dynamics.hpp"

namespace perp {

struct RowSums {
  bool known = false;            ///< false: nothing has been summed
  std::vector<double> normal;    ///< impulse of each closed contact along n [N s]
  std::vector<Vector3> impulse;  ///< and all of it, world axes
  std::vector<Vector3> moment;   ///< of moments, likewise [N m s]; empty where no contact has them
  Vector joint_reaction, joint_friction;
  double friction = 0, load = 0, motor = 0, surface = 0;  ///< works [J]
  double momentum_residual = not_set;   ///< [N s, N m s] by how much the end of the row is off its equations,
  double kinematic_residual = not_set;  ///< and [m, rad]

  RowSums& operator+=(const RowSums& next);  ///< of a row that follows, in the same modes
};

/// The sums' growth over one half-explicit substep, linear in its impulses z along the columns of L: Q z + dt q; and what the kinetic
/// energy of generalized bodies gains as their M changes, nu^T (M+ - M-) nu/2.
class RowRates {
 public:
  /// A column begins where rows() of `dynamics` was last.
  void begin(const ModeDynamics& dynamics);
  /// Where evaluate(), rows() or turn() of `dynamics` was last.
  void assemble(const ModeDynamics& dynamics, const State& x);
  /// The substep around x, after rows() at its end.
  void add(const ModeDynamics& dynamics, const State& x, const Vector& z, double dt, Eigen::Ref<Vector> sums);

  [[nodiscard]] static Eigen::Index size(const ModeDynamics& dynamics);
  /// Of a row from a to b.
  [[nodiscard]] static RowSums unpack(const ModeDynamics& dynamics, const Vector& sums, const State& a,
                                      const State& b);

 private:
  std::vector<Matrix> M_;  // of generalized bodies, at the last end of a substep
  Matrix Q_;
  Vector q_;
};

}  // namespace perp
