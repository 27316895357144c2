#include "perp/solve/friction_problem.hpp"

#include <catch2/catch.hpp>
#include <Eigen/Dense>

#include "friction_examples.hpp"

using namespace perp;
using Catch::Matchers::Contains;

TEST_CASE("the local form of a global problem gives the velocities that the equations of motion give",
          "[friction]") {
  const FrictionProblem global = cube_on_plane({1, 2, -10}, 0.5, 2);
  const FrictionProblem local = to_local(global);
  Draw draw(3);
  const Vector r = draw.matrix(12, 1);
  const Vector v = global.M.to_dense().inverse() * (global.H.to_dense() * r + global.f);
  const Vector u = global.H.to_dense().transpose() * v + global.w;
  CHECK((local.W.times(r) + local.q - u).norm() < 1e-13 * u.norm());
}

TEST_CASE("the local form of a problem with bilateral rows keeps them", "[friction]") {
  FrictionProblem global = cube_on_plane({1, 2, -10}, 0.5, 2);
  Matrix G = Matrix::Zero(6, 1);
  G(0, 0) = 1;  // v_x = 0.25
  global.G = G;
  global.b = Vector::Constant(1, -0.25);
  const FrictionProblem local = to_local(global);
  Draw draw(4);
  const Vector u = local.W.times(draw.matrix(12, 1)) + local.q;
  Eigen::Index row = 1;  // mean of the corners' velocities along x is v_x for a cube symmetric in y
  double mean = 0;
  for (; row < 12; row += 3) mean += u(row) / 4;
  const double w_y = (u(0) - u(3)) / 1.0;  // u_z differs along x by -w_y
  CHECK(mean - w_y * -0.5 == Approx(0.25).epsilon(1e-12));
}

TEST_CASE("a matrix given dense or sparse is the same problem", "[friction]") {
  FrictionProblem dense = random_friction_problem(12), sparse = dense;
  sparse.W = dense.W.to_sparse();
  const FrictionSolution a = solve_friction(dense), b = solve_friction(sparse);
  CHECK(a.r == b.r);
}

TEST_CASE("data that cannot be a contact problem are refused by name", "[friction]") {
  FrictionProblem problem = random_friction_problem(5);
  SECTION("a coefficient below zero") {
    problem.mu(0) = -0.1;
    CHECK_THROWS_WITH(check(problem), Contains("mu(0)") && Contains("-0.1"));
  }
  SECTION("a velocity that is not a number") {
    problem.q(1) = not_set;
    CHECK_THROWS_WITH(check(problem), Contains("q(1)"));
  }
  SECTION("a matrix of another size") {
    problem.W = Matrix::Identity(2, 2);
    CHECK_THROWS_WITH(check(problem), Contains("W shape") && Contains("2 x 2"));
  }
  SECTION("a singular mass matrix") {
    FrictionProblem global = cube_on_plane({0, 0, -1}, 0.5);
    global.M = Matrix::Zero(6, 6);
    CHECK_THROWS_WITH(to_local(global), Contains("M") && Contains("singular"));
  }
}
