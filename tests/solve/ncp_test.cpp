#include "perp/solve/ncp.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <Eigen/Dense>

#include "perp/solve/friction_solver.hpp"

using namespace perp;

namespace {

/// The Jacobian by central differences: the definitions below are polynomials and quotients of them.
NcpJacobian differences(const NcpFunction& F) {
  return [F](const Vector& z) {
    Matrix J(z.size(), z.size());
    for (Eigen::Index j = 0; j < z.size(); ++j) {
      const double h = 1e-6 * std::max(1.0, std::abs(z(j)));
      Vector above = z, below = z;
      above(j) += h;
      below(j) -= h;
      J.col(j) = (F(above) - F(below)) / (2 * h);
    }
    return J;
  };
}

/// Kojima and Shindo's, and with other constants Josephy's.
NcpFunction kojima(double a, double b, double c, double d) {
  return [=](const Vector& x) -> Vector {
    const double q = 3 * x(0) * x(0) + 2 * x(0) * x(1) + 2 * x(1) * x(1);
    return Eigen::Vector4d(q + x(2) + 3 * x(3) - 6,
                           2 * x(0) * x(0) + x(0) + x(1) * x(1) + a * x(2) + 2 * x(3) - 2,
                           3 * x(0) * x(0) + x(0) * x(1) + 2 * x(1) * x(1) + 2 * x(2) + b * x(3) - c,
                           x(0) * x(0) + 3 * x(1) * x(1) + 2 * x(2) + 3 * x(3) - d);
  };
}

Vector mathiesen(const Vector& x) {
  return Eigen::Vector4d(-x(1) + x(2) + x(3), x(0) - (4.5 * x(2) + 2.7 * x(3)) / (x(1) + 1),
                         5 - x(0) - (0.5 * x(2) + 0.3 * x(3)) / (x(2) + 1), 3 - x(0));
}

void check_solution(const NcpFunction& F, const NcpSolution& s) {
  REQUIRE(s.solved());
  const Vector w = F(s.z);
  CHECK(s.z.minCoeff() >= -1e-10);
  CHECK(w.minCoeff() >= -1e-10);
  CHECK(s.z.cwiseMin(w).cwiseAbs().maxCoeff() <= 1e-10);
}

}  // namespace

TEST_CASE("Kojima and Shindo's problem is solved from its usual starts, at one of its two solutions",
          "[ncp]") {
  const NcpFunction F = kojima(10, 9, 9, 3);
  const double size = GENERATE(0.0, 1.0, 10.0, 100.0);
  const NcpSolution s = solve_ncp(F, differences(F), Vector::Constant(4, size));
  check_solution(F, s);
  const Eigen::Vector4d first(std::sqrt(6.0) / 2, 0, 0, 0.5), second(1, 0, 3, 0);
  CHECK(std::min((s.z - first).norm(), (s.z - second).norm()) < 1e-8);
}

TEST_CASE("Josephy's problem is solved at its solution", "[ncp]") {
  const NcpFunction F = kojima(3, 3, 1, 3);
  const double size = GENERATE(0.0, 1.0, 10.0);
  const NcpSolution s = solve_ncp(F, differences(F), Vector::Constant(4, size));
  check_solution(F, s);
}

TEST_CASE("Mathiesen's economy is solved at a point of its ray of solutions", "[ncp]") {
  const double size = GENERATE(0.0, 1.0, 3.0);
  const NcpSolution s = solve_ncp(mathiesen, differences(mathiesen), Vector::Constant(4, size));
  check_solution(mathiesen, s);
}

TEST_CASE("Billups's trap at zero is left by a restart", "[ncp]") {
  const NcpFunction F = [](const Vector& z) -> Vector {
    return Vector::Constant(1, (z(0) - 1) * (z(0) - 1) - 1.01);
  };
  const NcpSolution s = solve_ncp(F, differences(F), Vector::Zero(1));
  check_solution(F, s);
  CHECK(s.stage == "restart");
  CHECK(s.z(0) == Approx(1 + std::sqrt(1.01)).epsilon(1e-10));
}

TEST_CASE("Billups's trap is left by Ipopt alone where there are no restarts", "[ncp]") {
  const NcpFunction F = [](const Vector& z) -> Vector {
    return Vector::Constant(1, (z(0) - 1) * (z(0) - 1) - 1.01);
  };
  CHECK_FALSE(solve_ncp(F, differences(F), Vector::Zero(1), {.restarts = 0, .use_ipopt = false}).solved());
  if (!has_ipopt()) return;
  const NcpSolution s = solve_ncp(F, differences(F), Vector::Zero(1), {.restarts = 0});
  check_solution(F, s);
  CHECK(s.stage == "ipopt");
}

TEST_CASE("Ipopt alone solves the classic problems from where Newton is not let run", "[ncp]") {
  if (!has_ipopt()) return;
  const NcpFunction F =
      GENERATE(NcpFunction(kojima(10, 9, 9, 3)), NcpFunction(kojima(3, 3, 1, 3)), NcpFunction(mathiesen));
  const NcpOptions limited{.max_iterations = 1, .restarts = 0};
  const NcpSolution s = solve_ncp(F, differences(F), Vector::Constant(4, 10), limited);
  check_solution(F, s);
  CHECK(s.stage == "ipopt");
}

TEST_CASE("a problem without a solution ends with the best point found, told as such", "[ncp]") {
  const NcpFunction F = [](const Vector& z) -> Vector { return Vector::Constant(1, -1 - z(0) * z(0)); };
  const NcpSolution s = solve_ncp(F, differences(F), Vector::Zero(1));
  CHECK_FALSE(s.solved());
  CHECK(s.residual >= 1);
}

TEST_CASE("functions of the wrong size are refused by name", "[ncp]") {
  const NcpFunction F = [](const Vector&) -> Vector { return Vector::Zero(2); };
  const NcpJacobian J = [](const Vector&) -> Matrix { return Matrix::Identity(3, 3); };
  CHECK_THROWS_WITH(static_cast<void>(solve_ncp(F, J, Vector::Zero(3))), Catch::Contains("F(z0)"));
}
