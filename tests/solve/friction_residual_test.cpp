#include "perp/solve/friction_residual.hpp"

#include <catch2/catch.hpp>
#include <Eigen/Dense>

#include "friction_examples.hpp"

using namespace perp;

TEST_CASE("the residual is that of the definition, worked out again", "[friction]") {
  const auto seed = GENERATE(range(0u, 50u));
  const FrictionProblem problem = random_friction_problem(seed);
  Draw draw(seed + 1000);
  const Vector r = draw.matrix(problem.q.size(), 1);
  const FrictionResidual residual = friction_residual(problem, r);
  const SecondOpinion opinion = second_opinion(problem, r);
  CHECK(residual.relative == Approx(opinion.relative).epsilon(1e-12));
  CHECK(residual.absolute == Approx(opinion.absolute).epsilon(1e-12));
}

TEST_CASE("the residual without units does not see units of mass and length", "[friction]") {
  const FrictionProblem problem = random_friction_problem(3);
  Draw draw(4);
  const Vector r = draw.matrix(problem.q.size(), 1);
  FrictionProblem other = problem;
  const double mass = 1e-3, length = 1e3;
  other.W = Matrix(problem.W.to_dense() / mass);
  other.q = problem.q * length;
  const FrictionResidual a = friction_residual(problem, r), b = friction_residual(other, r * mass * length);
  CHECK(a.absolute == Approx(b.absolute).epsilon(1e-12));
  CHECK(a.relative == Approx(b.relative).epsilon(1e-12));
}

TEST_CASE("the residual tells what rounding may hide in it when reactions are huge", "[friction]") {
  FrictionProblem problem;  // two contacts squeeze one freedom: u does not change along r = (a, a)
  Matrix H = Matrix::Zero(1, 6);
  H(0, 0) = 1;
  H(0, 3) = -1;
  problem.W = Matrix(H.transpose() * H);
  problem.q = Vector::Constant(6, 0.1);
  problem.mu = Vector::Constant(2, 0.5);
  Vector r = Vector::Zero(6);
  r(0) = r(3) = 1;
  const FrictionResidual small = friction_residual(problem, r), huge = friction_residual(problem, 1e15 * r);
  CHECK(small.round_off > 1e-17);
  CHECK(small.round_off < 1e-13);
  CHECK(huge.round_off == Approx(1e15 * small.round_off));
}

TEST_CASE("the residuals in units say by how much each law is missed", "[friction]") {
  FrictionProblem problem;
  problem.W = Matrix3::Identity();
  problem.q = Vector3(-3, 1, 0);
  problem.mu = Vector::Constant(1, 0.5);
  CHECK(friction_residual(problem, Vector3(1, 0, 0)).penetration == Approx(2));
  CHECK(friction_residual(problem, Vector3(5, 0, 0)).lift == Approx(2));
  CHECK(friction_residual(problem, Vector3(2, 1.5, 0)).cone == Approx(0.5));
  CHECK(friction_residual(problem, Vector3(3, -0.5, 0)).sliding == Approx(0.5 - 0.25 / 1.5));
}

TEST_CASE("a projection is the nearest point of the set", "[friction]") {
  const auto seed = GENERATE(range(0u, 30u));
  Draw draw(seed);
  const double mu = draw.uniform(0, 3);
  const Vector z = draw.matrix(3, 1);
  const Vector p = project_reaction(BlockKind::Cone, mu, z);
  CHECK(p.tail(2).norm() <= mu * p(0) + 1e-14);
  for (int k = 0; k < 200; ++k) {  // no other point of the cone is nearer
    Vector other = draw.matrix(3, 1);
    other(0) = std::abs(other(0));
    if (other.tail(2).norm() > mu * other(0)) other.tail(2) *= mu * other(0) / other.tail(2).norm();
    CHECK((z - p).norm() <= (z - other).norm() + 1e-14);
  }
}
