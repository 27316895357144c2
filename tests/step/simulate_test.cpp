#include "perp/step/simulate.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/methods.hpp"

using namespace perp;
using Catch::Contains;

namespace {

struct Slider {
  Model model;
  BodyId bead = model.add_particle(1, {.name = "bead"});
  State x;
  Slider() {
    model.add_contact(ground, bead, particle_on_plane(), {.mu = 0.2, .name = "floor"});
    x = model.rest();
    model.set_velocity(x, bead, {2, 0, 0});
  }
};

}  // namespace

TEST_CASE("a run takes round(T/h) equal steps, one at least, to exactly T", "[simulate]") {
  Slider s;
  LcpStepper stepper;
  s.x.t = 0.5;
  const Trajectory run = simulate(s.model, stepper, s.x, {.t_end = 1.2, .h = 0.12});
  REQUIRE(run.size() == 7);  // round(.7/.12) = 6
  CHECK(run.back().t == 1.2);
  for (std::size_t k = 0; k < 6; ++k) {
    CHECK(run.figures(k).h == (1.2 - 0.5) / 6);
    CHECK(run.t(k) == 0.5 + static_cast<double>(k) * (1.2 - 0.5) / 6);
  }
  CHECK(simulate(s.model, stepper, s.x, {.t_end = 0.6, .h = 5}).size() == 2);
}

TEST_CASE("a trajectory keeps states and reports as they were", "[trajectory]") {
  Slider s;
  LcpStepper stepper;
  const Trajectory run = simulate(s.model, stepper, s.x, {.t_end = 0.3, .h = 0.1});
  LcpStepper again;
  State x = s.x;
  for (std::size_t k = 0; k < 3; ++k) {
    StepReport report;
    again.step(s.model, x, {.h = 0.3 / 3, .t_end = run.t(k + 1)}, report);
    CHECK(run.state(k + 1).q == x.q);
    CHECK(run.state(k + 1).nu == x.nu);
    CHECK(run.report(k).contact("floor").impulse == report.contact("floor").impulse);
    CHECK(run.report(k).energy == report.energy);
    CHECK(run.report(k).iterations == report.iterations);
  }
  CHECK_THROWS_AS(run.state(4), std::out_of_range);
  CHECK_THROWS_AS(run.report(3), std::out_of_range);
}

TEST_CASE("a step that fails throws with the report and the trajectory up to it", "[simulate]") {
  Model model;
  const BodyId bead = model.add_particle(1);
  model.add_contact(ground, bead, Gap([](const Pose&, const Pose& X, double) {
                      return ContactPoint{.gap = std::sqrt(X.p.z()), .point = X.p};  // NaN below the floor
                    }),
                    {.name = "pit"});
  State x = model.rest();
  model.set_position(x, bead, {0, 0, 1});
  model.set_velocity(x, bead, {0, 0, -1});
  model.set_gravity({0, 0, -9.81});
  LcpStepper stepper;
  try {
    (void)simulate(model, stepper, x, {.t_end = 2, .h = 0.05});
    FAIL("the gap became NaN and nothing was thrown");
  } catch (const StepFailure& failure) {
    CHECK_THAT(failure.what(), Contains("contact 'pit'") && Contains("not finite"));
    CHECK(failure.report.status == StepStatus::NotFinite);
    REQUIRE(failure.trajectory.size() > 2);
    CHECK(failure.trajectory.back().t == Approx(failure.report.t - 0.05));
    CHECK(failure.trajectory.back().q.allFinite());
    CHECK(failure.trajectory.front().q == x.q);
  }
}

TEST_CASE("progress is told every step and can end the run", "[simulate]") {
  Slider s;
  LcpStepper stepper;
  int calls = 0;
  const Trajectory run = simulate(s.model, stepper, s.x, {.t_end = 1, .h = 0.1, .progress = [&](double t) {
                                                            ++calls;
                                                            return t < 0.35;
                                                          }});
  CHECK(calls == 4);
  CHECK(run.back().t == Approx(0.4));
}

