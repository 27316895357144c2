// Forces and works over a step of fixed modes, by a rule of its own: what a row of the event-driven method is checked against.
#pragma once

#include <array>
#include <vector>

#include "step/events/row_sums.hpp"

namespace perp {

/// Between two states a and b of a stretch: the equations of the modes once more, by collocation at Lobatto's five points (order 8),
///   y_j = y_a + h sum_k S_jk f(y_k, t_k),   y = (q, nu),
/// from an interpolant of both ends, again and again until what comes out at b stands. Nothing of it comes from the integrator, but
/// the two states: how far b is from y_b is the certificate of the step.
class RowQuadrature {
 public:
  static constexpr int points = 5;

  /// Powers at a state [W]: of friction, loads, motors, and moving bodies and surfaces.
  struct Power {
    double friction = 0, load = 0, motor = 0, surface = 0;
  };
  struct Node {
    State x;
    Vector q_dot, nu_dot;
    std::vector<double> normal;   ///< force of each closed contact along n,
    std::vector<Vector3> force;   ///< and all of it, world axes
    std::vector<Vector3> moment;  ///< of each, world axes; empty where no contact has moments
    Vector joint_reaction, joint_friction;
    Power power;
    std::vector<Matrix> M;  ///< of generalized bodies
  };

  /// False where the equations cannot be evaluated between a and b. `tolerance` is relative: the rounds end when a round changes
  /// what comes out at b by less of the largest velocity, and coordinate. Leaves `dynamics` at b, its count of evaluations as it was.
  bool integrate(ModeDynamics& dynamics, const State& a, const State& b, double tolerance);

  double momentum_residual = not_set;   ///< max |M (nu_b - y_b)| [N s, N m s]
  double kinematic_residual = not_set;  ///< max |q_b - y_b| [m, rad]

  /// Of a row that was integrated.
  RowSums sums(const Model& model) const;

 private:
  /// h sum of weights times `of` a node.
  template <class Of>
  auto sum(Of of) const {
    auto total = of(nodes_[0]);
    total *= h_ * weight[0];
    for (std::size_t j = 1; j < points; ++j) total += h_ * weight[j] * of(nodes_[j]);
    return total;
  }
  /// The same of generalized bodies' work beside their potential.
  double generalized_work(const Model& model) const;

  static const std::array<double, points> place, weight;
  static const std::array<std::array<double, points>, points> integral, slope;

  static bool read(ModeDynamics& dynamics, Node& node);
  void judge(const ModeDynamics& dynamics, const State& b, const State& found);

  std::array<Node, points> nodes_;
  double h_ = 0;
};

}  // namespace perp
