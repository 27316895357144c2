// Systems in coordinates of their own: the order of every method, beside the same made of bodies and joints.
#include <catch2/catch.hpp>

#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "tests/order/ladder.hpp"
#include "tests/step/generalized_scenes.hpp"

namespace perp {
namespace {

/// Order at the scene's end against its exact motion, over T/80 ... T/1280.
double observed(const Scene& s, Stepper& stepper) {
  const std::vector<int> counts = ladder(80, 5);
  return order_of(counts, errors(s, stepper, s.t_end, s.exact(s.t_end), counts));
}

}  // namespace

TEST_CASE("in coordinates whose masses change the implicit steps have order 1, the second-order step 2",
          "[order][generalized]") {
  const Scene s = GENERATE(double_pendulum_of_angles(), slider_crank_of_one_angle());
  NcpStepper end, start({.directions = Directions::Start});
  Ncp2Stepper second;
  CAPTURE(s.name);
  CHECK(observed(s, end) == Approx(1).margin(0.1));
  CHECK(observed(s, start) == Approx(1).margin(0.1));
  CHECK(observed(s, second) == Approx(2).margin(0.1));
}

TEST_CASE("Newton knows how changing masses change the implicit step: three iterations a step at most",
          "[order][generalized]") {
  const Scene s = GENERATE(double_pendulum_of_angles(), slider_crank_of_one_angle());
  NcpStepper ncp;
  const double h = s.t_end / 80;
  State x = s.start;
  int most = 0;
  for (int i = 0; i < 80; ++i) {
    const StepReport report = ncp.step(s.model, x, h);
    REQUIRE(report.advanced());
    most = std::max(most, report.iterations);
  }
  CAPTURE(s.name);
  CHECK(most <= 3);
}

TEST_CASE("event reaches 1e-10 in coordinates whose masses change, with each integrator",
          "[order][generalized][event]") {
  if (!has_sundials()) return;
  const Scene s = GENERATE(double_pendulum_of_angles(), slider_crank_of_one_angle());
  const Integrator integrator = GENERATE(Integrator::Arkode, Integrator::CvodeAdams, Integrator::Ida);
  EventDriven stepper({.rtol = 1e-12, .integrator = integrator});
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = s.t_end});
  CAPTURE(s.name, name_of(integrator));
  const double allowed = integrator == Integrator::Arkode ? 1e-10 : 2e-9;
  CHECK(distance(s.model, run.back(), s.exact(s.t_end)) < allowed);
  for (const double part : {0.31, 0.77}) {
    const double t = part * s.t_end;
    CHECK(distance(s.model, run.at(t), s.exact(t)) < allowed);
  }
}

}  // namespace perp
