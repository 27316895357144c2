// The flow of fixed modes from a state near that of a run, over the run's own steps.
#pragma once

#include <memory>

#include "step/events/mode_dynamics.hpp"
#include "step/sensitivity/state_tangent.hpp"

namespace perp {

/// Two states to either side of the run's, a half-width away, that go along in its modes: with the same steps, so that what these miss
/// is missed alike.
class FlowPair {
 public:
  struct Side {
    const Model* model = nullptr;
    State x;
    std::unique_ptr<ModeDynamics> dynamics;
  };
  Side plus, minus;
  double eps = 0;

  /// In these modes from x on, and onto their constraints. Empty, or what is wrong.
  std::string begin(const Modes& modes, double small_speed, double speed_error);
  /// One step to t; false where a side cannot be evaluated.
  bool step(double t);
  /// Onto the constraints of the modes.
  bool project();
};

/// The column's direction at the run's state x.
void read(const Model& model, const State& x, const FlowPair& pair, Eigen::Index column, StateTangent& out);

}  // namespace perp
