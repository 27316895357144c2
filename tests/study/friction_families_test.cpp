#include "perp/study/friction_families.hpp"

#include <catch2/catch.hpp>
#include <Eigen/Dense>

#include "perp/solve/friction_solver.hpp"

using namespace perp;

TEST_CASE("a family's member is the same every time and other members differ", "[families]") {
  const FrictionProblem a = friction_family("stack", 7, 3), b = friction_family("stack", 7, 3);
  CHECK(a.f == b.f);
  CHECK(Matrix(a.H.to_dense()) == Matrix(b.H.to_dense()));
  CHECK_FALSE(friction_family("box4", 7, 3).f == friction_family("box4", 7, 4).f);
  CHECK_FALSE(friction_family("box4", 7, 3).f == friction_family("box4", 8, 3).f);
}

TEST_CASE("a third of a family's members have more than a hundred contacts where it can", "[families]") {
  for (const char* family : {"stack", "wall", "kapla", "spheres", "peg", "wedge", "infeasible-peg"}) {
    CAPTURE(family);
    for (const int index : {2, 5}) CHECK(friction_family(family, 1, index).blocks() > 100);
  }
}

TEST_CASE("the chain solves all of 45 members, and proves the infeasible ones to be so", "[families]") {
  for (const std::string& family : friction_families())
    for (int index = 0; index < 5; ++index) {
      const FrictionProblem problem = friction_family(family, 2024, index);
      const FrictionSolution s = solve_friction(problem, {.use_ipopt = false});
      CAPTURE(family, index, problem.blocks(), s.residual, s.residuals.absolute);
      CHECK((s.status == FrictionStatus::NoSolution) == (family == "infeasible-peg"));
      if (family == "infeasible-peg") continue;
      CHECK(s.solved());
      CHECK(friction_residual(to_local(problem), s.r).relative < 1e-9);  // as the local form sees it
    }
}

TEST_CASE("rods of which some lean on the next are solved group by group", "[families]") {
  const FrictionProblem problem = friction_family("painleve", 515151, 59);
  CHECK_FALSE(solve_friction(problem, {.method = FrictionMethod::InteriorPoint}).solved());
  CHECK_FALSE(solve_friction(problem, {.method = FrictionMethod::Proximal}).solved());
  const FrictionSolution s = solve_friction(problem, {.use_ipopt = false});
  REQUIRE(s.solved());
  CHECK(s.iterations < 20000);
}

TEST_CASE("Newton's method alone solves nearly all of 40 towers and wedges in 60 iterations", "[families]") {
  const FrictionOptions options{.method = FrictionMethod::Newton, .max_iterations = 60};
  int solved = 0;
  for (const char* family : {"kapla", "wedge"})
    for (int i = 0; i < 20; ++i) solved += solve_friction(friction_family(family, 3, i), options).solved();
  CHECK(solved >= 38);
}

TEST_CASE("an unknown family is refused with the known ones", "[families]") {
  CHECK_THROWS_WITH(friction_family("pyramid", 1, 0), Catch::Contains("pyramid") && Catch::Contains("kapla"));
}
