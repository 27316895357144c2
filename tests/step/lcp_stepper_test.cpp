#include "perp/step/lcp_stepper.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;
using Catch::Contains;

namespace {

/// A planar arm of two links with joint friction, hinged to a wall, each of which comes to stand on a frictional contact.
struct StandingArm {
  Model model;
  State x;
  StandingArm() {
    model.set_gravity({0, -9.81, 0});
    const BodyId upper = model.add_planar_body(1, 0.1, {.pose = {{0.5, 0, 0}, Quaternion::Identity()}});
    const BodyId lower = model.add_planar_body(1, 0.1, {.pose = {{1.5, 0, 0}, Quaternion::Identity()}});
    model.add_joint(revolute(ground, upper, {.friction = 0.3, .name = "shoulder"}));
    model.add_joint(revolute(upper, lower, {.point = {1, 0, 0}, .friction = 0.2, .name = "elbow"}));
    model.add_contact(ground, upper, disc_on_line(0.1, {Vector3::UnitY(), {0, -0.1, 0}}), {.mu = 0.5});
    model.add_contact(ground, lower, disc_on_line(0.1, {Vector3::UnitY(), {0, -0.1, 0}}), {.mu = 0.4});
    x = model.rest();
    model.set_velocity(x, upper, {0, 0.5, 0}, {0, 0, 1});
    model.set_velocity(x, lower, {0, 0.5, 0}, {0, 0, -1});
  }
};

Vector final_velocity(const Model& model, LcpStepperOptions options, const State& x, double t_end, double h) {
  LcpStepper stepper(options);
  return simulate(model, stepper, x, {.t_end = t_end, .h = h}).back().nu;
}

}  // namespace

TEST_CASE("mixed and condensed forms give the same velocities on an arm that stands on two contacts",
          "[lcp_stepper]") {
  const StandingArm arm;
  LcpStepper condensed, mixed({.form = LcpForm::Mixed});
  State x = arm.x, y = arm.x;
  int closed = 0;
  for (int k = 0; k < 300; ++k) {
    const StepReport a = condensed.step(arm.model, x, 0.002);
    const StepReport b = mixed.step(arm.model, y, 0.002);
    REQUIRE(a.advanced());
    REQUIRE(b.advanced());
    // (39) holds for both, whatever impulses they chose
    for (const StepReport& r : {a, b}) {
      CHECK(r.residuals.newton_euler < 1e-13);
      CHECK(r.residuals.joints < 1e-13);
      CHECK(r.residuals.normal < 1e-12);
      CHECK(r.residuals.friction < 1e-12);
      for (const ContactRow& row : r.contacts) closed += row.mode != ContactMode::Open;
    }
    CAPTURE(k, x.nu.transpose() - y.nu.transpose());
    REQUIRE((x.nu - y.nu).cwiseAbs().maxCoeff() < 1e-12 * std::max(1.0, x.nu.norm()));
    y = x;  // compares steps, not how rounding grows
  }
  CHECK(closed > 300);  // it does stand
}

TEST_CASE("a contact left out is found afterwards, so that leaving it out changes nothing", "[lcp_stepper]") {
  // ball 1 would not reach the wall in this step, were it not hit by ball 0
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId a = model.add_body(Inertia::solid_sphere(1, 0.5), {.pose = {{0, 0, 0}, {1, 0, 0, 0}}});
  const BodyId b = model.add_body(Inertia::solid_sphere(0.01, 0.5), {.pose = {{1.0, 0, 0}, {1, 0, 0, 0}}});
  model.add_contact(a, b, sphere_on_sphere(0.5, 0.5), {.name = "hit"});
  model.add_contact(ground, b, sphere_on_plane(0.5, {-Vector3::UnitX(), {1.505, 0, 0}}), {.name = "wall"});
  State x = model.rest();
  model.set_velocity(x, a, {1, 0, 0});
  LcpStepper stepper;
  const StepReport report = stepper.step(model, x, 0.01);
  REQUIRE(report.advanced());
  CHECK(report.contact("wall").p_n > 0);
  CHECK(report.gap_min > -1e-15);
  CHECK(model.velocity(x, b).x() == Approx(0.5));
}

