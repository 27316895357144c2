// Loads that are not finite are named by what and whom.
#include <catch2/catch.hpp>

#include "perp/instant/instant.hpp"
#include "perp/model/gaps.hpp"

namespace perp {
namespace {

std::string fault_of(const Model& model) {
  Instant instant;
  evaluate(model, model.rest(), instant);
  return instant.fault;
}

TEST_CASE("a load that is not finite is named by its number, its body and its value", "[instant]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.5), {.name = "ball"});
  const BodyId arm = model.add_body(Inertia::solid_sphere(1, 0.5), {.name = "arm"});
  const JointId hinge = model.add_joint(revolute(ground, arm, {.axis = {0, 1, 0}, .name = "hinge"}));
  const auto force = [&](BodyId body, const Vector3& f, const Vector3& m) {
    model.add_force(body, [=](const Model&, const State&) { return Wrench{f, m}; });
  };
  force(ball, {1, 0, 0}, {0, 0, 0});
  force(arm, {0, 2, 0}, {0, 0, 1});
  CHECK(fault_of(model).empty());
  Model moment = model;
  moment.add_force(ball, [](const Model&, const State&) {
    return Wrench{Vector3::Zero(), {0, 0, infinity}};
  });
  CHECK(fault_of(moment) == "force 2 on body 'ball', its moment (0, 0, inf) N m, is not finite at t = 0");
  Model motor = model;
  motor.add_motor(
      {.joint = hinge, .effort = [](const Model&, const State&, double, double) { return not_set; }});
  CHECK(fault_of(motor) == "the motor of joint 'hinge', nan, is not finite at t = 0");
  force(arm, {0, not_set, 0}, {0, 0, 0});
  CHECK(fault_of(model) == "force 2 on body 'arm', (0, nan, 0) N, is not finite at t = 0");
}

}  // namespace
}  // namespace perp
