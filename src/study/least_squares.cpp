#include "study/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <vector>

namespace perp {
namespace {

constexpr double lambda_first = 1e-2, lambda_least = 1e-10,
                 lambda_most = 1e8;  // [-]: relative to the diagonal
constexpr double diagonal_least =
    1e-12;  // of the largest scaled diagonal: an entry that nothing depends on stays put

/// The step with damping lambda, shortened to the scale: over the entries that no bound holds back, those that would pass one brought
/// to it and the others solved for again.
Vector damped_step(const LeastSquares& problem, const Vector& x, const Matrix& H, const Vector& g,
                   double lambda) {
  const Eigen::Index n = x.size();
  const Matrix S = problem.scale.asDiagonal(), A = S * H * S;
  const Vector b = -S * g;
  const double largest = A.diagonal().maxCoeff();
  Vector s = Vector::Zero(n);
  if (!(largest > 0)) return s;
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < n; ++i)
    if (!(x[i] <= problem.low[i] && g[i] > 0) && !(x[i] >= problem.high[i] && g[i] < 0)) free.push_back(i);
  for (bool passes = true; passes && !free.empty();) {
    Matrix part = A(free, free);
    for (Eigen::Index k = 0; k < part.rows(); ++k)
      part(k, k) += lambda * std::max(part(k, k), diagonal_least * largest);
    for (const Eigen::Index i : free) s[i] = 0;
    const Vector solved = part.ldlt().solve(Vector((b - A * s)(free)));
    if (!solved.allFinite()) return Vector::Zero(n);
    passes = false;
    std::vector<Eigen::Index> left;
    for (std::size_t k = 0; k < free.size(); ++k) {
      const Eigen::Index i = free[k];
      s[i] = solved[static_cast<Eigen::Index>(k)];
      const double wanted = x[i] + s[i] * problem.scale[i],
                   held = std::clamp(wanted, problem.low[i], problem.high[i]);
      if (held == wanted)
        left.push_back(i);
      else
        s[i] = (held - x[i]) / problem.scale[i], passes = true;
    }
    free = left;
  }
  s *= std::min(1.0, 1 / std::max(s.cwiseAbs().maxCoeff(), 1e-300));
  return (x + S * s).cwiseMax(problem.low).cwiseMin(problem.high) - x;
}

}  // namespace

LeastSquaresEnd minimize(const LeastSquares& problem, Vector x, const LeastSquaresOptions& options) {
  x = x.cwiseMax(problem.low).cwiseMin(problem.high);
  LeastSquaresEnd end{.x = x, .cost = problem.cost(x)};
  double lambda = lambda_first;
  Matrix H;
  Vector g;
  while (end.iterations < options.iterations) {
    problem.normal_equations(end.x, H, g);
    ++end.iterations;
    bool moved = false;
    while (!moved) {
      const Vector step = damped_step(problem, end.x, H, g, lambda);
      const double foretold = -(g.dot(step) + 0.5 * step.dot(H * step));
      if (!(foretold > options.tolerance)) {
        end.converged = true;
        return end;
      }
      const double cost = problem.cost(end.x + step), gain = (end.cost - cost) / foretold;
      if (gain > 1e-3) {
        moved = true;
        end.x += step;
        end.cost = cost;
        if (gain > 0.75) lambda = std::max(lambda_least, lambda / 5);
        if (gain < 0.25) lambda *= 3;
      } else if ((lambda *= 6) > lambda_most) {
        end.converged = true;
        return end;
      }
    }
  }
  return end;
}

}  // namespace perp
