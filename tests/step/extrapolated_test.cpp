// The extrapolated step: rows and events, through switches and impacts, by steps of fixed size and to a tolerance.
#include "perp/step/extrapolated.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/error_measure.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

struct Ran {
  Scene scene;
  Trajectory rows;
  double error = not_set;  ///< of the configuration at the end
};

Ran ran(const char* name, const SceneParameters& set, double T, const ExtrapolatedOptions& options) {
  Ran r{.scene = scene(name, set), .rows = {}};
  Extrapolated stepper(options);
  r.rows = simulate(r.scene.model, stepper, r.scene.start, {.t_end = T});
  if (r.scene.exact) r.error = configuration_error(r.scene.model, r.rows.back(), r.scene.exact(T));
  return r;
}

constexpr ExtrapolatedOptions tight{.rtol = 1e-11};

std::vector<double> times(const Trajectory& rows, EventKind kind) {
  std::vector<double> t;
  for (const Event& e : rows.events)
    if (e.kind == kind) t.push_back(e.t);
  return t;
}

}  // namespace

TEST_CASE("extrapolated finds where a sphere begins to roll to rounding, and goes on from there",
          "[extrapolated]") {
  const Ran r = ran("seed-sphere", {}, 0.6, tight);
  CHECK(r.error < 1e-13);
  REQUIRE(r.rows.events.size() == 1);
  CHECK(r.rows.events[0].kind == EventKind::Stick);
  CHECK(std::abs(r.rows.events[0].t - 0.291247997670016019) < 1e-14);
}

TEST_CASE("extrapolated stops a block that slides across a slope where it comes to rest", "[extrapolated]") {
  const Ran r = ran("cross-incline", {{"k", 1.5}}, 0.6, tight);
  CHECK(r.error < 1e-9);
  REQUIRE(times(r.rows, EventKind::Stick).size() == 1);
  CHECK(std::abs(times(r.rows, EventKind::Stick)[0] - 0.489296636085626911) < 1e-9);
}

TEST_CASE("extrapolated lifts off and lands with a shaken plate over ten periods", "[extrapolated]") {
  constexpr double period = 2 * 3.14159265358979324 / 12;
  const Ran r = ran("shaker", {}, 10 * period + 0.2, tight);
  const std::vector<double> lifts = times(r.rows, EventKind::Lift), lands = times(r.rows, EventKind::Impact);
  REQUIRE(lifts.size() == 11);
  REQUIRE(lands.size() == 10);
  for (std::size_t k = 0; k < lifts.size(); ++k)
    CHECK(std::abs(lifts[k] - 0.0624557343869608896 - static_cast<double>(k) * period) < 1e-9);
  for (std::size_t k = 0; k < lands.size(); ++k)
    CHECK(std::abs(lands[k] - 0.351693536744083536 - static_cast<double>(k) * period) < 1e-9);
}

TEST_CASE("extrapolated lets a ball slip on a sphere and leave it", "[extrapolated]") {
  const Ran r = ran("ball-on-sphere", {}, 1.3, tight);
  REQUIRE(r.rows.events.size() == 2);
  CHECK(r.rows.events[0].kind == EventKind::Slip);
  CHECK(r.rows.events[1].kind == EventKind::Lift);
  CHECK(std::abs(r.rows.events[0].t - 1.16953241866) < 1e-9);
  CHECK(std::abs(r.rows.events[1].t - 1.21841190252) < 1e-9);
}

TEST_CASE("extrapolated turns a pendulum with dry friction eleven times and stops it", "[extrapolated]") {
  const Ran r = ran("friction-pendulum", {}, 12, tight);
  CHECK(r.error < 1e-9);
  const std::vector<double> turns = {1.09175148829423, 2.16402878121614, 3.22031877399045, 4.26345249925988,
                                     5.29579763390132, 6.31938732151865, 7.33601038924429, 8.34727727028209,
                                     9.35467026893212, 10.3595836662653};
  CHECK(times(r.rows, EventKind::Reverse).size() == turns.size());
  for (std::size_t k = 0; k < std::min(turns.size(), times(r.rows, EventKind::Reverse).size()); ++k)
    CHECK(std::abs(times(r.rows, EventKind::Reverse)[k] - turns[k]) < 1e-9);
  REQUIRE(times(r.rows, EventKind::Stick).size() == 1);
  CHECK(std::abs(times(r.rows, EventKind::Stick)[0] - 11.3633573740884) < 1e-9);
}

TEST_CASE("extrapolated stops sliders and cranks where their friction says", "[extrapolated]") {
  const Ran block = ran("spring-block", {}, 4, tight);
  CHECK(block.error < 1e-9);
  REQUIRE(times(block.rows, EventKind::Stick).size() == 1);
  CHECK(std::abs(times(block.rows, EventKind::Stick)[0] - 3.769911184307752) < 1e-9);
  const Ran crank = ran("slider-crank", {}, 1.3, tight);
  CHECK(crank.error < 1e-9);
  REQUIRE(times(crank.rows, EventKind::Stick).size() == 1);
  CHECK(std::abs(times(crank.rows, EventKind::Stick)[0] - 1.18674812085396) < 1e-9);
}

