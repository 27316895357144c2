// Joints under the LCP step: loops that stay closed, stops, motors, what the report says of them.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "perp/instant/instant.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

using namespace perp;
using Catch::Contains;

namespace {

Trajectory run(const Model& model, Stepper& stepper, const State& x, double t_end, double h) {
  return simulate(model, stepper, x, {.t_end = t_end, .h = h});
}

}  // namespace

TEST_CASE("closed loops with redundant joints stay closed to rounding, past change points too", "[joint]") {
  const char* name = GENERATE("four-bar", "parallelogram", "bennett");
  const Scene s = scene(name);
  LcpStepper closing;
  const Trajectory closed = run(s.model, closing, s.start, 3, 2e-3);
  double worst = 0;
  for (std::size_t i = 0; i < closed.steps(); ++i) {
    worst = std::max(worst, closed.figures(i).joint_error);
    REQUIRE(closed.figures(i).residuals.kinematic < 1e-14);
  }
  CAPTURE(name);
  CHECK(worst < 1e-13);
}

TEST_CASE("the seed's linear joint rows let a loop go by h^2, and pull it back", "[joint]") {
  const Scene s = scene("four-bar");
  LcpStepper seed({.close_joints = false});
  const auto worst = [&](double h) {
    double error = 0;
    const Trajectory open = run(s.model, seed, s.start, 3, h);
    for (std::size_t i = 0; i < open.steps(); ++i) error = std::max(error, open.figures(i).joint_error);
    return error;
  };
  const double coarse = worst(4e-3), fine = worst(2e-3);
  CHECK(fine > 1e-6);
  CHECK(coarse / fine == Approx(4).epsilon(0.2));
}

TEST_CASE("a loop's energy error falls with the order of the step", "[joint]") {
  const Scene s = scene("four-bar");
  LcpStepper stepper;
  const double before = s.model.energy(s.start);
  const auto error = [&](double h) {
    return s.model.energy(run(s.model, stepper, s.start, 2, h).back()) - before;
  };
  const double ratio = error(4e-3) / error(1e-3);
  CHECK(ratio > 3);
  CHECK(ratio < 6);
}

TEST_CASE("a loop hundred seconds long stays closed", "[joint][slow]") {
  const char* name = GENERATE("four-bar", "parallelogram", "bennett");
  const Scene s = scene(name);
  LcpStepper stepper;
  State x = s.start;
  StepReport report;
  for (int i = 0; i < 50000; ++i) {
    stepper.step(s.model, x, {.h = 2e-3}, report);
    REQUIRE(report.advanced());
    REQUIRE(report.joint_error < 1e-10);
  }
}

TEST_CASE("a door on two hinges swings as on one, which share what they carry alike", "[joint]") {
  const auto door = [](bool two) {
    Model model;
    const BodyId leaf =
        model.add_body(Inertia::solid_box(20, {0.8, 0.04, 2}), {.pose = {{0.4, 0, 0}, {1, 0, 0, 0}}});
    const auto hinge = [&](const char* name, double z) {
      model.add_joint(revolute(ground, leaf, {.point = {0, 0, z}, .axis = {0, 0, 1}, .name = name}));
    };
    if (two) hinge("upper", 0.7);
    hinge("lower", two ? -0.7 : 0);
    State x = model.rest();
    model.set_velocity(x, leaf, {0, 0.8, 0}, {0, 0, 2});
    return std::pair(model, x);
  };
  LcpStepper stepper;
  const auto [one, x1] = door(false);
  const auto [both, x2] = door(true);
  const Trajectory single = run(one, stepper, x1, 5, 1e-2), pair = run(both, stepper, x2, 5, 1e-2);
  CHECK((single.back().q - pair.back().q).norm() < 1e-11);
  const StepReport last = pair.report(pair.steps() - 1);
  CHECK(last.joint_error < 1e-13);
  CHECK(last.joint("upper").impulse.z() == Approx(20 * 9.81 * 1e-2 / 2));
  CHECK(last.joint("lower").impulse.z() == Approx(20 * 9.81 * 1e-2 / 2));
  const double weight_arm = 20 * 9.81 * 0.4;  // the couple that keeps the leaf upright comes from both
  const Vector3 r = both.position(pair.back(), {1});
  const Vector3 couple = last.joint("upper").moment + last.joint("lower").moment +
                         Vector3(0, 0, 0.7).cross(last.joint("upper").impulse - last.joint("lower").impulse);
  CHECK((couple - 1e-2 * r.normalized().cross(Vector3(0, 0, weight_arm))).norm() < 0.05 * 1e-2 * weight_arm);
}

