#include "perp/step/event_driven.hpp"

#include <algorithm>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

std::vector<std::string> kinds(const Trajectory& run) {
  std::vector<std::string> all;
  for (const Event& e : run.events) all.emplace_back(name_of(e.kind));
  return all;
}

}  // namespace

TEST_CASE("A ball that bounces infinitely often lies still long after, in few events and steps", "[event]") {
  if (!has_sundials()) return;
  const double e = GENERATE(0.5, 0.8, 0.9);
  const Scene s = scene("bouncing-ball", {{"e", e}});
  const double zeno = 0.451523640985730904 * (1 + e) / (1 - e);
  EventDriven stepper;
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 10 * zeno});
  CAPTURE(e, run.events.size(), run.steps());
  CHECK(run.events.size() <= 200);
  CHECK(run.steps() <= 200);
  CHECK(run.events.back().kind == EventKind::Zeno);
  CHECK(std::abs(run.back().q[2]) < 1e-12);
  CHECK(run.back().nu.norm() < 1e-12);
}

TEST_CASE(
    "Two balls that bounce on each other between floor and ceiling lie still long after, in few events and "
    "steps",
    "[event]") {
  if (!has_sundials()) return;
  const double e = GENERATE(0.1, 0.5, 0.8, 0.9), mass = GENERATE(0.2, 1.0, 5.0);
  Model model;
  const BodyId low = model.add_body(Inertia::solid_sphere(1, 0.1));
  const BodyId high = model.add_body(Inertia::solid_sphere(mass, 0.1));
  model.add_contact(ground, low, sphere_on_plane(0.1), {.e = e});
  model.add_contact(ground, high, sphere_on_plane(0.1, {-Vector3::UnitZ(), Vector3(0, 0, 1)}), {.e = e});
  model.add_contact(low, high, sphere_on_sphere(0.1, 0.1), {.e = e});
  State x = model.rest();
  model.set_position(x, low, {0, 0, 0.3});
  model.set_position(x, high, {0, 0, 0.6});
  model.set_velocity(x, high, {0, 0, 5});
  EventDriven stepper({.rtol = 1e-8});
  const Trajectory run = simulate(model, stepper, x, {.t_end = 80});
  int steps = 0;
  for (std::size_t i = 0; i < run.steps(); ++i) steps += run.figures(i).h > 0 ? 1 : 0;
  CAPTURE(e, mass);
  const std::vector<std::string> all = kinds(run);
  CHECK(std::count(all.begin(), all.end(), "zeno") >= 1);
  CHECK(run.events.back().t < 8);
  CHECK(run.events.size() <= 200);
  CHECK(steps <= 200);
  CHECK(std::abs(model.position(run.back(), low).z() - 0.1) < 1e-12);
  CHECK(std::abs(model.position(run.back(), high).z() - 0.3) < 1e-12);
  CHECK(run.back().nu.norm() < 1e-12);
}

TEST_CASE("Bodies that would pass each other within one step meet", "[event]") {
  if (!has_sundials()) return;
  // free flight is integrated in steps as long as it lasts: a step begins and ends with the balls well apart
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId a = model.add_body(Inertia::solid_sphere(1, 0.1));
  const BodyId b = model.add_body(Inertia::solid_sphere(1, 0.1));
  model.add_contact(a, b, sphere_on_sphere(0.1, 0.1), {.e = 1});
  State x = model.rest();
  model.set_position(x, b, {50, 0.15, 0});
  model.set_velocity(x, b, {-1, 0, 0});
  EventDriven stepper({.rtol = 1e-8});
  const Trajectory run = simulate(model, stepper, x, {.t_end = 100});
  REQUIRE(run.events.size() == 1);
  CHECK(run.events[0].t == Approx(50 - std::sqrt(0.04 - 0.15 * 0.15)).epsilon(1e-12));
}

