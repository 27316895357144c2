// Torsional and rolling friction in the instantaneous model: CP1, impacts, and runs with located events.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/cp1.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/extrapolated.hpp"
#include "perp/step/impact.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

using namespace perp;

namespace {

constexpr double g = 9.81;

std::vector<std::unique_ptr<Stepper>> located() {
  std::vector<std::unique_ptr<Stepper>> all;
  all.push_back(std::make_unique<EventDriven>(EventDrivenOptions{.rtol = 1e-12}));
  all.push_back(std::make_unique<Extrapolated>(ExtrapolatedOptions{.rtol = 1e-12}));
  return all;
}

/// The largest difference of coordinates and velocities at T from the scene's exact motion.
double error(const Scene& s, Stepper& stepper, double T) {
  const State x = simulate(s.model, stepper, s.start, {.t_end = T}).back(), exact = s.exact(T);
  return std::max((x.q - exact.q).lpNorm<Eigen::Infinity>(), (x.nu - exact.nu).lpNorm<Eigen::Infinity>());
}

int count(const Trajectory& run, EventKind kind) {
  return static_cast<int>(
      std::count_if(run.events.begin(), run.events.end(), [&](const Event& e) { return e.kind == kind; }));
}

/// A ball on a plane with all three.
struct Ball {
  Model model;
  BodyId body;
  State start;

  Ball(double mu, double torsion, double rolling, const Vector3& v, const Vector3& w) {
    body = model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {.p = {0, 0, 0.1}}, .name = "ball"});
    model.add_contact(ground, body, sphere_on_plane(0.1),
                      {.mu = mu, .torsion = torsion, .rolling = rolling, .name = "floor"});
    start = model.rest();
    model.set_velocity(start, body, v, w);
  }
};

}  // namespace

TEST_CASE("CP1 slows what spins and what rolls as their bounds say, and holds what rests", "[moments][cp1]") {
  const Ball spins(0.3, 0.02, 0.001, Vector3::Zero(), {0, 0, 30});
  const Cp1Solution spun = solve_cp1(spins.model, spins.start);
  REQUIRE(spun.status == Cp1Status::Unique);
  CHECK(spun.contacts[0].sliding);
  CHECK(spun.contacts[0].mode == ContactMode::Slip);
  CHECK(spun.contacts[0].moment.z() == Approx(-0.02 * g).epsilon(1e-12));
  CHECK(spun.acceleration[5] == Approx(-0.02 * g / 0.004).epsilon(1e-12));

  const Ball rolls(0.3, 0.02, 0.001, {1, 0, 0}, {0, 10, 0});
  const Cp1Solution rolled = solve_cp1(rolls.model, rolls.start);
  CHECK(rolled.contacts[0].mode == ContactMode::Stick);
  CHECK(rolled.contacts[0].rolls);
  CHECK(rolled.acceleration[0] == Approx(-5.0 / 7 * 0.001 / 0.1 * g).epsilon(1e-10));

  for (const double off : {-1e-6, 1e-6}) {  // tan(slope) on either side of rolling/R
    Ball rests(0.3, 0.02, 0.001, Vector3::Zero(), Vector3::Zero());
    const double slope = std::atan(0.01) + off;
    rests.model.set_gravity({g * std::sin(slope), 0, -g * std::cos(slope)});
    const Cp1Solution held = solve_cp1(rests.model, rests.start);
    CAPTURE(off);
    CHECK(held.contacts[0].rolls == (off > 0));
    CHECK(held.acceleration[0] ==
          Approx(off > 0 ? 5.0 / 7 * g * (std::sin(slope) - 0.01 * std::cos(slope)) : 0).margin(1e-9));
  }
}

TEST_CASE("an impact takes as much spin as its normal impulse times the torsion", "[moments][impact]") {
  for (const double torsion : {0.002, 0.1}) {
    const Ball ball(0, torsion, 0, {0, 0, -3}, {0, 0, 30});
    const Impact hit = solve_impact(ball.model, ball.start);
    REQUIRE(hit.solved);
    CHECK(hit.contacts[0].p_n == Approx(3).epsilon(1e-12));
    const double after = std::max(0.0, 30 - torsion * 3 / 0.004);
    CHECK(hit.nu[5] == Approx(after).margin(1e-10));
    CHECK(hit.contacts[0].moment.z() == Approx(-0.004 * (30 - after)).epsilon(1e-9));
    CHECK(hit.contacts[0].mode == (after > 0 ? ContactMode::Slip : ContactMode::Stick));
  }
}

TEST_CASE("located runs are within 1e-10 of a spun sphere and of coasting wheels, through their stops",
          "[moments][event]") {
  for (const std::unique_ptr<Stepper>& stepper : located()) {
    CAPTURE(stepper->name());
    CHECK(error(scene("spun-sphere"), *stepper, 0.5) < 1e-10);
    CHECK(error(scene("spun-sphere"), *stepper, 0.8) < 1e-10);
    CHECK(error(scene("coasting-wheel", {{"rolling", 0.02}}), *stepper, 1) < 1e-10);
    CHECK(error(scene("coasting-wheel", {{"rolling", 0.02}}), *stepper, 2) < 1e-10);
    CHECK(error(scene("coasting-wheel", {{"slope", 0.1}, {"v0", -1}}), *stepper, 2) < 1e-10);
    CHECK(error(scene("coasting-wheel", {{"slope", 0.04}, {"v0", 0}}), *stepper, 2) < 1e-10);
  }
}

