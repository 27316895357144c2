// What a step's answer cannot buy: joints that contradict each other, springs and spins that a step cannot follow, contacts that come
// into being within it.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "perp/model/gaps.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;
using Catch::Contains;

namespace {

Inertia cube(double mass, double size) {
  return Inertia::principal(mass, Vector3::Constant(mass * size * size / 6));
}

/// A slider driven along x while a rod to (0, 1, 0) holds it: they agree at t = 0 alone.
Model jam() {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId slider = model.add_body(cube(1, 0.1), {.name = "slider"});
  const JointId drive = model.add_joint(prismatic(ground, slider, {.axis = {1, 0, 0}, .name = "drive"}));
  model.add_motion(drive, {.position = [](double t) { return 0.1 * std::sin(t) * std::sin(t); },
                           .rate = [](double t) { return 0.1 * std::sin(2 * t); },
                           .acceleration = [](double t) { return 0.2 * std::cos(2 * t); }});
  model.add_joint(rod(ground, slider, {.point = {0, 1, 0}, .point_b = {0, 0, 0}, .name = "tie"}));
  return model;
}

/// A particle of a gram on a spring of 1e6 N/m, stretched by a millimetre, no gravity.
Model stiff() {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId p = model.add_particle(0.001, {.pose = {{0.101, 0, 0}, Quaternion::Identity()}, .name = "p"});
  model.add_spring({.a = ground, .b = p, .stiffness = 1e6, .length = 0.1});
  return model;
}

}  // namespace

TEST_CASE("joints that contradict each other fail the step and are named", "[pass_mark]") {
  const Model model = jam();
  for (const char* method : {"lcp", "ncp", "ncp2", "event"}) {
    CAPTURE(method);
    const auto stepper = make_stepper(method);
    const double closed = std::string(method) == "event" ? 1e-8 : 1e-9;
    try {
      (void)simulate(model, *stepper, model.rest(), {.t_end = 1, .h = 0.01});
      FAIL("the run should not reach its end");
    } catch (const StepFailure& failure) {
      CAPTURE(failure.report.message);
      CHECK_THAT(failure.report.message, Contains("'tie' by ") && Contains("'drive' by "));
      for (std::size_t k = 0; k + 1 < failure.trajectory.size(); ++k)
        CHECK(failure.trajectory.figures(k).joint_error < closed);
    }
  }
}

TEST_CASE("a spring that a step cannot follow is refused, with the step that would do", "[pass_mark]") {
  const Model model = stiff();
  for (const char* method : {"lcp", "ncp2"}) {
    CAPTURE(method);
    const auto stepper = make_stepper(method);
    State x = model.rest();
    const StepReport report = stepper->step(model, x, 1e-3);
    CAPTURE(report.message);
    CHECK_FALSE(report.advanced());
    CHECK_THAT(report.message, Contains("spring 1 between 'ground' and 'p'") && Contains("6.3245553") &&
                                   Contains("e-06 s would do"));
    // 2/omega = 6.3246e-5 s is where the oscillation grows, a tenth of it is the step that the message says would do
    const Trajectory run = simulate(model, *stepper, model.rest(), {.t_end = 0.01, .h = 6.3e-6});
    for (std::size_t k = 0; k < run.size(); ++k) CHECK(std::abs(run.state(k).q[0] - 0.1) < 1.2e-3);
  }
  const auto implicit = make_stepper("ncp");
  const Trajectory run = simulate(model, *implicit, model.rest(), {.t_end = 0.05, .h = 1e-3});
  for (std::size_t k = 0; k < run.size(); ++k) CHECK(std::abs(run.state(k).q[0] - 0.1) <= 1.001e-3);
}