TEST_CASE("a stop turns a swinging arm back with its restitution", "[joint]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId arm =
      model.add_body(Inertia::solid_box(1, {1, 0.1, 0.1}), {.pose = {{0.5, 0, 0}, {1, 0, 0, 0}}});
  const JointId hinge = model.add_joint(revolute(ground, arm, {.axis = {0, 0, 1}, .name = "elbow"}));
  model.add_limit(hinge, {.lower = -1, .upper = 10, .e = 0.5});
  State x = model.rest();
  model.set_velocity(x, arm, {0, 1, 0}, {0, 0, 2});
  LcpStepper stepper;
  const Trajectory motion = run(model, stepper, x, 8, 1e-3);
  double furthest = 0;
  for (std::size_t i = 0; i < motion.size(); ++i)
    furthest = std::max(furthest, model.coordinate(motion.state(i), hinge));
  CHECK(furthest == Approx(10).margin(5e-3));  // past a turn and a half
  CHECK(model.coordinate_rate(motion.back(), hinge) == Approx(-1).epsilon(2e-3));
  CHECK(model.coordinate(motion.back(), hinge) == Approx(10 - 3).margin(0.02));
  const StepReport last = motion.report(motion.steps() - 1);
  CHECK(last.joint("elbow").value == Approx(model.coordinate(motion.back(), hinge)));
  CHECK(last.joint("elbow").rate == Approx(model.coordinate_rate(motion.back(), hinge)));
  CHECK(last.contact("elbow.upper").p_n == 0);
  CHECK_THROWS_WITH(last.joint("knee"), Contains("elbow"));
}

TEST_CASE("a stop carries a weight as a moment about the hinge", "[joint]") {
  Model model;
  const BodyId arm = model.add_planar_body(2, 0.1, {.pose = {{0.5, 0, 0}, {1, 0, 0, 0}}});
  model.set_gravity({0, -9.81, 0});
  const JointId hinge = model.add_joint(revolute(ground, arm, {.name = "hinge"}));
  model.add_limit(hinge, {.lower = 0});
  State x = model.rest();
  LcpStepper stepper;
  const StepReport report = stepper.step(model, x, 0.01);
  CHECK(report.contact("hinge.lower").p_n == Approx(2 * 9.81 * 0.5 * 0.01));
  CHECK(report.contact("hinge.lower").impulse.z() == Approx(2 * 9.81 * 0.5 * 0.01));
  CHECK(report.joint("hinge").impulse.y() == Approx(2 * 9.81 * 0.01));
  CHECK(x.q[2] == Approx(0).margin(1e-15));
}

TEST_CASE("a driven joint follows its motion and says what that takes", "[joint]") {
  Model model;
  model.set_gravity({0, -9.81, 0});
  const BodyId arm = model.add_planar_body(2, 0.1, {.pose = {{0.5, 0, 0}, {1, 0, 0, 0}}});
  const JointId hinge = model.add_joint(revolute(ground, arm, {.name = "hinge"}));
  model.add_motion(hinge, {.position = [](double t) { return t * t; },
                           .rate = [](double t) { return 2 * t; },
                           .acceleration = {},
                           .recipe = {}});
  CHECK(model.joint(hinge).motions[0]->acceleration_at(3) == Approx(2).epsilon(1e-10));
  LcpStepper stepper;
  const Trajectory motion = run(model, stepper, model.rest(), 1, 1e-3);
  CHECK(model.coordinate(motion.back(), hinge) == Approx(1).epsilon(1e-12));
  const double moment = motion.report(999).joint("hinge").moment.z() / 1e-3;
  CHECK(moment == Approx(2 * (0.1 + 2 * 0.25) + 2 * 9.81 * 0.5 * std::cos(1)).epsilon(5e-3));
}

