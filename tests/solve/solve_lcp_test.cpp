#include <catch2/catch.hpp>

#include "lcp_examples.hpp"
#include "perp/solve/lemke.hpp"

using namespace perp;

namespace {

// Whether some choice of z_i = 0 or w_i = 0 gives a solution: all 2^n of them, by full pivoting.
bool some_basis_solves(const Lcp& lcp) {
  const int n = static_cast<int>(lcp.b.size());
  for (int choice = 0; choice < 1 << n; ++choice) {
    std::vector<int> basis;
    for (int i = 0; i < n; ++i)
      if (choice >> i & 1) basis.push_back(i);
    Vector z = Vector::Zero(n);
    if (!basis.empty()) z(basis) = lcp.A(basis, basis).fullPivHouseholderQr().solve(-lcp.b(basis));
    if (z.minCoeff() > -1e-9 && lcp_residual(lcp.A, lcp.b, z) < 1e-9) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("solve_lcp solves bimatrix games, on which Lemke ends on a ray at once", "[lcp]") {
  const auto n = GENERATE(2, 3, 6, 10);
  const auto seed = GENERATE(range(0u, 4u));
  const Lcp lcp = bimatrix_game(seed, n);
  REQUIRE(lemke(lcp).status == LcpStatus::SecondaryRay);
  const LcpSolution solution = solve_lcp(lcp);
  CAPTURE(n, seed, solution.stage, solution.pivots);
  REQUIRE(solution.solved());
  CHECK(solution.residual < 1e-14);
  CHECK(lcp_residual(lcp.A, lcp.b, solution.z) == solution.residual);
}

TEST_CASE("solve_lcp never misses a solution of a small LCP with whole numbers", "[lcp]") {
  std::mt19937 draw(7);
  std::uniform_int_distribution<int> entry(-2, 2);
  int solved = 0, proved = 0, exhausted = 0;
  for (int k = 0; k < 600; ++k) {
    const int n = 2 + k % 5;
    Lcp lcp{Matrix(n, n), Vector(n)};
    for (double& x : lcp.A.reshaped()) x = entry(draw);
    for (double& x : lcp.b) x = entry(draw);
    const LcpSolution solution = solve_lcp(lcp);
    CAPTURE(k, n, name_of(solution.status), solution.stage);
    if (solution.solved()) {
      ++solved;
      CHECK(lcp_residual(lcp.A, lcp.b, solution.z) < 1e-12);
      continue;
    }
    CHECK_FALSE(some_basis_solves(lcp));
    proved += solution.status == LcpStatus::NoSolution;
    exhausted += solution.status == LcpStatus::Exhausted;
    if (solution.status == LcpStatus::NoSolution)
      CHECK(proves_no_solution(lcp.A, lcp.b, solution.certificate));
    else
      CHECK(solution.certificate.size() == 0);
  }
  CHECK(solved > 150);
  CHECK(proved > 100);
  CHECK(exhausted > 30);
}

TEST_CASE("solve_lcp proves an infeasible LCP to be so, in any units", "[lcp]") {
  const auto unit = GENERATE(1e-6, 1.0, 1e6);
  Lcp lcp{Matrix(3, 3), Vector(3)};
  lcp.A << 0, -1, -unit, 1, 0, 0, -1, 0, 0;  // -z2 - z3 >= 1e-3
  lcp.b << -1e-3, -1, 1;
  const LcpSolution solution = solve_lcp(lcp);
  REQUIRE(solution.status == LcpStatus::NoSolution);
  const Vector& y = solution.certificate;
  REQUIRE(y.size() == 3);
  CHECK(y.minCoeff() >= 0);
  CHECK((lcp.A.transpose() * y).maxCoeff() <= 0);
  CHECK(lcp.b.dot(y) < 0);
}

TEST_CASE("a certificate of two rows weighs them in the units of the data", "[lcp]") {
  const auto unit = GENERATE(1e-6, 1e6);
  Lcp lcp{Matrix(2, 2), Vector(2)};
  lcp.A << 1, -1, -unit, unit;  // z1 - z2 >= 1 and <= 1/2
  lcp.b << -1, unit / 2;
  const LcpSolution solution = solve_lcp(lcp);
  REQUIRE(solution.status == LcpStatus::NoSolution);
  CHECK(proves_no_solution(lcp.A, lcp.b, solution.certificate));
  CHECK(solution.certificate[0] == Approx(unit * solution.certificate[1]));
}

TEST_CASE("a certificate is refused when any of its three inequalities fails", "[lcp]") {
  Lcp lcp{Matrix(2, 2), Vector(2)};
  lcp.A << -1, 0, 0, 1;
  lcp.b << -1, -1;
  CHECK(proves_no_solution(lcp.A, lcp.b, Vector::Unit(2, 0)));
  CHECK_FALSE(proves_no_solution(lcp.A, lcp.b, Vector::Unit(2, 1)));   // Aᵀ y > 0
  CHECK_FALSE(proves_no_solution(lcp.A, lcp.b, Vector2(3, -1)));       // y < 0
  CHECK_FALSE(proves_no_solution(lcp.A, -lcp.b, Vector::Unit(2, 0)));  // bᵀ y > 0
  CHECK_FALSE(proves_no_solution(lcp.A, lcp.b, Vector::Zero(2)));
  CHECK_FALSE(proves_no_solution(lcp.A, lcp.b, Vector()));
}

TEST_CASE("solve_lcp goes on where Lemke's path is longer than its limit", "[lcp]") {
  const Lcp lcp = murty_lcp(12);
  REQUIRE(lemke(lcp).status == LcpStatus::PivotLimit);
  const LcpSolution solution = solve_lcp(lcp);
  REQUIRE(solution.solved());
  CHECK((solution.z - Vector::Unit(12, 0)).norm() < 1e-14);
}

TEST_CASE("the residual is zero at solutions alone and the relative one is free of units", "[lcp]") {
  const Lcp lcp{Matrix::Constant(1, 1, 2), Vector::Constant(1, -3)};
  const auto residual = [&](double z) { return lcp_residual(lcp.A, lcp.b, Vector::Constant(1, z)); };
  CHECK(residual(1.5) == 0);
  CHECK(residual(0) == 3);
  CHECK(residual(2) == 1);
  CHECK(residual(-1) == 5);
  const auto relative = [&](double z, double unit) {
    return lcp_relative_residual(lcp.A / unit, lcp.b, Vector::Constant(1, z * unit));
  };
  CHECK(relative(1, 1) == Approx(0.2));  // 1 of 2 + 3
  CHECK(relative(1, 1e-6) == Approx(0.2));
  CHECK(relative(1.5, 1e6) < 1e-15);
  CHECK(relative(-1, 1) == infinity);
}
