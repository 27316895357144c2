#include "perp/solve/lemke.hpp"

#include <catch2/catch.hpp>

#include "lcp_examples.hpp"

using namespace perp;

namespace {

// The definition itself, on the scale of the data: nothing of the solver's own measures.
void check_definition(const Lcp& lcp, const Vector& z, double tolerance) {
  const Vector w = lcp.A * z + lcp.b;
  CHECK(z.minCoeff() >= 0);
  CHECK(w.minCoeff() >= -tolerance);
  for (Eigen::Index i = 0; i < z.size(); ++i) CHECK(std::min(z[i], w[i]) <= tolerance);
}

Vector falling_and_turning(unsigned seed, int count) {
  std::mt19937 draw(seed);
  Vector nu = random_vector(draw, 6 * count);
  for (int k = 0; k < count; ++k) nu[6 * k + 2] -= 0.5;
  return nu;
}

Vector at_rest_under_gravity(int count, double sideways) {
  Vector nu = Vector::Zero(6 * count);
  for (int k = 0; k < count; ++k) nu[6 * k] = sideways, nu[6 * k + 2] = -0.0981;
  return nu;
}

}  // namespace

TEST_CASE("lemke solves positive definite LCPs to round-off", "[lemke]") {
  const auto seed = GENERATE(range(0u, 10u));
  const auto n = GENERATE(1, 5, 20, 60);
  const Lcp lcp = positive_definite_lcp(seed, n);
  const LcpSolution solution = lemke(lcp);
  CAPTURE(seed, n, solution.pivots);
  REQUIRE(solution.solved());
  CHECK(solution.residual < 1e-13 * lcp.A.norm());
  check_definition(lcp, solution.z, 1e-13 * lcp.A.norm());
}

TEST_CASE("lemke's residual is that of the data at the z it returns", "[lemke]") {
  const Lcp lcp = positive_definite_lcp(3, 20);
  const LcpSolution solution = lemke(lcp);
  double residual = 0;
  for (int i = 0; i < 20; ++i)
    residual = std::max(residual, std::abs(std::min(solution.z[i], lcp.A.row(i).dot(solution.z) + lcp.b[i])));
  CHECK(solution.residual == Approx(residual).margin(1e-16));
  const LcpSolution ray = lemke(bimatrix_game(1, 2));
  CHECK(ray.residual == 1);  // at z = 0: b = -1
}

TEST_CASE("lemke answers b >= 0 with z = 0 and without a pivot", "[lemke]") {
  const LcpSolution solution = lemke({-Matrix::Ones(2, 2), Vector::Zero(2)});
  CHECK(solution.solved());
  CHECK(solution.pivots == 0);
  CHECK(solution.z == Vector::Zero(2));
  CHECK(lemke({Matrix(0, 0), Vector(0)}).solved());
}

TEST_CASE("lemke goes through all 2^n bases of Murty's example and ends where it should", "[lemke]") {
  const auto n = GENERATE(2, 6, 10, 14);
  const Lcp lcp = murty_lcp(n);
  const LcpSolution solution = lemke(lcp, {.max_pivots = 1 << n});
  REQUIRE(solution.solved());
  CHECK(solution.pivots == 1 << n);
  CHECK(solution.z == Vector::Unit(n, 0));
  CHECK(solution.residual == 0);
  const LcpSolution early = lemke(lcp, {.max_pivots = (1 << n) - 1});
  CHECK(early.status == LcpStatus::PivotLimit);
  CHECK(early.pivots == (1 << n) - 1);
}

TEST_CASE("lemke does not cycle where all ratios tie", "[lemke]") {
  SECTION("three rows that all tie, on which principal pivoting by least index cycles") {
    Lcp lcp{Matrix(3, 3), -Vector::Ones(3)};
    lcp.A << 1, 2, 0, 0, 1, 2, 2, 0, 1;
    const LcpSolution solution = lemke(lcp);
    REQUIRE(solution.solved());
    CHECK((solution.z - Vector::Constant(3, 1.0 / 3)).norm() < 1e-15);
  }
  SECTION("Beale's linear program, on which the simplex method cycles [Bea55]") {
    // min -3/4 x1 + 20 x2 - 1/2 x3 + 6 x4: optimum -5/4 at (1, 0, 1, 0).
    Matrix rows(3, 4);
    rows << 0.25, -8, -1, 9, 0.5, -12, -0.5, 3, 0, 0, 1, 0;
    Lcp lcp{Matrix::Zero(7, 7), Vector(7)};
    lcp.A.topRightCorner(4, 3) = rows.transpose();
    lcp.A.bottomLeftCorner(3, 4) = -rows;
    lcp.b << -0.75, 20, -0.5, 6, 0, 0, 1;
    const LcpSolution solution = lemke(lcp);
    REQUIRE(solution.solved());
    CHECK(solution.z.head(4).dot(lcp.b.head(4)) == Approx(-1.25).epsilon(1e-14));
  }
}

