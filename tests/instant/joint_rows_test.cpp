// Every kind of joint: how its equations and coordinates change, what its reactions do, how its angles count turns.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "perp/instant/instant.hpp"
#include "tests/instant/random_systems.hpp"

using namespace perp;
using namespace perp::testing;

TEST_CASE("every joint's equations and coordinates change at the rate W^T nu plus their explicit part",
          "[joint]") {
  Random random(1);
  const Model model = with_all_joints(random);
  for (int k = 0; k < 1000; ++k) {
    const State x = disturbed(model, random, 0.2);
    const double h = 1e-6;
    Instant s, before, after;
    evaluate(model, x, s);
    evaluate(model, moved(model, x, -h), before);
    evaluate(model, moved(model, x, h), after);
    REQUIRE(s.fault.empty());
    const auto check = [&](const auto& now, const auto& earlier, const auto& later) {
      for (std::size_t i = 0; i < now.size(); ++i) {
        const double difference = (later[i].psi_b - earlier[i].psi_b) / (2 * h);
        CAPTURE(k, i, model.joint({now[i].joint}).name);
        REQUIRE(now[i].velocity(x.nu) == Approx(difference).epsilon(1e-6).margin(1e-6));
      }
    };
    check(s.joint_rows, before.joint_rows, after.joint_rows);
    check(s.joint_coordinates, before.joint_coordinates, after.joint_coordinates);
    for (std::size_t i = 0; i < model.joints().size(); ++i)
      for (std::size_t j = 0; j < model.joints()[i].coordinates.size(); ++j) {
        const JointRowInstant& c = s.joint_coordinates[static_cast<std::size_t>(s.first_coordinate[i]) + j];
        const JointId id{static_cast<int>(i)};
        REQUIRE(model.coordinate(x, id, static_cast<int>(j)) == c.psi_b);
        REQUIRE(model.coordinate_rate(x, id, static_cast<int>(j)) == Approx(c.velocity(x.nu)).margin(1e-12));
      }
  }
}

TEST_CASE("a joint's reactions do no work on motions that it leaves, and balance between its bodies",
          "[joint]") {
  Random random(2);
  const Model model = with_all_joints(random);
  const State x = disturbed(model, random, 0.2);
  Instant s;
  evaluate(model, x, s);
  for (const JointRowInstant& row : s.joint_rows) {
    const JointGeometry& joint = model.joint({row.joint});
    CAPTURE(joint.name);
    // power on the two bodies is p psi', so none where psi stays: from the force and moment that reports speak of
    const auto power = [&](BodyId body, const Vector3& moment) {
      const Twist V = model.twist(x, body);
      return row.world.linear.dot(V.at(row.point - model.position(x, body))) + moment.dot(V.w);
    };
    const double sum = power(joint.b, row.world.angular_b) - power(joint.a, row.world.angular_a);
    CHECK(sum == Approx(row.velocity(x.nu)).margin(1e-12));
    if (joint.kind != JointKind::Gear) CHECK(row.world.angular_a == row.world.angular_b);
  }
}

TEST_CASE("joints hold where they were defined, and there their coordinates are zero", "[joint]") {
  Random random(3);
  const Model model = with_all_joints(random);
  Instant s;
  evaluate(model, model.rest(), s);
  CHECK(s.joint_error() < 1e-14);
  for (const JointRowInstant& c : s.joint_coordinates) CHECK(std::abs(c.psi_b) < 1e-14);
}

TEST_CASE("an angle between spatial bodies goes on past pi as a state is moved", "[joint]") {
  Model model;
  const BodyId wheel = model.add_body(Inertia::solid_sphere(1, 1));
  const JointId hinge = model.add_joint(revolute(ground, wheel));
  const JointId gears = model.add_joint(gear(ground, wheel, {.ratio = 1}));
  State x = model.rest();
  model.set_velocity(x, wheel, {0, 0, 0}, {0, 0, 1});
  for (int i = 1; i <= 20; ++i) {
    move(model, x.nu, 1, x.q);
    model.follow_turns(x);
    CHECK(model.coordinate(x, hinge) == Approx(i));
    Instant s;
    evaluate(model, x, s);
    CHECK(s.joint_rows.back().psi_b == Approx(i));  // the ground does not turn
  }
  CHECK(model.joint(gears).rows[0].winding == 1);
  x.winding.resize(0);  // a state without memory stands within half a turn
  CHECK(model.coordinate(x, hinge) == Approx(20 - 6 * std::numbers::pi));
}

TEST_CASE("a screw's slide counts its turns, and a planar body's angle its own", "[joint]") {
  Model model;
  const BodyId nut = model.add_body(Inertia::solid_sphere(1, 1));
  const BodyId wheel = model.add_planar_body(1, 1, {.pose = {{1, 0, 0}, rotation({0, 0, 0.5})}});
  const JointId thread = model.add_joint(screw(ground, nut, {.lead = 0.1}));
  const JointId hinge = model.add_joint(revolute(wheel, ground, {.point = {1, 0, 0}}));
  State x = model.rest();
  model.set_position(x, nut, {0, 0, 2.3});
  model.set_orientation(x, nut, rotation({0, 0, 23 - 8 * std::numbers::pi}));
  x.q[model.body(wheel).q0 + 2] += 100;
  Instant s;
  evaluate(model, x, s);
  CHECK(s.joint_error() < 1e-14);
  CHECK(model.coordinate(x, hinge) == Approx(-100));  // of the ground relative to the wheel
  CHECK(model.joint(thread).rows.size() == 5);
}

