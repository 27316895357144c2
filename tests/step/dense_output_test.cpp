// States between the rows of a run.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"
#include "step/run/dense_output.hpp"

namespace perp {
namespace {

double order(double coarse, double fine) { return std::log2(coarse / fine); }

}  // namespace

TEST_CASE("Cubics between states of one motion are of order 4 in position and 3 in velocity",
          "[dense_output]") {
  if (!has_sundials()) return;
  const Scene s = scene(GENERATE("dzhanibekov", "double-pendulum", "heavy-top"));
  EventDriven exact({.rtol = 1e-13});
  const Trajectory motion = simulate(s.model, exact, s.start, {.t_end = 0.8});
  double error_q[2] = {}, error_nu[2] = {};
  for (const int k : {0, 1}) {
    const int n = (s.name == "heavy-top" ? 160 : 20) << k;
    Trajectory rows(motion.at(0.3), 1);
    for (int i = 1; i <= n; ++i) rows.add(motion.at(0.3 + 0.4 * i / n), {});
    rows.between = cubics(s.model);
    for (int i = 0; i < n; ++i)
      for (const double share : {0.2, 0.5, 0.7}) {
        const double t = 0.3 + 0.4 * (i + share) / n;
        const State x = rows.at(t), right = motion.at(t);
        CHECK(x.t == t);
        error_q[k] = std::max(error_q[k], (x.q - right.q).norm());
        error_nu[k] = std::max(error_nu[k], (x.nu - right.nu).norm());
      }
  }
  CAPTURE(s.name, error_q[0], error_q[1], error_nu[0], error_nu[1]);
  CHECK(order(error_q[0], error_q[1]) > 3.8);
  CHECK(order(error_q[0], error_q[1]) < 4.2);
  CHECK(order(error_nu[0], error_nu[1]) > 2.8);
  CHECK(order(error_nu[0], error_nu[1]) < 3.2);
}

TEST_CASE("At any time a run of fixed steps is as near to the motion as its method's order says",
          "[dense_output]") {
  const Scene s = scene("heavy-top");
  for (const auto& [method, right] : {std::pair("ncp2", 2.0), std::pair("ncp", 1.0)}) {
    const auto error_of = [&](double h) {
      const auto stepper = make_stepper(method);
      const Trajectory run = simulate(s.model, *stepper, s.start, {.t_end = 0.4, .h = h});
      double error = 0;
      for (double t = 0.0137; t < 0.4; t += 0.0231)
        error = std::max(error, (run.at(t).q - s.exact(t).q).norm());
      return error;
    };
    const double found = order(error_of(4e-3), error_of(2e-3));
    CAPTURE(method, found);
    CHECK(found > right - 0.25);
    CHECK(found < right + 0.25);
  }
}

TEST_CASE("Where a run jumps it is after the jump, and just before it is before", "[dense_output]") {
  if (!has_sundials()) return;
  const Scene s = scene("bouncing-ball");
  EventDriven stepper;
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = s.t_end});
  const auto impact = std::find_if(run.events.begin(), run.events.end(),
                                   [](const Event& e) { return e.kind == EventKind::Impact; });
  REQUIRE(impact != run.events.end());
  const double after = run.at(impact->t).nu[2], before = run.at(std::nextafter(impact->t, 0)).nu[2];
  CHECK(after > 0);
  CHECK(before < 0);
  CHECK_THROWS_AS(run.at(s.t_end + 1), std::invalid_argument);
  CHECK_THROWS_AS(run.at(-1), std::invalid_argument);
}

TEST_CASE("Rows that nobody says how to go between have no states between them", "[dense_output]") {
  const Scene s = scene("bouncing-ball");
  Trajectory run(s.start, 1);
  State x = s.start;
  x.t = 1;
  run.add(x, {});
  CHECK(run.at(1).t == 1);
  CHECK_THROWS_WITH(run.at(0.5), Catch::Contains("rows alone"));
}

}  // namespace perp
