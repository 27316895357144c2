// Back onto psi_b = 0 after a step that moved along its tangent.
#pragma once

#include <functional>
#include <string>

#include "perp/instant/reduced_system.hpp"

namespace perp {

/// The joints with a row that `open` [m, rad] puts above `tolerance` of it, the worst first: "'left' by 0.1 m, 'hinge' by 0.2 rad";
/// empty if there are none.
std::string joints_open(const Model& model, const Instant& s,
                        const std::function<double(const JointRowInstant&)>& open,
                        const std::function<double(const JointRowInstant&)>& tolerance);

/// Moves x to where its joints disagree least at the time x.t (JointProjection::contradictory) and names those that can then not be closed
/// by any small motion of the bodies, the worst first, as joints_open does. Empty if all can be closed.
std::string contradicting_joints(const Model& model, State& x);

/// Why the joints may keep a step from x to t_end from being solved: that they contradict each other near x at t_end, or that the velocities
/// of x open them; "; joints that ..." with their names and by how much. Empty if they do not.
std::string joints_at_odds(const Model& model, const State& x, double t_end, double h);

/// Newton's method for psi_b(q ⊕ d) = 0 at the time x.t, each step d the shortest in the norm of M at q:
///   M d = W_b lambda,   W_b^T d = -psi_b,
/// until |psi_b| is at rounding or falls no further. Contacts do not take part. Keeps its workspace.
class JointProjection {
 public:
  /// `s` holds the system at x, and does so after. Gives the largest change of a coordinate [m, rad]; x stays where it was,
  /// and 0 is given, if the error would not fall.
  double move_onto(const Model& model, State& x, Instant& s);

  /// To where the joints disagree least, by Gauss and Newton's method for sum psi_b²/N_ii, N = W_bᵀ M^-1 W_b. True if they can
  /// then not be closed: what is left is above rounding, and no small motion of the bodies makes less of it.
  bool contradictory(const Model& model, State& x, Instant& s);

 private:
  void shortest_move(const Model& model, const Instant& s);

  Islands islands_;
  Island rows_;
  std::vector<ReducedSystem> reduced_;  // one an island
  Vector bias_, impulse_, reactions_, still_, d_, nothing_, q_start_, q_best_;
};

}  // namespace perp