TEST_CASE("stops are contacts along the coordinate, named after the joint", "[joint]") {
  Model model;
  const BodyId arm = model.add_body(Inertia::solid_sphere(1, 1));
  const JointId hinge = model.add_joint(cylindrical(ground, arm, {.axis = {0, 0, 2}, .name = "elbow"}));
  model.add_limit(hinge, {.lower = -1, .upper = 2, .e = 0.3});
  model.add_limit(hinge, {.upper = 0.5, .coordinate = 1});
  State x = model.rest();
  model.set_position(x, arm, {0, 0, 0.1});
  model.set_orientation(x, arm, rotation({0, 0, 0.4}));
  model.set_velocity(x, arm, {0, 0, 3}, {0, 0, 5});
  Instant s;
  evaluate(model, x, s);
  REQUIRE(model.point_names()->size() == 3);
  const char* names[] = {"elbow.angle.lower", "elbow.angle.upper", "elbow.slide.upper"};
  for (std::size_t i = 0; i < 3; ++i) CHECK((*model.point_names())[i] == names[i]);
  REQUIRE(s.contacts.size() == 3);
  const double gaps[] = {1.4, 1.6, 0.4}, rates[] = {5, -5, -3};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(s.contacts[i].psi_n == Approx(gaps[i]));
    CHECK(s.contacts[i].velocity(x.nu).x() == Approx(rates[i]));
    CHECK(s.contacts[i].tangents == 0);
  }
  CHECK(s.contacts[0].e == 0.3);
  CHECK(s.contacts[1].frame.col(0).isApprox(-Vector3::UnitZ()));
}

TEST_CASE("joint springs pull along minus the gradient of the energy, and dampers against the rate",
          "[joint]") {
  Random random(4);
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId a = model.add_body(random.inertia()), b = model.add_body(random.inertia());
  const JointId hinge =
      model.add_joint(cylindrical(a, b, {.point = random.vector(), .axis = random.vector()}));
  model.add_joint_spring({.joint = hinge, .stiffness = 3, .rest = 0.2});
  model.add_joint_spring({.joint = hinge, .stiffness = 5, .rest = -0.1, .coordinate = 1});
  State x = disturbed(model, random, 0.5);
  x.nu.setZero();
  Instant s;
  evaluate(model, x, s);
  for (int i = 0; i < model.nv(); ++i) {
    State plus = x, minus = x;
    move(model, Vector::Unit(model.nv(), i), 1e-6, plus.q);
    move(model, Vector::Unit(model.nv(), i), -1e-6, minus.q);
    CHECK(s.k[i] == Approx(-(model.energy(plus) - model.energy(minus)) / 2e-6).margin(1e-7));
  }
  const Vector k = s.k;
  model.add_joint_spring({.joint = hinge, .damping = 2});
  x.nu = Vector::NullaryExpr(model.nv(), [&] { return random.number(); });
  State still = x;
  still.nu.setZero();
  Instant moving, at_rest;
  evaluate(model, x, moving);
  evaluate(model, still, at_rest);
  const double rate = model.coordinate_rate(x, hinge);
  Vector gyroscopic = Vector::Zero(model.nv());
  for (const BodyId id : {a, b}) {
    const Vector3 w = x.nu.segment<3>(model.body(id).v0 + 3);
    gyroscopic.segment<3>(model.body(id).v0 + 3) = w.cross(model.body(id).J * w);
  }
  CHECK((moving.k - at_rest.k + gyroscopic).dot(x.nu) == Approx(-2 * rate * rate));
}

TEST_CASE("a motor acts along its coordinate, and a prescribed motion is one equation more", "[joint]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId arm = model.add_planar_body(1, 1);
  const JointId slide = model.add_joint(prismatic(ground, arm, {.axis = {0, 1, 0}}));
  model.add_motor({.joint = slide, .effort = [](const Model&, const State& x, double c, double rate) {
                     return 100 * x.t + 10 * c + rate;
                   }});
  State x = model.rest();
  x.t = 2;
  model.set_position(x, arm, {0, 3, 0});
  model.set_velocity(x, arm, {0, 4, 0});
  Instant s;
  evaluate(model, x, s);
  CHECK(s.k.isApprox(Vector3(0, 234, 0)));
  const std::size_t before = s.joint_rows.size();
  model.add_motion(slide, {.position = [](double t) { return t * t; },
                           .rate = [](double t) { return 2 * t; },
                           .acceleration = [](double) { return 2.0; }});
  evaluate(model, x, s);
  REQUIRE(s.joint_rows.size() == before + 1);
  CHECK(s.joint_rows.back().psi_b == Approx(3 - 4));
  CHECK(s.joint_rows.back().velocity(x.nu) == Approx(0).margin(1e-15));
  CHECK_THROWS_WITH(model.add_motion(slide, *model.joint(slide).motions[0]),
                    Catch::Contains("moved already"));
}
