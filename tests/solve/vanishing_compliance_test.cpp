// The limit of rows that give a little: closed forms, and the same equations with what they give.
#include "solve/friction/vanishing_compliance.hpp"

#include <catch2/catch.hpp>

using namespace perp;
using Outcome = VanishingCompliance::Outcome;

namespace {

/// m rows of rank r, symmetric, from numbers that are always the same.
Matrix rows_of_rank(int m, int r, unsigned seed) {
  std::srand(seed);
  const Matrix G = Matrix::Random(r, m);
  return G.transpose() * G;
}

}  // namespace

TEST_CASE("a load on rows that repeat each other is shared as they vanish, by their compliances",
          "[redundant]") {
  // p_1 + p_2 + p_3 = 6 on one row three times: p_i in the ratios 1/c_i
  const Matrix A = Matrix::Ones(3, 3);
  const Vector b = Vector::Constant(3, -6), c = Vector3(1, 2, 2);
  VanishingCompliance limit;
  Vector y;
  REQUIRE(limit.solve(A, b, c.asDiagonal(), Vector::Zero(3), Vector::Ones(3), y) == Outcome::Found);
  CHECK((y - Vector3(3, 1.5, 1.5)).norm() < 1e-14);
  // with a constant part k: p_1 + k_1 = 2 p_2 = 2 p_3
  REQUIRE(limit.solve(A, b, c.asDiagonal(), Vector3(2, 0, 0), Vector::Ones(3), y) == Outcome::Found);
  CHECK((y - Vector3(2, 2, 2)).norm() < 1e-14);
  // in other units the same
  REQUIRE(limit.solve(1e12 * A, 1e6 * b, c.asDiagonal(), Vector::Zero(3), Vector::Constant(3, 1e6), y) ==
          Outcome::Found);
  CHECK((y - 1e-6 * Vector3(3, 1.5, 1.5)).norm() < 1e-20);
}

TEST_CASE("the limit of what vanishes solves the equations, and its null part gives nothing", "[redundant]") {
  const int rank = GENERATE(3, 6);
  constexpr int m = 9;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(rank, seed);
    const Matrix S = rows_of_rank(m, rank, seed);
    // as sliding makes it: the columns are other combinations of the rows than the rows themselves
    const Matrix A = S * (Matrix::Identity(m, m) + 0.3 * Matrix::Random(m, m));
    const Vector b = S * Vector::Random(m), k = Vector::Random(m);
    const Vector c = Vector::Random(m).cwiseAbs() + Vector::Constant(m, 0.2);
    const Matrix C = c.asDiagonal();
    VanishingCompliance limit;
    Vector y;
    REQUIRE(limit.solve(A, b, C, k, S.diagonal().cwiseSqrt(), y) == Outcome::Found);
    CHECK((A * y + b).norm() < 1e-11 * (b.norm() + A.norm() * y.norm()));
    Eigen::FullPivLU<Matrix> lu(A.transpose());
    lu.setThreshold(1e-10);
    const Matrix left = lu.kernel();
    REQUIRE(left.cols() == m - rank);
    CHECK((left.transpose() * (C * y + k)).norm() < 1e-10 * left.norm() * (C * y + k).norm());
    // what gives: y(eps) = y + eps y_1 + O(eps^2)
    constexpr double eps = 1e-4;
    const Vector soft = (A + eps * C).partialPivLu().solve(-b - eps * k);
    const double first = (soft - y - eps * limit.first_order()).norm(), none = (soft - y).norm();
    CHECK(none > 0);
    CHECK(first < 0.05 * none);
  }
}

TEST_CASE("equations without a solution, and limits that there are many of, do not vanish into one",
          "[redundant]") {
  VanishingCompliance limit;
  Vector y;
  const Matrix C = Matrix::Identity(2, 2);
  CHECK(limit.solve(Matrix::Ones(2, 2), Vector2(-1, -2), C, Vector::Zero(2), Vector::Ones(2), y) ==
        Outcome::None);
  Matrix A(2, 2);  // null spaces (1, -1) of A and (1, 1) of its transpose: nothing tells along which C holds
  A << 1, 1, -1, -1;
  CHECK(limit.solve(A, Vector2(-1, 1), C, Vector::Zero(2), Vector::Ones(2), y) == Outcome::Several);
}