TEST_CASE("a sphere bounces with e and keeps the place that e = 0 gives", "[lcp_stepper][restitution]") {
  const auto thrown = [](double mu, double e) {
    Model model;
    const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.1));
    model.set_gravity(Vector3::Zero());
    model.add_contact(ground, ball, sphere_on_plane(0.1), {.mu = mu, .e = e, .name = "floor"});
    State x = model.rest();
    model.set_position(x, ball, {0, 0, 0.1});
    model.set_velocity(x, ball, {2, 0, -3});
    LcpStepper stepper;
    const StepReport report = stepper.step(model, x, 1e-3);
    REQUIRE(report.advanced());
    CHECK(model.position(x, ball).z() == Approx(0.1));
    CHECK(report.contact("floor").p_n == Approx(3 * (1 + e)));
    return std::array{model.velocity(x, ball).x(), model.velocity(x, ball).z(),
                      model.angular_velocity(x, ball).y()};
  };
  const auto slides = thrown(0.05, 0.8);
  CHECK(slides[0] == Approx(1.73));
  CHECK(slides[1] == Approx(2.4));
  CHECK(slides[2] == Approx(6.75));
  const auto grips = thrown(0.5, 0.8);
  CHECK(grips[0] == Approx(10.0 / 7));
  CHECK(grips[2] == Approx(100.0 / 7));
  CHECK(thrown(0.5, 0)[1] == Approx(0).margin(1e-15));
}

TEST_CASE("joint friction holds up to c_max and slows by it", "[lcp_stepper][joint]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId wheel = model.add_body(Inertia::principal(1, {1, 2, 2.5}));
  model.add_joint(revolute(ground, wheel, {.axis = {0, 1, 0}, .friction = 0.5}));
  model.add_force(wheel, [](const Model&, const State& x) {
    return Wrench{{}, {0, x.t < 1 ? 0.49 : 0.6, 0}};
  });
  LcpStepper stepper;
  const State x = model.rest();
  const Trajectory holds = simulate(model, stepper, x, {.t_end = 1, .h = 0.1});
  CHECK(model.angular_velocity(holds.back(), wheel).norm() < 1e-15);
  CHECK(holds.report(3).joints.at(0).friction == Approx(-0.049));
  const Trajectory turns = simulate(model, stepper, holds.back(), {.t_end = 2, .h = 0.1});
  CHECK(model.angular_velocity(turns.back(), wheel).y() == Approx((0.6 - 0.5) / 2));
  CHECK(turns.figures(5).energy_friction < 0);
}

TEST_CASE("friction on a belt drags the load to the belt's speed", "[lcp_stepper]") {
  Model model;
  const BodyId belt = model.add_prescribed(PrescribedMotion::belt({1.5, 0, 0}));
  const BodyId load = model.add_particle(2);
  model.add_contact(belt, load, particle_on_plane(), {.mu = 0.3, .name = "belt"});
  LcpStepper stepper;
  const Trajectory run = simulate(model, stepper, model.rest(), {.t_end = 1, .h = 0.01});
  CHECK(model.velocity(run.state(10), load).x() == Approx(0.3 * 9.81 * 0.1));
  CHECK(model.velocity(run.back(), load).x() == Approx(1.5));
  CHECK(run.report(99).contact("belt").mode == ContactMode::Stick);
}

TEST_CASE("lcp-ap leaves an overlap where it is, lcp pushes it out, a cap slows that", "[lcp_stepper]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1));
  model.add_contact(ground, ball, sphere_on_plane(1), {.name = "floor"});
  State sunk = model.rest();
  model.set_position(sunk, ball, {0, 0, 0.9});
  const auto after = [&](LcpStepperOptions options, double cap) {
    LcpStepper stepper(options);
    State x = sunk;
    StepReport report;
    stepper.step(model, x, {.h = 0.001, .max_correction_speed = cap}, report);
    REQUIRE(report.advanced());
    return model.velocity(x, ball).z();
  };
  CHECK(after({.anitescu_potra = true}, infinity) == Approx(0).margin(1e-15));
  CHECK(after({}, infinity) == Approx(100));
  CHECK(after({}, 0.5) == Approx(0.5));
}

TEST_CASE("energy lost to friction and to impact adds up to what the motion lost", "[lcp_stepper]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.1));
  model.set_gravity(Vector3::Zero());
  model.add_contact(ground, ball, sphere_on_plane(0.1), {.mu = 0.1, .e = 0.3});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 0.1});
  model.set_velocity(x, ball, {2, 1, -3}, {3, 4, 5});
  const double before = model.energy(x);
  LcpStepper stepper;
  const StepReport report = stepper.step(model, x, 1e-3);
  CHECK(report.energy_friction < 0);
  CHECK(report.energy_impact == Approx(-0.5 * 9 * (1 - 0.09)));
  CHECK(before + report.energy_friction + report.energy_impact == Approx(report.energy));
  CHECK(report.energy == Approx(model.energy(x)));
}