TEST_CASE("extrapolated rocks a block from corner to corner", "[extrapolated]") {
  const Ran r = ran("rocking-block", {}, 0.6, tight);
  CHECK(r.error < 1e-9);
  REQUIRE(!r.rows.events.empty());
  CHECK(std::abs(r.rows.events[0].t - 0.4938032150788319) < 1e-9);
}

TEST_CASE("extrapolated comes past ten Zeno times of a bouncing ball", "[extrapolated]") {
  constexpr double zeno = 0.451523640985730904 * 3;  // e = 1/2
  const Ran r = ran("bouncing-ball", {{"e", 0.5}}, 10 * zeno, {});
  CHECK(r.rows.steps() < 300);
  CHECK(times(r.rows, EventKind::Zeno).size() == 1);
  CHECK(std::abs(r.rows.back().t - 10 * zeno) < 1e-12);
  CHECK(r.rows.back().nu.norm() < 1e-12);
}

TEST_CASE("The woodpecker pecks as event lets it peck, over ten cycles", "[extrapolated][event]") {
  if (!has_sundials()) return;
  const Scene s = scene("woodpecker");
  EventDriven event({.rtol = 1e-12});
  const Trajectory reference = simulate(s.model, event, s.start, {.t_end = 1.46});
  const Ran r = ran("woodpecker", {}, 1.46, tight);
  const std::vector<double> want = times(reference, EventKind::Impact),
                            got = times(r.rows, EventKind::Impact);
  REQUIRE(got.size() == want.size());
  for (std::size_t k = 0; k < got.size(); ++k) CHECK(std::abs(got[k] - want[k]) < 1e-9);
  CHECK(configuration_error(s.model, r.rows.back(), reference.back()) < 1e-9);
}

TEST_CASE("Rows of extrapolated say the impulses and works of their steps, and hold their equations",
          "[extrapolated]") {
  const char* name =
      GENERATE("rolling-ellipse", "bowl", "double-pendulum", "turntable", "slider-crank", "woodpecker");
  const Ran r = ran(name, {}, 0.3, {});
  CAPTURE(name);
  for (std::size_t i = 0; i < r.rows.steps(); ++i) {
    const StepReport row = r.rows.report(i);
    CHECK(row.residuals.newton_euler < 1e-8);
    CHECK(row.residuals.kinematic < 1e-8);
    CHECK(std::abs(row.energy_left) < 1e-8);
    CHECK(row.residuals.joints < 1e-8);
  }
}

TEST_CASE("The impulses that extrapolated reports carry a sliding sphere's weight and slow it down",
          "[extrapolated]") {
  const Ran r = ran("seed-sphere", {}, 0.6, {});
  double carried = 0, stopped = 0;
  for (std::size_t i = 0; i < r.rows.steps(); ++i)
    for (const ContactRow& c : r.rows.report(i).contacts) {
      carried += c.p_n;
      stopped += c.impulse.x();
    }
  CHECK(carried == Approx(9.81 * 0.6).epsilon(1e-12));
  CHECK(stopped == Approx(10.0 / 7 - 2).epsilon(1e-12));
}

TEST_CASE("extrapolated of fixed order takes the steps that it is asked for, and cuts them at events",
          "[extrapolated]") {
  const Scene s = scene("seed-sphere");
  Extrapolated stepper({.order = 4});
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 0.6, .h = 0.1});
  REQUIRE(run.events.size() == 1);
  CHECK(run.steps() == 8);  // six, one of them in two, and the row after the event
  std::vector<double> t;
  for (std::size_t i = 0; i < run.size(); ++i) t.push_back(run.t(i));
  for (int k = 0; k <= 6; ++k)
    CHECK(std::any_of(t.begin(), t.end(), [&](double at) { return std::abs(at - 0.1 * k) < 1e-15; }));
  CHECK_THROWS_AS(simulate(s.model, stepper, s.start, {.t_end = 0.6}), std::invalid_argument);
}

TEST_CASE("A single step of extrapolated leads through an event within it", "[extrapolated]") {
  const Scene s = scene("seed-sphere");
  for (const int order : {0, 4, 8}) {
    Extrapolated stepper({.order = order});
    State x = s.start;
    const StepReport report = stepper.step(s.model, x, 0.6);
    REQUIRE(report.advanced());
    CHECK(configuration_error(s.model, x, s.exact(0.6)) < 1e-12);
    CHECK(report.contacts.at(0).p_n == Approx(9.81 * 0.6).epsilon(1e-12));
  }
}

TEST_CASE("Trajectory::at of extrapolated integrates from the row before", "[extrapolated]") {
  const Ran r = ran("rolling-ellipse", {}, 0.5, tight);
  for (const double t : {0.011, 0.123, 0.3, 0.499})
    CHECK(configuration_error(r.scene.model, r.rows.at(t), r.scene.exact(t)) < 1e-10);
}

TEST_CASE("extrapolated refuses orders and tolerances that it cannot have", "[extrapolated]") {
  CHECK_THROWS_AS(Extrapolated({.order = 3}), std::invalid_argument);
  CHECK_THROWS_AS(Extrapolated({.order = -2}), std::invalid_argument);
  CHECK_THROWS_AS(Extrapolated({.order = 18}), std::invalid_argument);
  CHECK_THROWS_AS(Extrapolated({.rtol = 0}), std::invalid_argument);
  CHECK_NOTHROW(Extrapolated({.order = 16}));
  CHECK(method("extrapolated").adaptive);
}

}  // namespace perp
