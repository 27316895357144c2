#include "perp/study/friction_families.hpp"

#include <algorithm>
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
  for (const char* family :
       {"stack", "wall", "kapla", "spheres", "peg", "wedge", "infeasible-peg", "pile", "chute"}) {
    CAPTURE(family);
    for (const int index : {2, 5}) CHECK(friction_family(family, 1, index).blocks() > 100);
  }
}

TEST_CASE("the chain solves all of 60 members, and proves the infeasible ones to be so", "[families]") {
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

TEST_CASE("contacts with moments have their rows, and a problem as many contacts as asked for at most",
          "[families]") {
  int many = 0;
  for (int index = 0; index < 30; ++index) {
    const FrictionProblem twist = friction_family("twist", 9, index),
                          few = friction_family("twist", 9, index, 20);
    CHECK(twist.kind(0) == BlockKind::TorsionalRolling);
    CHECK(twist.rows() == 6 * twist.blocks());
    CHECK(twist.blocks() <= 300);
    CHECK(few.blocks() <= 20);
    many += twist.blocks() > 100;
  }
  CHECK(many >= 5);
  CHECK(friction_family("torsion", 9, 0).kind(0) == BlockKind::Torsional);
  CHECK(friction_family("rolling", 9, 0).kind(0) == BlockKind::Rolling);
}

TEST_CASE(
    "a packing has nearly as many contacts as asked for, its spheres lie on each other and gravity presses "
    "them",
    "[families]") {
  for (const std::string family : {"pile", "chute"})
    for (int index = 0; index < 4; ++index) {
      const FrictionProblem p = friction_family(family, 11, index, 160);
      CAPTURE(family, index);
      CHECK(p.blocks() <= 160);
      CHECK(p.blocks() > 120);
      const double bodies = static_cast<double>(p.M.rows()) / 6;
      CHECK(static_cast<double>(p.blocks()) > 2 * bodies);
      const FrictionSolution s = solve_friction(p, {.tolerance = 1e-8, .time_limit = 3, .use_ipopt = false});
      double carried = 0;  // of the contacts, how many press
      for (Eigen::Index c = 0; c < p.blocks(); ++c) carried += s.r[3 * c] > 0 ? 1 : 0;
      CHECK(carried > bodies);
    }
  CHECK(friction_family("kapla", 1, 0, 570).blocks() == 15 * 36);
}

TEST_CASE("moments of a family's contacts act about n, t and o", "[families]") {
  const FrictionProblem p = friction_family("twist", 9, 0);
  const Matrix H = p.H.to_dense();
  for (Eigen::Index c = 0; c < std::min<Eigen::Index>(p.blocks(), 10); ++c)
    for (Eigen::Index b = 0; b < H.rows() / 6; ++b) {
      const Matrix columns = H.block(6 * b, 6 * c, 6, 6);
      if (columns.isZero()) continue;
      CHECK(columns.topRightCorner(3, 3).isZero());  // moments push nothing
      for (int k = 0; k < 3; ++k) CHECK(columns.block(3, 3 + k, 3, 1).isApprox(columns.block(0, k, 3, 1)));
    }
}

TEST_CASE("an unknown family is refused with the known ones", "[families]") {
  CHECK_THROWS_WITH(friction_family("pyramid", 1, 0), Catch::Contains("pyramid") && Catch::Contains("kapla"));
}
