// Closed loops whose joints repeat each other, for long: a spatial four-bar, a parallelogram that passes its change point,
// Bennett's loop, a door on two hinges. They stay closed, and lose or gain energy as the order of the method has it.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "perp/instant/reduced_system.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

using namespace perp;

namespace {

/// A door on two hinges in line, their axis off the vertical so that it swings.
Scene door() {
  Scene s;
  const Vector3 axis = Vector3(0.2, 0, 1).normalized();
  const BodyId leaf =
      s.model.add_body(Inertia::solid_box(20, {0.8, 0.04, 2}), {.pose = {.p = {0.4, 0, 0}}, .name = "leaf"});
  for (const double at : {-0.6, 0.6})
    s.model.add_joint(revolute(ground, leaf, {.point = at * axis, .axis = axis}));
  s.start = s.model.rest();
  s.model.set_velocity(s.start, leaf, (2 * axis).cross(Vector3(0.4, 0, 0)), 2 * axis);
  return s;
}

Scene loop(const std::string& name) { return name == "door" ? door() : scene(name); }

struct Loop {
  double joint_error = 0, energy_error = 0;  ///< largest |E - E_0|
};

Loop observe(const Scene& s, const std::string& method, double t_end, double h) {
  const std::unique_ptr<Stepper> stepper = make_stepper(method, {});
  Loop loop;
  const double before = s.model.energy(s.start);
  const auto look = [&](const StepFigures& f) {
    loop.joint_error = std::max(loop.joint_error, f.joint_error);
    loop.energy_error = std::max(loop.energy_error, std::abs(f.energy - before));
  };
  if (chooses_steps(*stepper)) {
    const Trajectory run = simulate(s.model, *stepper, s.start, {.t_end = t_end});
    for (std::size_t i = 0; i < run.steps(); ++i) look(run.figures(i));
    return loop;
  }
  State x = s.start;
  StepReport report;
  const int n = static_cast<int>(std::lround(t_end / h));
  for (int i = 1; i <= n; ++i) {
    stepper->step(s.model, x, {.h = h, .t_end = i * h}, report);
    INFO(method << " at t = " << x.t << ": " << report.message);
    REQUIRE(report.advanced());
    look(report);
  }
  return loop;
}

}  // namespace

TEST_CASE("loops have more joint equations than they need", "[joint]") {
  for (const auto& [name, rows, rank] : {std::tuple("four-bar", 20, 17), std::tuple("parallelogram", 20, 17),
                                         std::tuple("bennett", 20, 17), std::tuple("door", 10, 5)}) {
    const Scene s = loop(name);
    Instant now;
    evaluate(s.model, s.start, now);
    CAPTURE(name);
    CHECK(static_cast<int>(now.joint_rows.size()) == rows);
    CHECK(joint_rank(s.model, now) == rank);
  }
}

TEST_CASE("a loop's energy error is of the order of lcp and of ncp2", "[joint]") {
  const std::string name = GENERATE("four-bar", "bennett", "door");
  const Scene s = loop(name);
  const double t_end = 2, h = 2e-3;
  const double lcp = observe(s, "lcp", t_end, 2 * h).energy_error / observe(s, "lcp", t_end, h).energy_error;
  const double ncp2 =
      observe(s, "ncp2", t_end, 2 * h).energy_error / observe(s, "ncp2", t_end, h).energy_error;
  CAPTURE(name, lcp, ncp2);
  CHECK(lcp > 1.6);
  CHECK(lcp < 2.4);
  CHECK(ncp2 > 3.6);
  CHECK(ncp2 < 4.4);
}

TEST_CASE("event turns loops whose redundant rows turn with them, through a change point too",
          "[joint][event]") {
  if (!has_sundials()) return;
  const std::string name = GENERATE("parallelogram", "bennett");
  const Scene s = loop(name);
  EventDriven stepper({.rtol = 1e-8});
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 2});
  CAPTURE(name);
  CHECK(run.steps() < 1000);
  CHECK(run.figures(run.steps() - 1).joint_error < 1e-12);
  CHECK(run.figures(run.steps() - 1).energy == Approx(s.model.energy(s.start)).epsilon(1e-6));
}

TEST_CASE("a hundred seconds of a closed loop: closed to rounding, energy to the method's order",
          "[joint][slow]") {
  const std::string name = GENERATE("four-bar", "parallelogram", "bennett", "door");
  const Scene s = loop(name);
  const double t_end = 100, h = 5e-3;
  CAPTURE(name);
  const Loop lcp = observe(s, "lcp", t_end, h), ncp = observe(s, "ncp", t_end, h);
  const Loop ncp2 = observe(s, "ncp2", t_end, h), fine = observe(s, "ncp2", t_end, h / 2);
  CHECK(lcp.joint_error < 1e-10);
  CHECK(ncp.joint_error < 1e-10);
  CHECK(ncp2.joint_error < 1e-10);
  CHECK(fine.joint_error < 1e-10);
  const double ratio = ncp2.energy_error / fine.energy_error;  // does not grow with time
  CAPTURE(lcp.energy_error, ncp.energy_error, ncp2.energy_error, fine.energy_error);
  CHECK(ratio > 3.6);
  CHECK(ratio < 4.4);
}

TEST_CASE("loops run under event for a hundred seconds, a parallelogram through its change points too",
          "[joint][event][slow]") {
  if (!has_sundials()) return;
  const std::string name = GENERATE("four-bar", "parallelogram", "bennett", "door");
  const Loop event = observe(loop(name), "event", 100, not_set);
  CAPTURE(name, event.energy_error);
  CHECK(event.joint_error < 1e-10);
  CHECK(event.energy_error < 1e-6);
}
