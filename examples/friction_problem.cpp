// A contact problem alone: K ∋ r ⟂ u + mu |u_T| n ∈ K*, u = W r + q, of one contact, solved by hand where it slides.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  perp::FrictionProblem problem;
  problem.W = perp::Matrix(perp::Matrix::Identity(3, 3));  // 1/kg
  problem.q = perp::Vector(perp::Vector3(-1, 2, 0));       // m/s: it closes at 1, slides at 2
  problem.mu = perp::Vector(perp::Vector::Constant(1, 0.5));
  const perp::FrictionSolution s = perp::solve_friction(problem, {.tolerance = 1e-12});
  // r_N = 1 takes the approach away; friction mu r_N against the sliding leaves 2 - 0.5
  std::printf("r = (%.3f, %.3f, %.3f) N s, u = (%.3f, %.3f, %.3f) m/s, residual %.0e\n", s.r[0], s.r[1],
              s.r[2], s.u[0], s.u[1], s.u[2], s.residual);
  const bool fine =
      (s.r - perp::Vector(perp::Vector3(1, -0.5, 0))).norm() < 1e-11 && std::abs(s.u[1] - 1.5) < 1e-11;
  return fine && s.status == perp::FrictionStatus::Solved ? 0 : 1;
}
