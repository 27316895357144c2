// Bounded nonlinear least squares from values and normal equations.
#pragma once

#include <functional>

#include "perp/core/types.hpp"

namespace perp {

/// min c(x) = sum rho(r_i(x))/2 over low <= x <= high.
struct LeastSquares {
  Vector low, high;  ///< (n)
  Vector scale;      ///< (n) > 0: no step is longer than this in any entry [unit of x]
  std::function<double(const Vector& x)> cost;  ///< may be infinity
  /// H = J^T w J and g = J^T w r with J = dr/dx, w = rho'(r)/r.
  std::function<void(const Vector& x, Matrix& H, Vector& g)> normal_equations;
};

struct LeastSquaresOptions {
  int iterations = 30;  ///< at most
  double tolerance =
      1e-4;  ///< ends where a step is expected to lower the cost by less than this: in units of chi^2/2, far below 1
};

struct LeastSquaresEnd {
  Vector x;
  double cost = infinity;
  int iterations = 0;
  bool converged = false;  ///< no step within the bounds lowers the cost
};

/// Levenberg-Marquardt [NW06, 10.3]: (H + lambda diag H) s = -g over the entries that no bound holds back, lambda by how well the
/// last step's gain was foretold. x is clamped to the bounds first.
[[nodiscard]] LeastSquaresEnd minimize(const LeastSquares& problem, Vector x,
                                       const LeastSquaresOptions& options = {});

}  // namespace perp