TEST_CASE("A rod in Painleve's paradox jams, loses energy and turns about its tip", "[event]") {
  if (!has_sundials()) return;
  const Scene s = scene("painleve-rod");
  EventDriven stepper({.rtol = 1e-12});
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 0.1});
  const State after = run.state(1);  // the jam is at the start
  CHECK(after.t == 0);
  CHECK(after.nu[0] == Approx(0.6).epsilon(1e-12));
  CHECK(after.nu[1] == Approx(0.3).epsilon(1e-12));
  CHECK(after.nu[2] == Approx(-0.670820393249937).epsilon(1e-12));
  CHECK(s.model.energy(after) < s.model.energy(s.start));
}

TEST_CASE("step advances by exactly h, with the impulses of the whole step", "[event]") {
  if (!has_sundials()) return;
  const Scene s = scene("seed-sphere");
  State x = s.start;
  EventDriven stepper({.rtol = 1e-11});
  const StepReport report = stepper.step(s.model, x, 0.4);
  REQUIRE(report.advanced());
  CHECK(x.t == 0.4);
  CHECK(report.h == 0.4);
  CHECK(report.contact("floor").p_n == Approx(9.81 * 0.4).epsilon(1e-12));
  CHECK(report.contact("floor").impulse.x() == Approx(-4.0 / 7).epsilon(1e-9));  // 2 m/s becomes 10/7 m/s
  CHECK(report.energy_friction == Approx(-4.0 / 7).epsilon(1e-9));
  CHECK(report.contact("floor").force.z() == Approx(9.81).epsilon(1e-12));
}

TEST_CASE("A run gives rows at the multiples of h besides its own steps and two at an event", "[event]") {
  if (!has_sundials()) return;
  const Scene s = scene("seed-sphere");
  EventDriven stepper({.rtol = 1e-9});
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 0.6, .h = 0.1});
  for (int k = 0; k <= 6; ++k) {
    bool there = false;
    for (std::size_t i = 0; i < run.size(); ++i) there = there || run.t(i) == 0 + k * 0.6 / 6;
    CHECK(there);
  }
  REQUIRE(kinds(run) == std::vector<std::string>{"stick"});
  CHECK(run.events[0].contact == "floor");
  CHECK(run.events[0].before == ContactMode::Slip);
  CHECK(run.events[0].after == ContactMode::Stick);
  int rows = 0;
  for (std::size_t i = 0; i < run.size(); ++i) rows += run.t(i) == run.events[0].t ? 1 : 0;
  CHECK(rows == 2);
}

TEST_CASE("The state between rows counts the turns that joints have made", "[event]") {
  if (!has_sundials()) return;
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId wheel = model.add_body(Inertia::solid_sphere(1, 0.1));
  const JointId hinge = model.add_joint(revolute(ground, wheel, {.axis = {0, 0, 1}}));
  model.add_force(wheel, [](const Model&, const State&) -> Wrench { return {.moment = {0, 0, 1e-3}}; });
  State x = model.rest();
  model.set_velocity(x, wheel, Vector3::Zero(), {0, 0, 10});
  EventDriven stepper({.rtol = 1e-10});
  const Trajectory run = simulate(model, stepper, x, {.t_end = 2});
  const double gain = 1e-3 / (0.4 * 0.01);
  for (const double t : {0.1, 0.33, 0.5, 1.05, 1.7, 2.0})
    CHECK(model.coordinate(run.at(t), hinge) == Approx(10 * t + 0.5 * gain * t * t).epsilon(1e-9));
}

