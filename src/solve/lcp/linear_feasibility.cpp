#include "perp/solve/linear_feasibility.hpp"

#include "perp/solve/lemke.hpp"

namespace perp {

FeasibilityAnswer find_feasible(const Matrix& A, const Vector& b, const Vector& c) {
  const auto m = A.rows(), n = A.cols();
  Lcp skew{Matrix::Zero(n + m, n + m), Vector(n + m)};
  skew.A.topRightCorner(n, m) = -A.transpose();
  skew.A.bottomLeftCorner(m, n) = A;
  skew.b << c, b;

  LcpSolution solution;
  LemkeSolver({.restarts = 2}).solve(skew.A, skew.b, solution);
  FeasibilityAnswer answer{.pivots = solution.pivots};
  if (solution.solved()) {
    answer.status = Feasibility::Feasible;
    answer.z = solution.z.head(n);
  }
  if (solution.status == LcpStatus::NoSolution) {
    answer.status = Feasibility::Infeasible;
    answer.y = solution.certificate.tail(m);
  }
  return answer;
}

}  // namespace perp
