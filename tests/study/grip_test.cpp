// What a gripper holds stays: friction that creeps shows here.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

/// How far the capsule has gone [m].
double drift(const char* method, double squeeze, double T, double h) {
  const Scene s = scene("grip", {{"squeeze", squeeze}});
  const auto stepper = make_stepper(method, {.tolerance = 1e-10});
  SimulateOptions options{.t_end = T};
  if (!chooses_steps(*stepper)) options.h = h;
  const BodyId capsule = s.model.find_body("capsule");
  const State end = simulate(s.model, *stepper, s.start, options).back();
  return (s.model.position(end, capsule) - s.model.position(s.start, capsule)).norm();
}

constexpr double limit = 0.045 * 9.81 / 1.4;  // [N]: 2 mu squeeze = m g

}  // namespace

TEST_CASE("grip: a capsule between pads stays where it is, from 60 N down to a millionth above the limit",
          "[grip]") {
  for (const char* method : {"ncp", "ncp2", "event"}) {
    if (method == std::string("event") && !has_sundials()) continue;
    for (const double squeeze : {60.0, 12.0, limit * (1 + 1e-6)}) {
      CAPTURE(method, squeeze);
      CHECK(drift(method, squeeze, 2, 0.01) < 1e-12);
    }
  }
}

TEST_CASE("grip: a hundredth below the limit the capsule slides down as mechanics says", "[grip]") {
  const double squeeze = 0.99 * limit, T = 0.5;
  const double fall = 0.01 * 9.81 * T * T / 2;  // g - 2 mu squeeze/m
  CHECK(drift("ncp2", squeeze, T, 1e-3) == Approx(fall).epsilon(1e-3));
  CHECK(scene("grip").exact);
  CHECK_FALSE(scene("grip", {{"squeeze", squeeze}}).exact);
}

TEST_CASE("grip: nothing creeps in a thousand seconds", "[grip][slow]") {
  for (const char* method : {"ncp", "ncp2", "event"}) {
    if (method == std::string("event") && !has_sundials()) continue;
    for (const double squeeze : {12.0, limit * (1 + 1e-6)}) {
      CAPTURE(method, squeeze);
      CHECK(drift(method, squeeze, 1000, 0.01) <
            (method == std::string("ncp2") ? 1e-12 : 1e-10));  // rounding adds up
    }
  }
}

}  // namespace perp
