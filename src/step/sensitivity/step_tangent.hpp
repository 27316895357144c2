// The derivative of one implicit step.
#pragma once

#include <array>

#include "step/run/step_record.hpp"
#include "step/sensitivity/state_tangent.hpp"
#include "step/sensitivity/step_side.hpp"

namespace perp {

/// A direction of the parameters: the models a half-width to either side, both the model itself of directions of the start alone.
struct ParameterSides {
  const Model* plus = nullptr;
  const Model* minus = nullptr;
  double eps = 0;  ///< 0: of the start alone; any half-width does
};

/// Carries tangents through the steps of a run, one after the other.
class StepTangent {
 public:
  explicit StepTangent(const Model& model) : model_(model) {}

  /// From the step that a method reports with `answer`, from `before` to `after`. What is wrong with the derivative is added to `missing`; false
  /// where it cannot go on.
  bool step(const State& before, const State& after, const StepFigures& figures, const StepAnswer& answer,
            double max_correction_speed, std::span<const ParameterSides> sides, StateTangent& tangent,
            std::vector<NoDerivative>& missing);

 private:
  bool take_modes(const State& before, const State& after, std::vector<NoDerivative>& missing);
  bool take_second_modes(const State& after, std::vector<NoDerivative>& missing);
  void take_reactions(const std::vector<Acting>& from, std::vector<Reaction>& to) const;
  double speed_of(const std::vector<Reaction>& all) const;
  bool factor(std::vector<NoDerivative>& missing, const Reaction* reactions);
  std::string column(const State& before, const State& after, const ParameterSides& sides, Eigen::Index j,
                     const StateTangent& old, StateTangent& tangent);
  std::string name_of(const Reaction& r) const;
  void miss(const Reaction* r, const std::string& what, std::vector<NoDerivative>& missing) const;

  const Model& model_;
  StartInstant start_;
  StepModes modes_;
  StepSide here_;
  /// A column's two neighbours, which go along from step to step as long as their models and half-width stay.
  struct Pair {
    std::array<StepSide, 2> sides;
    std::array<State, 2> x;  // at the end of the last step
    std::array<const Model*, 2> models{};
    double eps = 0;
    int steps = 0;  // taken since they were set to either side
  };
  bool set_out(const State& before, const ParameterSides& sides, const StateTangent& old, Eigen::Index j,
               Pair& pair);
  std::vector<Pair> pairs_;
  HeldSystem first_, second_;
  std::vector<Coupling> K_;
  double t_ = 0, speed_ = 0;
};

}  // namespace perp