TEST_CASE("a stiff spring across a joint's freedom is not refused", "[pass_mark]") {
  Model model;
  const BodyId bead = model.add_body(cube(0.001, 0.01), {.name = "bead"});
  model.add_joint(prismatic(ground, bead, {.axis = {1, 0, 0}}));
  model.add_spring({.a = ground, .b = bead, .point_a = {0, 0, 1}, .stiffness = 1e6, .length = 1});
  State x = model.rest();
  model.set_velocity(x, bead, {1e-3, 0, 0});
  for (const char* method : {"lcp", "ncp2"}) {
    CAPTURE(method);
    const auto stepper = make_stepper(method);
    State y = x;
    const StepReport report = stepper->step(model, y, 1e-3);
    CAPTURE(report.message);
    CHECK(report.advanced());
  }
}

TEST_CASE("a spin under lcp gains no energy at any step", "[pass_mark]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId b = model.add_body(Inertia::principal(1, {1, 2, 3}), {.name = "b"});
  const double h = GENERATE(0.02, 0.2, 1.0);
  const Vector3 w = GENERATE(Vector3(0.1, 0, 3), Vector3(0.01, 3, 0.02), Vector3(3, 0.1, 0.1));
  State x = model.rest();
  model.set_velocity(x, b, Vector3::Zero(), w);
  const Vector3 L = model.momentum(x).angular;
  const auto stepper = make_stepper("lcp");
  double before = model.energy(x);
  const double start = before;
  for (int k = 0; k < 2000; ++k) {
    const StepReport report = stepper->step(model, x, h);
    REQUIRE(report.advanced());
    CHECK(report.residuals.newton_euler < 1e-12 * L.norm());
    CHECK(report.energy <= before + 1e-13 * start);
    before = report.energy;
  }
}

TEST_CASE("an almost massless rod does not give its bob energy", "[pass_mark]") {
  Model model;
  model.set_gravity({0, -9.81, 0});
  const double m = 1e-6, angle = std::numbers::pi / 3;
  const Vector3 tip(std::sin(angle), -std::cos(angle), 0);
  const BodyId rod = model.add_planar_body(m, m / 12, {.pose = {0.5 * tip, rotation({0, 0, angle})}});
  const BodyId bob = model.add_planar_body(1, 1e-12, {.pose = {tip, Quaternion::Identity()}});
  model.add_joint(revolute(ground, rod, {.name = "top"}));
  model.add_joint(fixed(rod, bob, {.point = tip, .name = "weld"}));
  const auto stepper = make_stepper("ncp2");
  const Trajectory run = simulate(model, *stepper, model.rest(), {.t_end = 2, .h = 0.01});
  const double start = model.energy(run.front());
  for (std::size_t k = 0; k < run.size(); ++k) CHECK(std::abs(model.energy(run.state(k)) - start) < 1e-2);
}

TEST_CASE("a contact point that comes into being within a step counts in that step", "[pass_mark]") {
  constexpr double r = 0.1, reach = 0.01;
  const double e = GENERATE(0.0, 0.5);
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, r), {.name = "ball"});
  const Gap near_floor = [=](const Pose&, const Pose& X, double) {
    const double gap = X.p.z() - r;
    return ContactPoint{
        .gap = gap > reach ? infinity : gap, .normal = Vector3::UnitZ(), .point = X.p - r * Vector3::UnitZ()};
  };
  model.add_contact(ground, ball, near_floor, {.mu = 0.3, .e = e});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 0.15});
  model.set_velocity(x, ball, {0.5, 0, -1});
  for (const char* method : {"lcp", "ncp", "ncp-start", "ncp2"}) {
    CAPTURE(method, e);
    const auto stepper = make_stepper(method);
    State y = x;
    StepReport report = stepper->step(model, y, 0.2);  // free flight would end 0.15 m inside
    CAPTURE(report.message);
    REQUIRE(report.advanced());
    CHECK(std::abs(report.gap_min) < 1e-12);
    CHECK(model.velocity(y, ball).z() == Approx(e).margin(1e-12));
    CHECK(model.velocity(y, ball).x() == Approx(std::max(0.5 - 0.3 * (1 + e), 0.5 * 5 / 7)).epsilon(1e-9));
  }
}