TEST_CASE("lemke solves the friction LCP of stacked cubes, moving and at rest", "[lemke]") {
  const auto count = GENERATE(1, 3, 10, 20);
  const auto edges = GENERATE(4, 8);
  const auto seed = GENERATE(range(0u, 4u));
  const Vector nu =
      seed < 2 ? falling_and_turning(seed, count) : at_rest_under_gravity(count, seed == 2 ? 0 : 0.02);
  if (4 * count * (edges + 2) > 600) return;
  const Lcp lcp = cube_stack_lcp(count, edges, 0.2 + 0.2 * seed, nu);
  LcpSolution solution;
  LemkeSolver().solve(lcp.A, lcp.b, solution);
  CAPTURE(count, edges, seed, solution.pivots);
  REQUIRE(solution.solved());
  CHECK(solution.residual < 1e-13);
  check_definition(lcp, solution.z, 1e-13);
}

TEST_CASE("lemke gives the same answer in other units of every row and unknown", "[lemke]") {
  const auto seed = GENERATE(range(0u, 5u));
  const Lcp lcp = positive_definite_lcp(seed, 12);
  const Vector z = lemke(lcp).z;
  std::mt19937 draw(seed);
  const Vector r = (6 * random_vector(draw, 12)).unaryExpr([](double x) { return std::pow(10, x); });
  const Vector c = (6 * random_vector(draw, 12)).unaryExpr([](double x) { return std::pow(10, x); });
  const LcpSolution other = solve_lcp({r.asDiagonal() * lcp.A * c.asDiagonal(), r.cwiseProduct(lcp.b)});
  REQUIRE(other.solved());
  CHECK((c.cwiseProduct(other.z) - z).norm() < 1e-10 * z.norm());
}

TEST_CASE("lemke tells a ray that proves nothing from one that is a certificate", "[lemke]") {
  const LcpSolution nothing = lemke(bimatrix_game(5, 3));
  CHECK(nothing.status == LcpStatus::SecondaryRay);
  CHECK(nothing.pivots == 1);
  CHECK(nothing.certificate.size() == 0);

  // Copositive-plus: x >= 1 and x <= 1/2, as z1 - 1 >= 0, 1/2 - z1 >= 0 with a skew matrix.
  Lcp infeasible{Matrix::Zero(3, 3), Vector(3)};
  infeasible.A << 0, -1, 1, 1, 0, 0, -1, 0, 0;
  infeasible.b << 0, -1, 0.5;
  const LcpSolution none = lemke(infeasible);
  CHECK(none.status == LcpStatus::NoSolution);
  CHECK(proves_no_solution(infeasible.A, infeasible.b, none.certificate));
}

TEST_CASE("lemke takes another covering vector, and refuses one that is not positive", "[lemke]") {
  const Lcp lcp = positive_definite_lcp(1, 10);
  std::mt19937 draw(2);
  const LcpSolution solution = lemke(lcp, {.covering = random_vector(draw, 10).array() + 1.5});
  REQUIRE(solution.solved());
  CHECK((solution.z - lemke(lcp).z).norm() < 1e-12);
  CHECK_THROWS_AS(lemke(lcp, {.covering = Vector::Zero(10)}), std::invalid_argument);
  CHECK_THROWS_AS(lemke(lcp, {.covering = Vector::Ones(9)}), std::invalid_argument);
}

TEST_CASE("lemke refuses shapes that disagree and numbers that are none", "[lemke]") {
  CHECK_THROWS_AS(lemke({Matrix::Identity(3, 2), -Vector::Ones(3)}), std::invalid_argument);
  CHECK_THROWS_AS(lemke({Matrix::Identity(2, 2), -Vector::Ones(3)}), std::invalid_argument);
  CHECK_THROWS_AS(lemke({not_set * Matrix::Identity(2, 2), -Vector::Ones(2)}), std::invalid_argument);
  CHECK_THROWS_AS(solve_lcp({Matrix::Identity(2, 2), not_set * Vector::Ones(2)}), std::invalid_argument);
}

TEST_CASE("a solver that has solved others answers the same bits as a new one", "[lemke]") {
  LemkeSolver used;
  LcpSolution solution, fresh;
  for (const unsigned seed : {1u, 2u, 3u})
    for (const int n : {20, 5, 12}) {
      const Lcp lcp = positive_definite_lcp(seed, n);
      used.solve(lcp.A, lcp.b, solution);
      LemkeSolver().solve(lcp.A, lcp.b, fresh);
      CHECK(solution.z == fresh.z);
      CHECK(solution.pivots == fresh.pivots);
    }
}