TEST_CASE("a step takes only an h that is positive and a state that fits", "[lcp_stepper]") {
  Model model;
  model.add_body(Inertia::solid_sphere(1, 1));
  LcpStepper stepper;
  State x = model.rest();
  CHECK_THROWS_WITH(stepper.step(model, x, 0), Contains("h is 0"));
  CHECK_THROWS_WITH(stepper.step(model, x, -1), Contains("h is -1"));
  CHECK_THROWS_WITH(stepper.step(model, x, not_set), Contains("h is nan"));
  x.nu[4] = infinity;
  CHECK_THROWS_WITH(stepper.step(model, x, 0.1), Contains("x.nu is inf"));
  CHECK_THROWS_WITH(LcpStepper({.edges = 2}), Contains("edges is 2"));
  CHECK_THROWS_WITH(LcpStepper({.tolerance = 0}), Contains("tolerance is 0"));
}

TEST_CASE("joints that contradict each other fail the step and leave the state alone", "[lcp_stepper]") {
  Model model;
  const BodyId shaker = model.add_prescribed(PrescribedMotion::belt({}));
  const BodyId mover = model.add_prescribed({.pose =
                                                 [](double t) {
                                                   return Pose{{t, 0, 0}, Quaternion::Identity()};
                                                 },
                                             .twist =
                                                 [](double) {
                                                   return Twist{{1, 0, 0}, {}};
                                                 },
                                             .surface = {},
                                             .acceleration = {}});
  const BodyId bead = model.add_particle(1);
  model.add_joint(ball(shaker, bead));
  model.add_joint(ball(mover, bead));
  LcpStepper stepper;
  State x = model.rest();
  const Vector q = x.q;
  const StepReport report = stepper.step(model, x, 0.1);
  CHECK_FALSE(report.advanced());
  CHECK(report.message.find("'joint 1' by") != std::string::npos);
  CHECK(report.message.find("'joint 2' by") != std::string::npos);
  CHECK(x.t == 0);
  CHECK(x.q == q);
}

TEST_CASE("a contact is looked up by name, and one out of reach has no impulse", "[report]") {
  Model model;
  const BodyId box = model.add_body(Inertia::solid_box(1, {1, 1, 1}), {.pose = {{0, 0, 0.5}, {1, 0, 0, 0}}});
  model.add_contact(ground, box, box_on_plane({1, 1, 1}), {.mu = 0.5, .name = "feet"});
  LcpStepper stepper;
  State x = model.rest();
  const StepReport report = stepper.step(model, x, 0.01);
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += report.contact("feet." + std::to_string(i)).p_n;
  CHECK(sum == Approx(9.81 * 0.01));
  CHECK(report.contact("feet.7").p_n == 0);
  CHECK(std::isnan(report.contact("feet.7").gap));
  CHECK(report.contacts.size() == 4);
  CHECK_THROWS_WITH(report.contact("hands"), Contains("hands") && Contains("feet.0, feet.1"));
}

TEST_CASE("a stack of boxes with every mass ratio stands still and carries its weight",
          "[lcp_stepper][stack]") {
  const double ratio = GENERATE(1.0, 1000.0);
  Model model;
  BodyId below = ground;
  for (int i = 0; i < 5; ++i) {
    const double mass = i == 4 ? ratio : 1;
    const BodyId box =
        model.add_body(Inertia::solid_box(mass, {1, 1, 1}), {.pose = {{0, 0, i + 0.5}, {1, 0, 0, 0}}});
    model.add_contact(below, box, i == 0 ? box_on_plane({1, 1, 1}) : box_on_box({1, 1, 1}, {1, 1, 1}),
                      {.mu = 0.5});
    below = box;
  }
  LcpStepper stepper({.edges = 4});
  const Trajectory run = simulate(model, stepper, model.rest(), {.t_end = 0.5, .h = 0.01});
  CHECK((run.back().q - run.front().q).cwiseAbs().maxCoeff() < 1e-9);
  double bottom = 0;
  const StepReport last = run.report(run.steps() - 1);
  for (const ContactRow& row : last.contacts)
    if (row.contact == 0) bottom += row.p_n / last.h;
  CHECK(bottom == Approx((4 + ratio) * 9.81).epsilon(1e-9));
}

TEST_CASE("velocities do not depend on the number of islands that a system falls into", "[lcp_stepper]") {
  // two spheres far apart as one model, and each as a model of its own
  const auto build = [](int first, int count) {
    Model model;
    for (int i = first; i < first + count; ++i) {
      const BodyId ball =
          model.add_body(Inertia::solid_sphere(1 + i, 0.5), {.pose = {{10.0 * i, 0, 0.5}, {1, 0, 0, 0}}});
      model.add_contact(ground, ball, sphere_on_plane(0.5), {.mu = 0.3});
    }
    State x = model.rest();
    for (int i = 0; i < count; ++i) model.set_velocity(x, {1 + i}, {1.0 + first + i, 0.5, 0});
    return std::pair(model, x);
  };
  const auto [both, x] = build(0, 2);
  const auto [one, y] = build(1, 1);
  CHECK(final_velocity(both, {}, x, 0.2, 0.01).tail(6) == final_velocity(one, {}, y, 0.2, 0.01));
}