TEST_CASE("options that cannot be are refused by name", "[simulate]") {
  Slider s;
  LcpStepper stepper;
  CHECK_THROWS_WITH(simulate(s.model, stepper, s.x, {.t_end = 1}), Contains("h is nan"));
  CHECK_THROWS_WITH(simulate(s.model, stepper, s.x, {.t_end = 1, .h = -0.1}), Contains("h is -0.1"));
  CHECK_THROWS_WITH(simulate(s.model, stepper, s.x, {.h = 0.1}), Contains("t_end is nan"));
  CHECK_THROWS_WITH(simulate(s.model, stepper, s.x, {.t_end = 0, .h = 0.1}), Contains("t_end is 0"));
  CHECK_THROWS_WITH(simulate(s.model, stepper, s.x, {.t_end = 1, .h = 0.1, .max_correction_speed = -1}),
                    Contains("max_correction_speed is -1"));
}

TEST_CASE("a projected start satisfies its constraints and nothing is pushed out", "[projection]") {
  Model model;
  const BodyId box = model.add_body(Inertia::solid_box(1, {1, 1, 1}), {.name = "box"});
  const BodyId bob = model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {{1, 0, 2}, {1, 0, 0, 0}}});
  model.add_contact(ground, box, box_on_plane({1, 1, 1}), {.mu = 0.5});
  model.add_joint(ball(ground, bob, {.point = {0, 0, 2}}));
  State x = model.rest();
  model.set_position(x, box, {0, 0, 0.4});  // 10 cm inside the floor
  model.set_velocity(x, box, {0, 0, -1});
  model.set_position(x, bob, {1.1, 0.05, 2});
  model.set_velocity(x, bob, {1, 0, 1});
  const Projection projection = project_onto_constraints(model, x);
  CHECK(projection.reached);
  CHECK(projection.gap_min > -1e-13);
  CHECK(projection.joint_error < 1e-13);
  CHECK(model.velocity(x, box).norm() < 1e-14);
  const Vector3 arm = (model.position(x, bob) - Vector3(0, 0, 2)).normalized();
  CHECK(std::abs(model.velocity(x, bob).dot(arm)) < 1e-12);

  State sunk = model.rest();
  model.set_position(sunk, box, {0, 0, 0.4});
  LcpStepper stepper;
  const Trajectory calm = simulate(model, stepper, sunk, {.t_end = 0.01, .h = 1e-3, .project_initial = true});
  CHECK(model.velocity(calm.back(), box).norm() < 1e-12);
  const Trajectory pushed = simulate(model, stepper, sunk, {.t_end = 0.01, .h = 1e-3});
  CHECK(model.velocity(pushed.state(1), box).z() == Approx(100));  // psi/h
}

TEST_CASE("methods are found by name, and a wrong name lists them", "[methods]") {
  for (const Method& m : methods()) CHECK(make_stepper(m.name)->name() == m.name);
  CHECK_THROWS_WITH(method("lpc"), Contains("lpc") && Contains("lcp, lcp-ap"));
}

TEST_CASE("a scene in which nothing moves runs under every method", "[simulate]") {
  Model empty, prescribed;
  prescribed.add_prescribed(PrescribedMotion::turntable({0, 0, 1}, 2, {{0, 0, 1}, Quaternion::Identity()}));
  for (const Model* model : {&empty, &prescribed})
    for (const char* method : {"lcp", "lcp-ap", "ncp", "ncp-start", "ncp2"}) {
      CAPTURE(method, model->bodies().size());
      const auto stepper = make_stepper(method);
      const Trajectory run = simulate(*model, *stepper, model->rest(), {.t_end = 0.3, .h = 0.1});
      CHECK(run.size() == 4);
      CHECK(run.figures(2).residuals.newton_euler == 0);
      CHECK(run.back().t == 0.3);
    }
}

TEST_CASE("equations that overflow are no answer", "[simulate]") {
  Slider s;
  s.model.add_force(s.bead, [](const Model&, const State&) { return Wrench{{0, 0, -1e200}, {}}; });
  for (const char* method : {"ncp", "ncp2"}) {
    const auto stepper = make_stepper(method);
    State x = s.x;
    const StepReport report = stepper->step(s.model, x, 0.01);
    CAPTURE(method, report.message, report.gap_min);
    CHECK(report.status == StepStatus::NotFinite);
    CHECK(x.q == s.x.q);
  }
}
