// Impacts one after the other: rows of balls, a break, what has no single order.
#include <catch2/catch.hpp>

#include "perp/model/gaps.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/extrapolated.hpp"
#include "perp/step/impact.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

constexpr double radius = 0.05;  // [m]

/// Balls in touch on a line along x, without gravity.
struct Row {
  Model model;
  std::vector<BodyId> balls;
  State x;

  Row(const std::vector<double>& masses, double e) {
    model.set_gravity(Vector3::Zero());
    for (std::size_t i = 0; i < masses.size(); ++i)
      balls.push_back(model.add_body(Inertia::solid_sphere(masses[i], radius),
                                     {.pose = {.p = {2 * radius * static_cast<double>(i), 0, 0}}}));
    for (std::size_t i = 0; i + 1 < balls.size(); ++i)
      model.add_contact(balls[i], balls[i + 1], sphere_on_sphere(radius, radius), {.e = e});
    x = model.rest();
  }
  double velocity(const Impact& impact, std::size_t ball) const {
    State after = x;
    after.nu = impact.nu;
    return model.velocity(after, balls[ball]).x();
  }
};

constexpr ImpactOptions one_by_one{.order = ImpactOrder::Sequential};

}  // namespace

TEST_CASE("Of five equal balls in a row as many leave as come in, one impact after the other", "[sequence]") {
  for (std::size_t in = 1; in <= 4; ++in) {
    Row row({1, 1, 1, 1, 1}, 1);
    for (std::size_t i = 0; i < in; ++i) row.model.set_velocity(row.x, row.balls[i], {1, 0, 0});
    const Impact impact = solve_impact(row.model, row.x, one_by_one);
    REQUIRE(impact.solved);
    CHECK_FALSE(impact.ambiguous);
    for (std::size_t i = 0; i < 5; ++i)
      CHECK(row.velocity(impact, i) == Approx(i >= 5 - in ? 1 : 0).margin(1e-12));
    CHECK(std::abs(impact.energy) < 1e-12);
  }
}

TEST_CASE("Balls of other masses and e leave a row as impacts of two by two say", "[sequence]") {
  const std::vector<double> masses{2, 1, 3};
  const double e = 0.9;
  Row row(masses, e);
  row.model.set_velocity(row.x, row.balls[0], {1, 0, 0});
  std::vector<double> v{1, 0, 0};
  const auto strike = [&](std::size_t a) {  // Newton's law of two balls, written out
    const double m = masses[a], n = masses[a + 1], u = v[a] - v[a + 1], p = (1 + e) * u * m * n / (m + n);
    v[a] -= p / m;
    v[a + 1] += p / n;
  };
  int impacts = 0;
  for (; std::max(v[0] - v[1], v[1] - v[2]) > 1e-9; ++impacts) strike(v[0] - v[1] > v[1] - v[2] ? 0 : 1);
  const Impact impact = solve_impact(row.model, row.x, one_by_one);
  REQUIRE(impact.solved);
  CHECK(impact.stages == impacts);
  for (std::size_t i = 0; i < 3; ++i) CHECK(row.velocity(impact, i) == Approx(v[i]).margin(1e-9));
  const Impact together = solve_impact(row.model, row.x);
  CHECK(together.stages == 1);
  CHECK(std::abs(row.velocity(together, 0) - v[0]) > 0.01);
}

TEST_CASE("A ball that meets two at once is told to have no single order, and is struck by both alike",
          "[sequence]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const double s = std::sqrt(3.0) * radius;
  const Inertia solid = Inertia::solid_sphere(1, radius);
  const BodyId cue = model.add_body(solid), left = model.add_body(solid, {.pose = {.p = {s, radius, 0}}}),
               right = model.add_body(solid, {.pose = {.p = {s, -radius, 0}}});
  const Gap gap = sphere_on_sphere(radius, radius);
  model.add_contact(cue, left, gap, {.e = 1});
  model.add_contact(cue, right, gap, {.e = 1});
  State x = model.rest();
  model.set_velocity(x, cue, {1, 0, 0});
  const Impact impact = solve_impact(model, x, one_by_one);
  REQUIRE(impact.solved);
  CHECK(impact.ambiguous);
  x.nu = impact.nu;
  CHECK(model.velocity(x, left).y() == Approx(-model.velocity(x, right).y()).epsilon(1e-12));
  CHECK(model.velocity(x, left).x() == Approx(0.6).epsilon(1e-12));  // 2 sqrt(3)/5 along the line of centres
  CHECK(model.velocity(x, cue).x() == Approx(-0.2).epsilon(1e-12));

  State aside = model.rest();  // and where one is met faster there is one
  model.set_velocity(aside, cue, {1, 0.1, 0});
  CHECK_FALSE(solve_impact(model, aside, one_by_one).ambiguous);
}

