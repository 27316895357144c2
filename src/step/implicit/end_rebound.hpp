// Impacts within a step of ncp, and restitution: at velocity level, at the end of the step.
#pragma once

#include "perp/step/ncp_stepper.hpp"
#include "step/impacts/impact_in_step.hpp"
#include "step/implicit/implicit_step.hpp"

namespace perp {

/// A step as its first solve left it.
struct MovedStep {
  const Model& model;
  const Instant& start;
  const Instant& end;
  const State& x;        ///< at the start
  const Vector& gained;  ///< by the loads: h M^-1 k
  double h = 0;
  double speed = 0;  ///< that misses are measured by [m/s]
};

/// For the bodies that impacts reach, over the contacts that closed,
///   M (nu+ - nu) = h k + sum W p,   0 <= p_n ⟂ u_n+ + (restitution) >= 0,   the other laws as in the step,
/// with M, k and W at its end. The others keep the velocities that they have.
class EndRebound {
 public:
  /// Which bodies impacts change, by the step's reactions.
  void find(const MovedStep& step, const std::vector<Reaction>& all);
  const StruckBodies& struck() const { return struck_; }

  /// nu and the reactions of what was struck, by the first law of `rebounds` that adds no energy. False: it has no answer.
  bool solve(const MovedStep& step, Directions directions, const NonsmoothNewton::Options& how,
             NonsmoothNewton& newton, Vector& nu, std::vector<Reaction>& all, int& iterations);
  const StepResiduals& residuals() const { return outcome_.residuals; }

 private:
  struct Restitution {
    double e = 0, u_n_before = 0;
  };

  void pose(const MovedStep& step, Directions directions, const std::vector<Reaction>& all);
  void set_momentum(const MovedStep& step, const Vector& nu);

  StruckBodies struck_;
  std::vector<Reaction> closed_;     // what the impact finds
  std::vector<std::size_t> source_;  // of each, in the step's reactions
  std::vector<RelativeVelocity> velocities_, rebounding_;
  std::vector<Restitution> restitution_;  // of each
  Vector before_, load_, momentum_;
  EnergyBefore energy_;
  NewtonOutcome outcome_;
};

}  // namespace perp
