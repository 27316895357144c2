// The LCP step's orders of convergence on motions that are known, and the floor that its polygon sets.
#include <catch2/catch.hpp>

#include "perp/step/lcp_stepper.hpp"
#include "tests/order/ladder.hpp"

namespace perp {
namespace {

/// Order of the configuration at T (the scene's own if not set) against its exact motion.
double observed(const char* name, const SceneParameters& set = {}, double T = not_set,
                const LcpStepperOptions& options = {}) {
  const Scene s = scene(name, set);
  if (std::isnan(T)) T = s.t_end;
  LcpStepper lcp(options);
  return order_of(ladder(), errors(s, lcp, T, s.exact(T), ladder()));
}

/// What a polygonal step converges to: Richardson's extrapolation of positions, first order in h.
State limit(const Scene& s, Stepper& stepper, double T, int n) {
  const State coarse = run(s, stepper, T, n);
  State fine = run(s, stepper, T, 2 * n);
  for (const Body& body : s.model.bodies())
    if (body.nv > 0) fine.q.segment<3>(body.q0) += fine.q.segment<3>(body.q0) - coarse.q.segment<3>(body.q0);
  return fine;
}

auto order(double p) { return Approx(p).margin(0.1); }

}  // namespace

TEST_CASE("the LCP step has order 1 on a sphere that slides and rolls, and on a turntable", "[order]") {
  CHECK(observed("seed-sphere") == order(1));
  CHECK(observed("turntable") == order(1));
}

TEST_CASE("the LCP step has order 1 on a slope, downhill and thrown uphill and back", "[order]") {
  CHECK(observed("incline-block") == order(1));
  CHECK(observed("incline-block", {{"v0", -2}}) == order(1));
}

TEST_CASE("the LCP step has order 1 where a roller or a ball rolls on a curved wall", "[order]") {
  CHECK(observed("roller-in-cylinder") == order(1));
  CHECK(observed("ball-on-sphere") == order(1));
  CHECK(observed("bowl") == order(1));
}

TEST_CASE("the LCP step has order 1 on a pendulum with joint friction", "[order]") {
  CHECK(observed("friction-pendulum") == order(1));
}

TEST_CASE("the angle at which a pendulum sticks at last converges with order 1 or better", "[order]") {
  CHECK(observed("friction-pendulum", {}, 12) > 0.9);
}

TEST_CASE("the LCP step has order 1 on a spring, a free body and a double pendulum", "[order]") {
  CHECK(observed("spring-block") == order(1));
  CHECK(observed("dzhanibekov") == order(1));
  CHECK(observed("double-pendulum") == order(1));
}

TEST_CASE("the LCP step has order 1 across impacts, with and without a collision", "[order]") {
  CHECK(observed("three-balls") == order(1));
  CHECK(observed("bouncing-ball") == order(1));
  CHECK(observed("painleve-rod") == order(1));
}

TEST_CASE("the LCP step has order 2 in the place of a particle on a shaken plate", "[order]") {
  // gap rows at the start of the step put its velocity half a step ahead, which its flight makes up for
  CHECK(observed("shaker") == order(2));
  CHECK(observed("shaker", {}, 1) == order(2));
}

TEST_CASE("on a circular wall the LCP step has order 2, and without the gap term order 1", "[order]") {
  CHECK(observed("bead-in-ring") == order(2));
  CHECK(observed("bead-in-ring", {}, 1, {.anitescu_potra = true}) == order(1));
}

TEST_CASE("the LCP step has order 1 against its own polygon's limit where friction turns", "[order]") {
  const auto [name, set] = GENERATE(table<const char*, SceneParameters>(
      {{"oblique-sphere", {}}, {"oblique-sphere", {{"heading", 1}}}, {"cross-incline", {{"k", 1}}}}));
  const int edges = GENERATE(4, 8, 16);
  const Scene s = scene(name, set);
  LcpStepper lcp({.edges = edges});
  const State reference = limit(s, lcp, s.t_end, 16 * ladder().back());
  std::vector<double> list;
  for (const int n : ladder())
    list.push_back((run(s, lcp, s.t_end, n).q - reference.q).head<3>().lpNorm<Eigen::Infinity>());
  CAPTURE(name, edges);
  CHECK(order_of(ladder(), list) == order(1));
}

namespace {

/// |position - exact| of the oblique sphere at t = 2 as h goes to 0.
double floor_of(int edges) {
  const Scene s = scene("oblique-sphere");
  LcpStepper lcp({.edges = edges});
  return (limit(s, lcp, 2, 20000).q - s.exact(2).q).head<3>().norm();
}

}  // namespace

TEST_CASE("the friction polygon's error does not fall with the step: that of a sphere that turns",
          "[order]") {
  CHECK(floor_of(4) == Approx(0.229822).margin(2e-6));
  CHECK(floor_of(8) == Approx(0.0613122).margin(2e-6));
}

TEST_CASE("the friction polygon's error falls unevenly with the number of its edges", "[order][slow]") {
  CHECK(floor_of(6) == Approx(0.100618).margin(2e-6));
  CHECK(floor_of(12) == Approx(0.0295192).margin(2e-6));
  CHECK(floor_of(16) == Approx(0.0289188).margin(2e-6));
  CHECK(floor_of(32) == Approx(0.0125835).margin(2e-6));
  CHECK(floor_of(64) == Approx(0.00758886).margin(2e-6));
}

}  // namespace perp
