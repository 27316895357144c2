// Modes that many contacts and brakes leave open: which hold, which give way, at a bounded cost.
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/cp1.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

constexpr double slope = 0.2, frame_mass = 3, wheel_mass = 0.5, wheel_inertia = 0.0025, radius = 0.1;

/// A frame down a slope on wheels whose brakes each give up to `brake` N m.
struct Cart {
  Model model;
  State x;
  Cart(int wheels, double brake, double speed) {
    model.set_gravity(9.81 * Vector3(std::sin(slope), -std::cos(slope), 0));
    const BodyId frame = model.add_planar_body(frame_mass, 0.1, {.pose = {{0, radius, 0}}});
    for (int i = 0; i < wheels; ++i) {
      const Vector3 hub(wheels == 1 ? 0 : 0.6 * i / (wheels - 1) - 0.3, radius, 0);
      const BodyId wheel = model.add_planar_body(wheel_mass, wheel_inertia, {.pose = {hub}});
      model.add_joint(revolute(frame, wheel, {.point = hub, .friction = brake}));
      model.add_contact(ground, wheel, disc_on_line(radius, horizontal_line), {.mu = 0.9});
    }
    x = model.rest();
    for (int i = 0; i <= wheels; ++i)
      model.set_velocity(x, {i + 1}, {speed, 0, 0}, {0, 0, i == 0 ? 0 : -speed / radius});
  }
};

}  // namespace

TEST_CASE("A cart on braked wheels rests on a slope, however many brakes share its weight", "[event]") {
  if (!has_sundials()) return;
  const int wheels = GENERATE(2, 3, 4, 6, 8, 12);
  const double brake = 1.3 * (frame_mass + wheels * wheel_mass) * 9.81 * std::sin(slope) * radius / wheels;
  const Cart cart(wheels, brake, 0);
  EventDriven stepper({.max_evaluations = 20'000});
  const Trajectory run = simulate(cart.model, stepper, cart.x, {.t_end = 2});
  CAPTURE(wheels);
  CHECK(run.events.empty());
  CHECK((run.back().q - cart.x.q).norm() < 1e-12);
}

TEST_CASE("A cart on braked wheels stops when its brakes have used its momentum up", "[event]") {
  if (!has_sundials()) return;
  const int wheels = GENERATE(2, 3, 6);
  const double mass = frame_mass + wheels * wheel_mass;
  const double brake = 1.5 * mass * 9.81 * std::sin(slope) * radius / wheels;
  // each brake gives the ground's friction brake/radius, each wheel has the momentum of its turning besides
  const double stops = (mass + wheels * wheel_inertia / (radius * radius)) /
                       (wheels * brake / radius - mass * 9.81 * std::sin(slope));
  const Cart cart(wheels, brake, 1);
  EventDriven stepper;
  const Trajectory run = simulate(cart.model, stepper, cart.x, {.t_end = stops + 1});
  CAPTURE(wheels, stops);
  REQUIRE(run.events.size() == static_cast<std::size_t>(wheels));
  for (const Event& e : run.events) {
    CHECK(e.kind == EventKind::Stick);
    CHECK(std::abs(e.t - stops) < 1e-9);
  }
  CHECK(run.back().nu.norm() < 1e-12);
}

TEST_CASE("Ten boxes on each other rest without an event", "[event]") {
  if (!has_sundials()) return;
  const Scene s = scene("stack", {{"count", 10}, {"ratio", 1}});
  EventDriven stepper({.rtol = 1e-8});
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 5});
  CHECK(run.events.empty());
  CHECK((run.back().q - s.start.q).norm() < 1e-10);
}

TEST_CASE("CP1 finds that a body rests however small its moment of inertia is", "[cp1]") {
  const double share = GENERATE(1.0 / 3, 1e-4, 1e-8);
  const double mu = 0.6, along = GENERATE(0.0, 0.5);
  Model model;
  model.set_gravity({9.81 * along, -9.81, 0});
  const BodyId rod = model.add_planar_body(1, share);
  for (const double end : {-1.0, 1.0})
    model.add_contact(ground, rod, point_on_plane({end, 0, 0}, horizontal_line), {.mu = mu});
  const Cp1Solution solution = solve_cp1(model, model.rest());
  CAPTURE(share, along);
  REQUIRE(solution.status == Cp1Status::Unique);
  for (const Cp1Contact& c : solution.contacts) CHECK(c.mode == ContactMode::Stick);
  CHECK(solution.acceleration.head<2>().norm() < 1e-6 * 9.81);
}

TEST_CASE("A joint that is jerked at the start against what nothing can move says so", "[event]") {
  if (!has_sundials()) return;
  // a disc on the floor, fixed to a turntable that turns its side down into the floor
  Model model;
  model.set_gravity({0, -9.81, 0});
  const BodyId table = model.add_prescribed(PrescribedMotion::turntable({0, 0, 1}, 1.5, {{2, 1, 0}}));
  const BodyId disc = model.add_planar_body(1, 0.5, {.pose = {{0, 1, 0}}});
  model.add_joint(fixed(disc, table, {.point = {1, 1, 0}}));
  model.add_contact(ground, disc, disc_on_line(1, horizontal_line));
  EventDriven stepper;
  try {
    (void)simulate(model, stepper, model.rest(), {.t_end = 1});
    FAIL("the joint cannot be held");
  } catch (const StepFailure& failure) {
    CAPTURE(failure.report.message);
    CHECK(failure.report.message.find("jerked at the start") != std::string::npos);
  }
}

TEST_CASE("Velocities that a joint jerks at the start have a row of their own, with its impulse", "[event]") {
  if (!has_sundials()) return;
  // a pendulum let go with a velocity along its rod, and across it
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId bob = model.add_planar_body(2, 0.1, {.pose = {{0, -1, 0}}, .name = "bob"});
  model.add_joint(revolute(ground, bob, {.point = {0, 0, 0}, .axis = {0, 0, 1}, .name = "hinge"}));
  State x = model.rest();
  model.set_velocity(x, bob,
                     {3, -0.5, 0});  // |r x v| = 3 of a body that does not turn: hinge asks for w = 3 2/2.1
  EventDriven stepper;
  const Trajectory run = simulate(model, stepper, x, {.t_end = 0.5});
  REQUIRE(run.size() > 2);
  CHECK(run.state(0).nu == x.nu);
  CHECK(run.state(1).t == 0);
  const double rate = 3 * 2 / 2.1;
  CHECK(run.state(1).nu[2] == Approx(rate).epsilon(1e-12));
  const StepFigures& row = run.figures(0);
  CHECK(row.residuals.newton_euler < 1e-12);
  const double before = 0.5 * 2 * (9 + 0.25), after = 0.5 * 2.1 * rate * rate;
  CHECK(row.energy == Approx(after).epsilon(1e-12));
  CHECK(row.energy_impact == Approx(after - before).epsilon(1e-12));
  CHECK(std::abs(row.energy_left) < 1e-12 * before);
}

}  // namespace perp
