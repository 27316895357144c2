// Models to either side of a parameter's value, which differences along tangents need.
#pragma once

#include "step/sensitivity/step_tangent.hpp"

namespace perp {

/// One column of derivatives: a parameter, or a direction of the start.
class ParametersAlong {
 public:
  /// Columns: the parameters, then `start_columns` of the start alone. `model` has to outlive this.
  ParametersAlong(const ParametricModel& model, const Vector& theta, const Vector& scale, const Model& here,
                  Eigen::Index start_columns);

  /// d(start)/dtheta, and of the start's own columns unit directions: those of xi, then those of nu.
  [[nodiscard]] StateTangent start(const State& x) const;

  /// The columns' models, made again nearer where the tangent has grown so much that x moves far over a half-width.
  const std::vector<ParameterSides>& at(const State& x, const StateTangent& tangent);

 private:
  struct Pair {
    ModelAtStart plus, minus;
  };
  void make(Eigen::Index j, double eps);

  const ParametricModel& model_;
  const Vector& theta_;
  const Model& here_;
  Vector scale_;
  Eigen::Index start_columns_;
  std::vector<Pair> pairs_;
  std::vector<ParameterSides> sides_;
};

}  // namespace perp
