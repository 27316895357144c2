// The compared other: what it tends to, and what it never does.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/error_measure.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

State end_of(const Scene& s, const PenaltyOptions& options, double T, double h) {
  PenaltyStepper penalty(options);
  return simulate(s.model, penalty, s.start, {.t_end = T, .h = h}).back();
}

}  // namespace

TEST_CASE("penalty tends to the rigid motion as stiffness grows and slip speed falls, implicit and explicit",
          "[penalty]") {
  const Scene s = scene("oblique-sphere");
  const State right = s.exact(1);
  for (const bool explicit_forces : {false, true}) {
    double before = 0;
    for (const double k : {1e3, 1e4, 1e5}) {
      const double error = configuration_error(
          s.model,
          end_of(s, {.stiffness = k, .slip_speed = 1e2 / k, .explicit_forces = explicit_forces}, 1, 2e-5),
          right);
      CAPTURE(explicit_forces, k, error, before);
      if (before > 0) {
        CHECK(before / error > 5);
        CHECK(before / error < 20);
      }
      before = error;
    }
    CHECK(before < 1e-3);
  }
}

TEST_CASE("penalty at rest sinks by m g/k, and on a slope that holds it creeps at the slip speed's share",
          "[penalty]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(2, 0.5));
  model.add_contact(ground, ball, sphere_on_plane(0.5), {.mu = 0.3, .name = "floor"});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 0.5});
  PenaltyStepper penalty({.stiffness = 5e3});
  const Trajectory rests = simulate(model, penalty, x, {.t_end = 2, .h = 1e-3});
  CHECK(model.position(rests.back(), ball).z() == Approx(0.5 - 2 * 9.81 / 5e3).epsilon(1e-9));
  const StepReport last = rests.report(rests.steps() - 1);
  CHECK(last.contact("floor").p_n == Approx(2 * 9.81 * 1e-3));
  CHECK(last.residuals.newton_euler < 1e-12);
  CHECK(last.residuals.normal < 1e-10);

  const double theta = M_PI / 6, mu = 0.8, v = 1e-3;
  const Scene block = scene("incline-block", {{"mu", mu}});
  const double moved =
      configuration_error(block.model, end_of(block, {.stiffness = 1e6, .slip_speed = v}, 1, 1e-3),
                          end_of(block, {.stiffness = 1e6, .slip_speed = v}, 2, 1e-3));
  const double along = v * std::tan(theta) / mu;  // |F| = m g sin = mu N u/v
  CHECK(moved <= 1.001 * along);
  CHECK(moved >= 0.8 * along);  // its largest component
}

TEST_CASE("the default penalty converges with order 1 where contacts last", "[penalty]") {
  for (const char* name : {"seed-sphere", "friction-pendulum", "slider-crank"}) {
    const Scene s = scene(name);
    const State right = s.exact(s.t_end);
    std::vector<double> errors;
    for (const int n : {200, 400, 800, 1600, 3200})
      errors.push_back(configuration_error(s.model, end_of(s, {}, s.t_end, s.t_end / n), right));
    CAPTURE(name, errors.front(), errors.back());
    const double order = std::log2(errors.front() / errors.back()) / 4;
    CHECK(order > 0.85);
    CHECK(order < 1.2);
  }
}

TEST_CASE("penalty refuses what it cannot follow or take", "[penalty]") {
  const Scene s = scene("seed-sphere");
  State x = s.start;
  x.q[2] -= 1e-3;
  PenaltyStepper stiff({.stiffness = 1e9, .explicit_forces = true});
  const StepReport report = stiff.step(s.model, x, 1e-3);
  CHECK(report.status == StepStatus::NotSolved);
  CHECK(report.message.find("cannot follow the contact") != std::string::npos);
  CHECK(report.message.find("1e+09 N/m") != std::string::npos);
  CHECK_THROWS_WITH(PenaltyStepper({.stiffness = -1}),
                    Catch::Contains("stiffness is -1, needs to be positive"));
  CHECK_THROWS_WITH(PenaltyStepper({.damping = -1}), Catch::Contains("damping is -1"));
  CHECK_THROWS_WITH(PenaltyStepper({.slip_speed = 0}), Catch::Contains("slip_speed is 0"));
  MethodOptions options;
  CHECK_THROWS_WITH(options.set("lcp", "stiffness", 1), Catch::Contains("needs the method penalty"));
  CHECK_THROWS_WITH(options.set("penalty", "colour", 1),
                    Catch::Contains("stiffness, damping, slip_speed or explicit"));
  CHECK_THROWS_WITH(options.set("penalty", "explicit", 2), Catch::Contains("0 or 1"));
  options.set("penalty", "damping", 3);
  CHECK(options.penalty.damping == 3);
}

}  // namespace perp