TEST_CASE("every method says where a joint is and what it gives", "[joint]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp-start", "ncp2", "event");
  CAPTURE(method);
  Model model;
  const double c = 0.3, mass = 2, h = 1e-3;
  const BodyId arm = model.add_body(Inertia::solid_box(mass, {0.6, 0.1, 0.2}), {.pose = {.p = {0.3, 0, 0}}});
  model.add_joint(fixed(arm, model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {.p = {0.6, 0, 0}}}),
                        {.name = "glue"}));
  const JointId hinge =
      model.add_joint(revolute(ground, arm, {.axis = {0, 1, 1}, .friction = c, .name = "hinge"}));
  const std::unique_ptr<Stepper> stepper = make_stepper(method, {});
  const double rounding = method == "event" ? 1e-6 : 1e-11;  // event integrates its forces
  State x = model.rest();
  for (int step = 0; step < 20; ++step) {
    const State before = x;
    const StepReport report = stepper->step(model, x, h);
    REQUIRE(report.advanced());
    REQUIRE(report.joints.size() == 2);
    const JointImpulse j = report.joint("hinge"), glue = report.joint("glue");
    CHECK(j.value == Approx(model.coordinate(x, hinge)).margin(1e-15));
    CHECK(j.rate == Approx(model.coordinate_rate(x, hinge)).margin(1e-15));
    CHECK(glue.coordinate == -1);
    const Vector3 gained = model.momentum(x).linear - model.momentum(before).linear - 3 * h * model.gravity();
    CHECK((j.impulse - gained).norm() < rounding);
    CHECK(j.friction == Approx((j.rate > 0 ? -c : c) * h).epsilon(1e-9));
    CHECK(j.mode == ContactMode::Slip);
    CHECK(glue.impulse.norm() > 0.5 * h * 9.81);
  }
}

TEST_CASE("a clock's spring knows how many turns it is wound, under every method and integrator",
          "[joint][event]") {
  const double J = 0.5, w = 2, v = 40;  // it swings as v/w sin(w t), by three turns to each side
  Model model;
  const BodyId wheel = model.add_body(Inertia::principal(1, {J, J, J}));
  const JointId axle = model.add_joint(revolute(ground, wheel, {.axis = {1, 2, 2}}));
  model.add_joint_spring({.joint = axle, .stiffness = J * w * w});
  model.set_gravity(Vector3::Zero());
  State x = model.rest();
  model.set_velocity(x, wheel, Vector3::Zero(), v * Vector3(1, 2, 2) / 3);
  const double t_end = 2, exact = v / w * std::sin(w * t_end), h = 1e-3;
  const auto swings = [&](Stepper& stepper, double step, double margin) {
    CAPTURE(std::string(stepper.name()));
    CHECK(model.coordinate(simulate(model, stepper, x, {.t_end = t_end, .h = step}).back(), axle) ==
          Approx(exact).margin(margin));
  };
  for (const char* method : {"lcp", "ncp", "ncp2"}) {
    const std::unique_ptr<Stepper> stepper = make_stepper(method, {});
    swings(*stepper, h, stepper->order() == 2 ? v * h * h : v * w * h);
  }
  if (!has_sundials()) return;
  for (const Integrator integrator :
       {Integrator::Arkode, Integrator::CvodeAdams, Integrator::CvodeBdf, Integrator::Ida}) {
    EventDriven event({.rtol = 1e-8, .integrator = integrator});
    swings(event, not_set, 1e-4);
  }
}

TEST_CASE("a screw turns a weight's fall into spin, and gears share a moment by their ratio", "[joint]") {
  Model model;
  const double lead = 0.05, J = 0.4;
  const BodyId nut = model.add_body(Inertia::solid_sphere(1, 1));
  model.add_joint(screw(ground, nut, {.lead = lead, .name = "thread"}));
  LcpStepper stepper;
  const Trajectory fall = run(model, stepper, model.rest(), 20, 1e-2);
  const double a = -9.81 * lead * lead / (lead * lead + J);  // (m + J/lead^2) z'' = -m g
  CHECK(model.velocity(fall.back(), nut).z() == Approx(20 * a).epsilon(1e-9));
  CHECK(std::abs(model.coordinate(fall.back(), {0})) > 2 * std::numbers::pi);

  Model gears;
  gears.set_gravity(Vector3::Zero());
  const BodyId small = gears.add_body(Inertia::principal(1, {1, 1, 1})),
               large = gears.add_body(Inertia::principal(1, {1, 1, 1}), {.pose = {{1, 0, 0}, {1, 0, 0, 0}}});
  const JointId driver = gears.add_joint(revolute(ground, small));
  gears.add_joint(revolute(ground, large, {.point = {1, 0, 0}}));
  gears.add_joint(gear(small, large, {.ratio = -0.3, .name = "teeth"}));
  gears.add_motor(
      {.joint = driver, .effort = [](const Model&, const State&, double, double) { return 1.0; }});
  const Trajectory spin = run(gears, stepper, gears.rest(), 10, 1e-2);
  const double rate = 10 / (1 + 0.3 * 0.3);  // (J1 + ratio^2 J2) rate' = 1
  CHECK(gears.angular_velocity(spin.back(), small).z() == Approx(rate));
  CHECK(gears.angular_velocity(spin.back(), large).z() == Approx(-0.3 * rate));
  CHECK(spin.report(0).joint_error < 1e-12);
  CHECK(spin.figures(999).joint_error < 1e-12);
}

