#include "perp/step/ncp_stepper.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "perp/step/simulate.hpp"
#include "tests/step/newton_cases.hpp"

using namespace perp;
using namespace perp::testing;

namespace {

template <class Method>
void converges_fast(Start start, bool rod, double h, unsigned seed) {
  std::mt19937 random(seed);
  const NewtonCase c = rod ? rod_case(start, 0.3, random) : ellipsoid_case(start, 0.3, random);
  Method method;
  State x = c.x;
  std::vector<int> iterations;
  int stand_ins = 0;
  for (int k = 0; k < 12; ++k) {
    const StepReport report = method.step(c.model, x, h);
    CAPTURE(c.name, static_cast<int>(start), h, k, report.message);
    REQUIRE(report.advanced());
    stand_ins += report.solver == "newton" || report.contacts.empty() ? 0 : 1;
    CHECK(report.gap_min > -1e-12);
    const std::vector<double>& e = method.history().residuals;
    if (e.size() < 2) continue;
    iterations.push_back(static_cast<int>(e.size()) - 1);
    // quadratic at the end: the last residual is far below the one before, unless that was at rounding
    const double before = e[e.size() - 2];
    if (before < 1e-4 && before > 1e-9) CHECK(e.back() < 1e-2 * before);
  }
  CHECK(stand_ins <= 1);
  std::sort(iterations.begin(), iterations.end());
  if (!iterations.empty() && h < 0.05) CHECK(iterations[iterations.size() / 2] <= 4);
}

Model falling_ball(double e, double mu, BodyId& ball) {
  Model model;
  ball = model.add_body(Inertia::solid_sphere(2, 0.5), {.pose = {{0, 0, 0.5}, Quaternion::Identity()}});
  model.add_contact(ground, ball, sphere_on_plane(0.5), {.mu = mu, .e = e, .name = "floor"});
  return model;
}

}  // namespace

TEST_CASE("Newton converges quadratically on curved gaps from rest, slip, impact and spin", "[ncp_stepper]") {
  const Start start = GENERATE(Start::Rest, Start::Sliding, Start::Impact, Start::Spin);
  const double h = GENERATE(1e-4, 1e-3, 1e-2, 5e-2);
  const bool rod = GENERATE(false, true);
  converges_fast<NcpStepper>(start, rod, h, 7);
  converges_fast<Ncp2Stepper>(start, rod, h, 7);
}

TEST_CASE("an implicit step leaves an impact at e times the approach speed, its position that of e = 0",
          "[ncp_stepper]") {
  BodyId ball;
  const Model model = falling_ball(0.5, 0, ball);
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 0.51});
  model.set_velocity(x, ball, {0, 0, -3});
  for (const std::string name : {"ncp", "ncp2"}) {
    State y = x;
    StepReport report;
    if (name == "ncp") report = NcpStepper().step(model, y, 0.01);
    if (name == "ncp2") report = Ncp2Stepper().step(model, y, 0.01);
    CAPTURE(name);
    REQUIRE(report.advanced());
    CHECK(model.velocity(y, ball).z() == Approx(1.5).epsilon(1e-12));
    CHECK(std::abs(model.position(y, ball).z() - 0.5) < 1e-14);
    CHECK(report.contact("floor").p_n == Approx(2 * (1.5 + 3 + 9.81 * 0.01)).epsilon(1e-12));
  }
}

TEST_CASE("friction of an implicit step opposes the slip on the circular cone, whatever its heading",
          "[ncp_stepper]") {
  BodyId ball;
  const Model model = falling_ball(0, 0.3, ball);
  for (int k = 0; k < 16; ++k) {
    const double heading = 0.4 * k;
    State x = model.rest();
    const Vector3 d(std::cos(heading), std::sin(heading), 0);
    model.set_velocity(x, ball, 2 * d);
    NcpStepper ncp;
    const StepReport report = ncp.step(model, x, 0.01);
    REQUIRE(report.advanced());
    const ContactRow row = report.contact("floor");
    CHECK(row.mode == ContactMode::Slip);
    CHECK((row.impulse - Vector3(0, 0, 2 * 9.81 * 0.01) + 0.3 * 2 * 9.81 * 0.01 * d).norm() < 1e-3);
    CHECK(row.impulse.head<2>().norm() == Approx(0.3 * row.p_n).epsilon(1e-12));
  }
}

