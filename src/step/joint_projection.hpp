// Back onto psi_b = 0 after a step that moved along its tangent.
#pragma once

#include "perp/instant/reduced_system.hpp"

namespace perp {

/// The rounding of psi_b: that of the largest length in it, or of an angle [m, rad].
double joint_rounding(const Model& model, const Instant& s);

/// Newton's method for psi_b(q ⊕ d) = 0 at the time x.t, each step d the shortest in the norm of M at q:
///   M d = W_b lambda,   W_b^T d = -psi_b,
/// until |psi_b| is at rounding or falls no further. Contacts do not take part. Keeps its workspace.
class JointProjection {
 public:
  /// `s` holds the system at x, and does so after. Gives the largest change of a coordinate [m, rad]; x stays where it was,
  /// and 0 is given, if the error would not fall.
  double move_onto(const Model& model, State& x, Instant& s);

 private:
  Islands islands_;
  Island rows_;
  std::vector<ReducedSystem> reduced_;  // one an island
  Vector bias_, impulse_, reactions_, still_, d_, nothing_, q_start_, q_best_;
};

}  // namespace perp