TEST_CASE("friction in a screw, a hinge and a slide takes energy and then holds", "[joint]") {
  const int kind = GENERATE(0, 1, 2);
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId body = model.add_body(Inertia::solid_sphere(1, 0.5));
  const JointOptions options{.axis = {1, 2, 3}, .lead = 0.1, .friction = 0.2, .name = "rough"};
  const JointId joint = model.add_joint(kind == 0   ? screw(ground, body, options)
                                        : kind == 1 ? revolute(ground, body, options)
                                                    : prismatic(ground, body, options));
  State x = model.rest();
  const Vector3 axis = options.axis.normalized();
  model.set_velocity(x, body, kind == 1 ? Vector3(0, 0, 0) : Vector3(0.1 * axis),
                     kind == 2 ? Vector3(0, 0, 0) : Vector3(axis));
  LcpStepper stepper;
  const Trajectory motion = run(model, stepper, x, 2, 1e-2);
  double energy = model.energy(x);
  for (std::size_t i = 0; i < motion.steps(); ++i) {
    CHECK(motion.figures(i).energy <= energy * (1 + 1e-12) + 1e-20);
    energy = motion.figures(i).energy;
    const JointImpulse row = motion.report(i).joints[0];
    CHECK(std::abs(row.friction) <= 0.2 * 1e-2 * (1 + 1e-12));
  }
  CHECK(std::abs(model.coordinate_rate(motion.back(), joint)) < 1e-14);
  CHECK(motion.report(0).joint("rough").mode == ContactMode::Slip);
  CHECK(motion.report(199).joint("rough").mode == ContactMode::Stick);
}

TEST_CASE("assembly finds the nearest closed loop and the nearest motion that it allows",
          "[joint][assembly]") {
  const char* name = GENERATE("four-bar", "bennett", "slider-crank", "double-pendulum");
  const Scene s = scene(name);
  State x = s.start;
  for (int i = 0; i < s.model.nv(); ++i) {  // a rough pose
    Vector d = Vector::Unit(s.model.nv(), i);
    move(s.model, d, 0.05 * std::sin(3.0 * i + 1), x.q);
    x.nu[i] += 0.3 * std::cos(2.0 * i);
  }
  const State rough = x;
  const Projection found = project_onto_constraints(s.model, x);
  CAPTURE(name, found.iterations);
  REQUIRE(found.reached);
  CHECK(found.joint_error < 1e-13);
  CHECK(found.moved > 0.01);
  CHECK(found.moved < 0.3);
  CHECK(found.moved_velocity > 0.01);

  // nearest: small moves along the joints do not shorten the way, to first order
  const auto distance = [&](const State& y) {
    double sum = 0;
    for (const Body& b : s.model.bodies()) {
      if (b.nv == 0) continue;
      const Vector3 p = y.q.segment<3>(b.q0) - rough.q.segment<3>(b.q0);
      if (b.kind == BodyKind::Planar) {
        sum += b.mass * p.head<2>().squaredNorm() + b.J(2, 2) * p.z() * p.z();
        continue;
      }
      const auto q = [&](const State& z) {
        return Quaternion(z.q[b.q0 + 3], z.q[b.q0 + 4], z.q[b.q0 + 5], z.q[b.q0 + 6]);
      };
      const Vector3 phi = rotation_vector(q(rough).conjugate() * q(y));
      sum += b.mass * p.squaredNorm() + phi.dot(b.J * phi);
    }
    return sum;
  };
  const double h = 1e-4 / std::max(1.0, x.nu.norm());
  State plus = x, minus = x;
  move(s.model, x.nu, h, plus.q);
  move(s.model, x.nu, -h, minus.q);
  const double slope = (distance(plus) - distance(minus)) / (2e-4);
  CHECK(std::abs(slope) < 1e-5 * (1 + distance(x)));
  Instant now;
  evaluate(s.model, x, now);
  for (const JointRowInstant& row : now.joint_rows) CHECK(std::abs(row.velocity(x.nu)) < 1e-11);
}

TEST_CASE("assembly says so where joints contradict each other", "[joint][assembly]") {
  Model model;
  const BodyId mover = model.add_prescribed(PrescribedMotion::shaker({1, 0, 0}, 1)),
               bead = model.add_particle(1);
  model.add_joint(ball(ground, bead));
  model.add_joint(ball(mover, bead));
  State x = model.rest();
  x.t = 1;
  const Projection found = project_onto_constraints(model, x);
  CHECK_FALSE(found.reached);
  CHECK(found.joint_error > 0.1);
}