TEST_CASE("A break of ten balls keeps momentum, and energy with e = 1", "[sequence]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const Inertia solid = Inertia::solid_sphere(0.17, radius);
  std::vector<BodyId> balls{model.add_body(solid, {.pose = {.p = {-2 * radius, 0, 0}}})};
  std::vector<Vector3> places{{-2 * radius, 0, 0}};
  for (int line = 0; line < 4; ++line)
    for (int i = 0; i <= line; ++i) {
      places.push_back({std::sqrt(3.0) * radius * line, radius * (2 * i - line), 0});
      balls.push_back(model.add_body(solid, {.pose = {.p = places.back()}}));
    }
  for (std::size_t i = 0; i < balls.size(); ++i)
    for (std::size_t j = i + 1; j < balls.size(); ++j)
      if ((places[i] - places[j]).norm() < 2.1 * radius)
        model.add_contact(balls[i], balls[j], sphere_on_sphere(radius, radius), {.e = 1});
  State x = model.rest();
  model.set_velocity(x, balls[0], {5, 0.3, 0});
  const double energy = model.kinetic_energy(x);
  const Vector3 momentum = model.momentum(x).linear;
  const Impact impact = solve_impact(model, x, one_by_one);
  REQUIRE(impact.solved);
  x.nu = impact.nu;
  CHECK(model.kinetic_energy(x) == Approx(energy).epsilon(1e-12));
  CHECK((model.momentum(x).linear - momentum).norm() < 1e-12);
  double slowest = infinity;  // nothing approaches any more
  for (const ImpactContact& c : impact.contacts) slowest = std::min(slowest, c.rebound);
  CHECK(impact.contacts.size() == 19);
  CHECK(slowest > -1e-9);
}

TEST_CASE("A box that lands flat has its four corners in one impact also in sequence", "[sequence]") {
  Model model;
  const BodyId box = model.add_body(Inertia::solid_box(1, {0.2, 0.2, 0.1}), {.pose = {.p = {0, 0, 0.05}}});
  model.add_contact(ground, box, box_on_plane({0.2, 0.2, 0.1}), {.mu = 0.4, .e = 0.5});
  State x = model.rest();
  model.set_velocity(x, box, {0.5, 0, -1}, {0.1, 0.3, 0});  // corners approach at different speeds
  const Impact one = solve_impact(model, x, one_by_one), all = solve_impact(model, x);
  REQUIRE(one.solved);
  CHECK(one.stages == 1);
  CHECK(one.contacts.size() == 4);
  CHECK((one.nu - all.nu).norm() < 1e-14);
  double friction = 0;
  for (const ImpactContact& c : one.contacts) friction += c.friction;
  CHECK(friction < -1e-3);
}

TEST_CASE("Newton's cradle swings ball by ball under event and extrapolated with impacts in sequence",
          "[sequence]") {
  Row row({1, 1, 1}, 1);
  State x = row.x;
  x.q[row.model.bodies()[static_cast<std::size_t>(row.balls[0].index)].q0] -=
      0.3;  // first ball 0.3 m before the others
  row.model.set_velocity(x, row.balls[0], {1, 0, 0});
  EventDriven event({.impacts = ImpactOrder::Sequential});
  Extrapolated extrapolated({.impacts = ImpactOrder::Sequential});
  for (AdaptiveStepper* stepper :
       {static_cast<AdaptiveStepper*>(&event), static_cast<AdaptiveStepper*>(&extrapolated)}) {
    if (stepper->name() == "event" && !has_sundials()) continue;
    const Trajectory run = simulate(row.model, *stepper, x, {.t_end = 0.5});
    const State end = run.back();
    CHECK(row.model.velocity(end, row.balls[0]).x() == Approx(0).margin(1e-9));
    CHECK(row.model.velocity(end, row.balls[1]).x() == Approx(0).margin(1e-9));
    CHECK(row.model.velocity(end, row.balls[2]).x() == Approx(1).epsilon(1e-9));
    CHECK(row.model.position(end, row.balls[2]).x() == Approx(4 * radius + 0.2).epsilon(1e-9));
    bool impact = false;
    for (const Event& e : run.events) impact = impact || (e.kind == EventKind::Impact && !e.ambiguous);
    CHECK(impact);
  }
}

}  // namespace perp