TEST_CASE("free rotation by ncp2 keeps the angular momentum to rounding, and ncp keeps it bounded",
          "[ncp_stepper]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId body = model.add_body(Inertia::principal(1, {1e-4, 2e-4, 2.9e-4}));
  State x = model.rest();
  model.set_velocity(x, body, Vector3::Zero(), {100, 200, -50});
  const Vector3 L = model.momentum(x).angular;
  Ncp2Stepper two;
  const State end = simulate(model, two, x, {.t_end = 0.5, .h = 1e-3}).back();
  CHECK((model.momentum(end).angular - L).norm() < 1e-12 * L.norm());
  // turns of 10 and of 100 rad a step: no accuracy is left, but no momentum is lost
  model.set_velocity(x, body, Vector3::Zero(), 1e4 * Vector3(1, 2, 3).normalized());
  const Vector3 large = model.momentum(x).angular;
  for (const double h : {1e-3, 1e-2}) {
    const Trajectory run = simulate(model, two, x, {.t_end = 50 * h, .h = h});
    CHECK((model.momentum(run.back()).angular - large).norm() < 1e-12 * large.norm());
  }
  model.set_velocity(x, body, Vector3::Zero(), {100, 200, -50});
  NcpStepper one;
  const State damped = simulate(model, one, x, {.t_end = 0.05, .h = 1e-4}).back();
  CHECK(model.momentum(damped).angular.norm() < L.norm() * (1 + 1e-9));
  CHECK(model.momentum(damped).angular.norm() > 0.5 * L.norm());
}

TEST_CASE("an overlap at the start goes at the capped speed", "[ncp_stepper]") {
  BodyId ball;
  const Model model = falling_ball(0, 0.3, ball);
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 0.4});
  NcpStepper ncp;
  StepReport report;
  State y = x;
  ncp.step(model, y, {.h = 0.01, .max_correction_speed = 0.5}, report);
  REQUIRE(report.advanced());
  CHECK(model.position(y, ball).z() == Approx(0.405).epsilon(1e-12));
  y = x;
  ncp.step(model, y, {.h = 0.01}, report);
  CHECK(model.position(y, ball).z() == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("a contact that only another impact closes is found within the step", "[ncp_stepper]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const auto ball = [&](double x) {
    return model.add_body(Inertia::solid_sphere(1, 0.5), {.pose = {{x, 0, 0}, Quaternion::Identity()}});
  };
  const BodyId first = ball(0), second = ball(1.001);
  model.add_contact(first, second, sphere_on_sphere(0.5, 0.5), {.name = "balls"});
  model.add_contact(ground, second, sphere_on_plane(0.5, {{-1, 0, 0}, {1.502, 0, 0}}), {.name = "wall"});
  State x = model.rest();
  model.set_velocity(x, first, {1, 0, 0});
  Ncp2Stepper ncp2;
  const StepReport report = ncp2.step(model, x, 0.01);
  REQUIRE(report.advanced());
  CHECK(report.gap_min > -1e-14);
  CHECK(report.contact("wall").p_n > 0);
}

TEST_CASE("joints hold at position level through a swing that linearised joints leave", "[ncp_stepper]") {
  Model model;
  const BodyId bob =
      model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {{1, 0, 0}, Quaternion::Identity()}});
  model.add_joint(revolute(ground, bob, {.axis = {0, 1, 0}, .name = "hinge"}));
  for (const int method : {1, 2}) {
    NcpStepper one;
    Ncp2Stepper two;
    Stepper& stepper = method == 1 ? static_cast<Stepper&>(one) : two;
    const Trajectory run = simulate(model, stepper, model.rest(), {.t_end = 1, .h = 0.02});
    for (std::size_t k = 0; k < run.steps(); ++k) CHECK(run.figures(k).joint_error < 1e-14);
    const double lost = model.energy(run.front()) - model.energy(run.back());
    CHECK(std::abs(lost) < (method == 1 ? 4.0 : 5e-2));  // of 9.81 J, by a step of a fiftieth
  }
}
