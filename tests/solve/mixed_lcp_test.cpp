#include "perp/solve/mixed_lcp.hpp"

#include <catch2/catch.hpp>

#include "lcp_examples.hpp"

using namespace perp;

namespace {

// Random D, C and B, with a and b such that (u, v) drawn here is a solution: v or w is zero in each pair.
MixedLcp with_known_solution(unsigned seed, const Matrix& A, int m) {
  const int n = static_cast<int>(A.rows());
  std::mt19937 draw(seed);
  MixedLcp p;
  p.A = A;
  p.C = random_matrix(draw, n, m);
  p.D = -p.C.transpose();
  const Matrix G = random_matrix(draw, m, m);
  p.B = G * G.transpose() + 0.1 * Matrix::Identity(m, m);
  const Vector u = random_vector(draw, n), s = random_vector(draw, m);
  const Vector v = s.cwiseMax(0.0), w = (-s).cwiseMax(0.0);
  p.a = -(p.A * u + p.C * v);
  p.b = w - (p.D * u + p.B * v);
  return p;
}

Matrix of_rank(unsigned seed, int n, int rank) {
  std::mt19937 draw(seed + 100);
  const Matrix G = random_matrix(draw, n, rank);
  return G * G.transpose();
}

void check_solved(const MixedLcp& p, const MixedLcpSolution& solution, double tolerance) {
  REQUIRE(solution.solved());
  CHECK((p.A * solution.u + p.C * solution.v + p.a).lpNorm<Eigen::Infinity>() < tolerance);
  const Vector w = p.D * solution.u + p.B * solution.v + p.b;
  CHECK(solution.v.minCoeff() >= 0);
  CHECK(w.minCoeff() > -tolerance);
  CHECK(solution.v.cwiseMin(w).maxCoeff() < tolerance);
  CHECK(solution.residual == mixed_lcp_residual(p, solution.u, solution.v));
}

}  // namespace

TEST_CASE("a mixed LCP with regular equations is solved to round-off", "[mixed-lcp]") {
  const auto seed = GENERATE(range(0u, 10u));
  const auto n = GENERATE(1, 4, 15);
  const MixedLcp p = with_known_solution(seed, of_rank(seed, n, n) + Matrix::Identity(n, n), 8);
  const MixedLcpSolution solution = solve_mixed_lcp(p);
  CHECK(solution.stage == "elimination");
  check_solved(p, solution, 1e-12);
}

TEST_CASE("equations that do not determine u are exchanged with pairs that do", "[mixed-lcp]") {
  const auto seed = GENERATE(range(0u, 10u));
  const auto rank = GENERATE(0, 2, 4);
  const MixedLcp p = with_known_solution(seed, of_rank(seed, 5, rank), 8);
  const MixedLcpSolution solution = solve_mixed_lcp(p);
  CAPTURE(seed, rank, solution.stage, name_of(solution.status));
  CHECK(solution.stage == "exchange");
  check_solved(p, solution, 1e-11);
}

TEST_CASE("an equation said twice is redundant, said with another constant it has no solution",
          "[mixed-lcp]") {
  MixedLcp p = with_known_solution(4, of_rank(4, 4, 4), 6);
  p.A.row(3) = p.A.row(0), p.C.row(3) = p.C.row(0), p.a[3] = p.a[0];
  p.A.col(3).setZero(), p.D.col(3).setZero();
  p.A.row(3) = p.A.row(0);
  const MixedLcpSolution twice = solve_mixed_lcp(p);
  check_solved(p, twice, 1e-11);
  CHECK(twice.u[3] == Approx(0).margin(1e-14));  // nothing depends on it
  p.a[3] += 1e-3;
  CHECK(solve_mixed_lcp(p).status == LcpStatus::NoSolution);
}

TEST_CASE("equations that no pair can take in are solved with u split in two", "[mixed-lcp]") {
  // v1 - 1 = 0 is the equation; u stands in the row of w2 alone: 0 <= v2 ⟂ u + v2 >= 0 and 0 <= v1 ⟂ v1 - 1 >= 0.
  MixedLcp p;
  p.A = Matrix::Zero(1, 1);
  p.C = Eigen::RowVector2d(1, 0);
  p.D = Vector2(0, 1);
  p.B = Matrix::Identity(2, 2);
  p.a = Vector::Constant(1, -1);
  p.b = Vector2(-1, 0);
  const MixedLcpSolution solution = solve_mixed_lcp(p);
  CHECK(solution.stage == "split");
  check_solved(p, solution, 1e-14);
  CHECK(solution.v[0] == Approx(1).epsilon(1e-14));
}

TEST_CASE("a mixed LCP without equations is an LCP, one without pairs a linear system", "[mixed-lcp]") {
  const Lcp lcp = positive_definite_lcp(1, 6);
  const MixedLcp pairs{Matrix(0, 0), Matrix(0, 6), Matrix(6, 0), lcp.A, Vector(0), lcp.b};
  CHECK((solve_mixed_lcp(pairs).v - solve_lcp(lcp).z).norm() < 1e-14);
  const Matrix A = of_rank(1, 4, 4) + Matrix::Identity(4, 4);
  const MixedLcp equations{A, Matrix(4, 0), Matrix(0, 4), Matrix(0, 0), Vector::Ones(4), Vector(0)};
  const MixedLcpSolution solution = solve_mixed_lcp(equations);
  REQUIRE(solution.solved());
  CHECK((A * solution.u + Vector::Ones(4)).norm() < 1e-14);
}

TEST_CASE("rows and unknowns of a mixed LCP may have units a million apart", "[mixed-lcp]") {
  const auto seed = GENERATE(range(0u, 5u));
  const MixedLcp p = with_known_solution(seed, of_rank(seed, 3, 2), 5);
  const MixedLcpSolution plain = solve_mixed_lcp(p);
  const Vector r = Vector3(1e6, 1, 1e-6), c = Vector3(1, 1e-6, 1e6);
  const MixedLcp scaled{r.asDiagonal() * p.A * c.asDiagonal(),
                        r.asDiagonal() * p.C,
                        p.D * c.asDiagonal(),
                        p.B,
                        r.cwiseProduct(p.a),
                        p.b};
  const MixedLcpSolution solution = solve_mixed_lcp(scaled);
  REQUIRE(solution.solved());
  CHECK((solution.v - plain.v).norm() < 1e-10);
  CHECK((c.cwiseProduct(solution.u) - plain.u).norm() < 1e-10);
}

TEST_CASE("a mixed LCP whose shapes disagree is refused", "[mixed-lcp]") {
  MixedLcp p = with_known_solution(1, Matrix::Identity(2, 2), 3);
  p.C = Matrix::Zero(3, 2);
  CHECK_THROWS_AS(solve_mixed_lcp(p), std::invalid_argument);
}