TEST_CASE("the end of spinning and of rolling are events, found to rounding", "[moments][event]") {
  EventDriven event({.rtol = 1e-12});
  const Scene spun = scene("spun-sphere"), wheel = scene("coasting-wheel", {{"rolling", 0.02}});
  const Trajectory spins = simulate(spun.model, event, spun.start, {.t_end = 0.8});
  REQUIRE(spins.events.size() == 1);
  CHECK(spins.events[0].kind == EventKind::Stick);
  CHECK(spins.events[0].t == Approx(0.611620795107034).epsilon(1e-11));
  const Trajectory rolls = simulate(wheel.model, event, wheel.start, {.t_end = 2});
  REQUIRE(rolls.events.size() == 1);
  CHECK(rolls.events[0].kind == EventKind::Stick);
  CHECK(rolls.events[0].t == Approx(3 * 0.2 / (2 * 0.02 * g)).epsilon(1e-11));
}

TEST_CASE("a slope is climbed, stood on or rolled down as tan(slope) and rolling/R say", "[moments][event]") {
  EventDriven event({.rtol = 1e-12});
  for (const double off : {-1e-6, 1e-6}) {
    const Scene s = scene("coasting-wheel", {{"slope", std::atan(0.05) + off}, {"v0", 0}});
    const State x = simulate(s.model, event, s.start, {.t_end = 2}).back();
    CAPTURE(off);
    if (off < 0)
      CHECK(std::abs(x.nu[0]) < 1e-12);
    else
      CHECK(x.nu[0] == Approx(s.exact(2).nu[0]).epsilon(1e-6));
  }
}

TEST_CASE("a disc that slides and spins stops both at once, where an integration of its own says",
          "[moments][event]") {
  // v' = -g mu² v/S, w' = -g gamma² w/(S J/m): ln v and ln w fall in proportion, so that with k = mu² J/(m gamma²), v = c w^k
  const double mu = 0.3, J = 0.005, v0 = 1, w0 = 12;
  for (const double k : {1.0, 0.5, 2.0}) {
    const double gamma = mu * std::sqrt(J / k), c = v0 / std::pow(w0, k);
    Model model;
    const BodyId disc = model.add_body(Inertia::principal(1, {J / 2, J / 2, J}), {.name = "disc"});
    model.add_contact(ground, disc, point_on_plane(Vector3::Zero()),
                      {.mu = mu, .torsion = gamma, .name = "floor"});
    State x = model.rest();
    model.set_velocity(x, disc, {v0, 0, 0}, {0, 0, w0});
    // dt = S/(g gamma²) (J/m) dw/w down to w = e^-46 w0, by Simpson's rule in s = ln w; k = 1 in closed form
    double stops = 0;
    constexpr int n = 200000;
    const double length = 46, h = length / n;
    for (int i = 0; i <= n; ++i) {
      const double w = w0 * std::exp(-i * h), S = std::hypot(mu * c * std::pow(w, k), gamma * w);
      stops += (i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2) * h / 3 * J * S / (g * gamma * gamma);
    }
    if (k == 1) CHECK(stops == Approx(std::hypot(mu * v0, gamma * w0) / (g * mu * mu)).epsilon(1e-9));
    EventDriven event({.rtol = 1e-11});
    const Trajectory run = simulate(model, event, x, {.t_end = 1.5 * stops});
    CAPTURE(k, stops);
    REQUIRE(count(run, EventKind::Stick) == 1);
    CHECK(run.events[0].t == Approx(stops).epsilon(1e-6));
    CHECK(run.back().nu.norm() < 1e-9);
    const State half = run.at(stops / 2);
    CHECK(half.nu[0] == Approx(c * std::pow(half.nu[5], k)).epsilon(1e-9));
  }
}

TEST_CASE(
    "a ball that slides, spins and rolls to rest goes as the steps of fixed size do, and its energy is known",
    "[moments][event]") {
  const Ball ball(0.2, 0.004, 0.003, {1, 0.5, 0}, {4, -3, 25});
  EventDriven event({.rtol = 1e-11});
  const Trajectory run = simulate(ball.model, event, ball.start, {.t_end = 4});
  double left = 0, friction = 0;
  for (std::size_t i = 0; i < run.steps(); ++i) {
    left = std::max(left, std::abs(run.report(i).energy_left));
    friction += run.report(i).energy_friction;
    CHECK(run.report(i).residuals.friction < 1e-8);
  }
  CHECK(left < 1e-7);
  CHECK(friction == Approx(-ball.model.kinetic_energy(ball.start)).epsilon(1e-7));
  CHECK(run.back().nu.norm() < 1e-9);
  const State at = run.at(0.3);
  const auto off = [&](int steps) {
    Ncp2Stepper ncp2;
    const State x = simulate(ball.model, ncp2, ball.start, {.t_end = 0.3, .h = 0.3 / steps}).back();
    return (x.q - at.q).norm();
  };
  CHECK(off(400) < 1e-4);
  CHECK(off(1600) < 0.15 * off(400));
}

TEST_CASE("a spinning ball that bounces loses spin at each bounce", "[moments][event]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.1), {.name = "ball"});
  model.add_contact(ground, ball, sphere_on_plane(0.1), {.torsion = 0.002, .e = 0.5, .name = "floor"});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 0.3});
  model.set_velocity(x, ball, Vector3::Zero(), {0, 0, 30});
  EventDriven event({.rtol = 1e-11});
  const double falls = std::sqrt(2 * 0.2 / g), v = g * falls;
  const Trajectory run = simulate(model, event, x, {.t_end = 1.2 * falls});
  CHECK(run.back().nu[5] == Approx(30 - 0.002 * 1.5 * v / 0.004).epsilon(1e-10));
  CHECK(run.back().nu[2] == Approx(0.5 * v - g * 0.2 * falls).epsilon(1e-9));
}
