#include "perp/model/joint.hpp"

#include <catch2/catch.hpp>

#include "perp/model/model.hpp"

using namespace perp;
using Catch::Contains;

TEST_CASE("a joint forbids as many motions as its kind says, in space and in the plane", "[joint]") {
  const BodyId a{1}, b{2};
  const auto rows = [](const Joint& joint, bool planar) {
    return joint_geometry(joint, {}, {}, planar).rows.size();
  };
  CHECK(rows(fixed(a, b), false) == 6);
  CHECK(rows(ball(a, b), false) == 3);
  CHECK(rows(revolute(a, b), false) == 5);
  CHECK(rows(prismatic(a, b), false) == 5);
  CHECK(rows(cylindrical(a, b), false) == 4);
  CHECK(rows(universal(a, b), false) == 4);
  CHECK(rows(planar(a, b), false) == 3);
  CHECK(rows(screw(a, b, {.lead = 1}), false) == 5);
  CHECK(rows(rod(a, b, {.point_b = {1, 0, 0}}), false) == 1);
  CHECK(rows(gear(a, b, {.ratio = 2}), false) == 1);
  CHECK(rows(rod(a, b, {.point_b = {1, 0, 0}}), true) == 1);
  CHECK(rows(gear(a, b, {.ratio = 2}), true) == 1);
  CHECK(rows(fixed(a, b), true) == 3);
  CHECK(rows(ball(a, b), true) == 2);
  CHECK(rows(revolute(a, b), true) == 2);
  CHECK(rows(prismatic(a, b, {.axis = {1, 1, 0}}), true) == 2);
}

TEST_CASE("a joint that cannot be is refused by name", "[joint]") {
  const BodyId a{1}, b{2};
  const auto geometry = [](const Joint& joint, bool planar = false) {
    return joint_geometry(joint, {}, {}, planar);
  };
  CHECK_THROWS_WITH(geometry(revolute(a, a, {.name = "hinge"})),
                    Contains("joint 'hinge'") && Contains("two bodies"));
  CHECK_THROWS_WITH(geometry(revolute(a, b, {.axis = {0, 0, 0}})), Contains("axis is 0"));
  CHECK_THROWS_WITH(geometry(revolute(a, b, {.friction = -1})), Contains("friction is -1"));
  CHECK_THROWS_WITH(geometry(ball(a, b, {.friction = 1})), Contains("one degree of freedom"));
  CHECK_THROWS_WITH(geometry(revolute(a, b, {.point = {not_set, 0, 0}})), Contains("point"));
  CHECK_THROWS_WITH(geometry(revolute(a, b, {.axis = {1, 0, 0}}), true), Contains("about z"));
  CHECK_THROWS_WITH(geometry(prismatic(a, b), true), Contains("xy plane"));
  CHECK_THROWS_WITH(geometry(cylindrical(a, b, {.friction = 1})), Contains("one degree of freedom"));
  CHECK_THROWS_WITH(geometry(screw(a, b)), Contains("lead"));
  CHECK_THROWS_WITH(geometry(gear(a, b)), Contains("ratio"));
  CHECK_THROWS_WITH(geometry(rod(a, b)), Contains("length"));
  CHECK_THROWS_WITH(geometry(universal(a, b, {.axis = {1, 0, 0}, .axis_b = {1, 1, 0}})),
                    Contains("perpendicular"));
  CHECK_THROWS_WITH(geometry(universal(a, b), true), Contains("spatial"));

  Model model;
  const BodyId particle = model.add_particle(1);
  CHECK_THROWS_WITH(model.add_joint(revolute(ground, particle)), Contains("particle"));
  CHECK_NOTHROW(model.add_joint(ball(ground, particle, {.name = "pin"})));
  CHECK_THROWS_WITH(model.add_joint(ball(ground, particle, {.name = "pin"})), Contains("taken"));
}