TEST_CASE("Events tell what happened to which contact", "[event]") {
  if (!has_sundials()) return;
  EventDriven stepper({.rtol = 1e-10});
  const Scene shaker = scene("shaker");
  CHECK(kinds(simulate(shaker.model, stepper, shaker.start, {.t_end = 0.6})) ==
        std::vector<std::string>{"lift", "impact", "lift"});
  Scene rising = scene("seed-sphere");  // what leaves at once is no event
  rising.model.set_gravity({0, 0, 1});
  CHECK(simulate(rising.model, stepper, rising.start, {.t_end = 1}).events.empty());
  const Scene ball = scene("ball-on-sphere");
  CHECK(kinds(simulate(ball.model, stepper, ball.start, {.t_end = 1.5})) ==
        std::vector<std::string>{"slip", "lift"});
  const Scene uphill = scene("incline-block", {{"v0", -2}});
  CHECK(kinds(simulate(uphill.model, stepper, uphill.start, {.t_end = 1})) ==
        std::vector<std::string>{"reverse"});
  const Scene pendulum = scene("friction-pendulum");
  const Trajectory swings = simulate(pendulum.model, stepper, pendulum.start, {.t_end = 12});
  REQUIRE(swings.events.size() == 11);
  for (std::size_t i = 0; i < 10; ++i) CHECK(swings.events[i].kind == EventKind::Reverse);
  CHECK(swings.events[10].kind == EventKind::Stick);
  CHECK(swings.events[10].contact == "hinge");
}

TEST_CASE("A cube that slides to rest on four corners stays flat, though their forces are not determined",
          "[event]") {
  if (!has_sundials()) return;
  const Scene s = scene("sliding-cube");
  EventDriven stepper({.rtol = 1e-11});
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 1.5});
  CHECK(run.back().q[0] == Approx(3.669724770642202).epsilon(1e-11));
  CHECK(std::abs(run.back().q[2] - 0.05) < 1e-12);
  double weight = 0;
  for (const ContactRow& c : run.report(run.steps() - 1).contacts) weight += c.force.z();
  CHECK(weight == Approx(1 * 9.81).epsilon(1e-10));
}

TEST_CASE("A run that starts with an overlap says so and what to do", "[event]") {
  if (!has_sundials()) return;
  const Scene s = scene("sunk-box");
  EventDriven stepper;
  State x = s.start;
  const StepReport report = stepper.step(s.model, x, 0.1);
  CHECK(report.status == StepStatus::NotSolved);
  CHECK(report.message.find("overlap") != std::string::npos);
  CHECK(x.q == s.start.q);
  CHECK_THROWS_AS(simulate(s.model, stepper, s.start, {.t_end = 0.1}), StepFailure);
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 0.1, .project_initial = true});
  CHECK(run.back().t == 0.1);
}

TEST_CASE("An exception in a user's force comes through SUNDIALS as it was thrown", "[event]") {
  if (!has_sundials()) return;
  struct Mine {};
  Model model;
  const BodyId ball = model.add_particle(1);
  model.add_force(ball, [](const Model&, const State& x) -> Wrench {
    if (x.t > 0.05) throw Mine();
    return {};
  });
  EventDriven stepper;
  CHECK_THROWS_AS(simulate(model, stepper, model.rest(), {.t_end = 1}), Mine);
}

TEST_CASE("A force that is not finite ends the run with a report", "[event]") {
  if (!has_sundials()) return;
  Model model;
  const BodyId ball = model.add_particle(1);
  model.add_force(ball, [](const Model&, const State& x) -> Wrench {
    return {.force = {x.t > 0.05 ? not_set : 1.0, 0, 0}};
  });
  EventDriven stepper;
  try {
    (void)simulate(model, stepper, model.rest(), {.t_end = 1});
    FAIL("it ran through");
  } catch (const StepFailure& failure) {
    CHECK(failure.trajectory.back().t == Approx(0.05).margin(1e-3));
    CHECK_FALSE(failure.report.message.empty());
  }
}

TEST_CASE("EventDriven refuses tolerances that it cannot hold", "[event]") {
  CHECK_THROWS_AS(EventDriven({.rtol = 0}), std::invalid_argument);
  CHECK_THROWS_AS(EventDriven({.rtol = 0.1}), std::invalid_argument);
  CHECK_THROWS_AS(EventDriven({.rtol = 1e-8, .atol = -1}), std::invalid_argument);
  CHECK_THROWS_AS(integrator_named("euler"), std::invalid_argument);
  CHECK(integrator_named("ida") == Integrator::Ida);
}

}  // namespace perp
