// Forces of the event-driven method where contacts and joints are redundant, and what no force or impulse holds.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/impact.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

/// A bar of 2 kg that leans on a foot at its lower end and hangs on a hinge at its upper one, 1 m to the side: hinge and foot share its weight,
/// and push each other along the floor.
Model leaning(double mu) {
  Model model;
  const BodyId bar = model.add_body(Inertia::principal(2, {0.2, 0.2, 0.05}), {.pose = {{0.5, 0, 0.6}}});
  model.add_joint(revolute(ground, bar, {.point = {1, 0, 1.1}, .axis = {0, 1, 0}, .name = "hinge"}));
  model.add_contact(ground, bar, point_on_plane({-0.5, 0, -0.6}), {.mu = mu, .name = "foot"});
  return model;
}

}  // namespace

TEST_CASE("What hinge and foot share of a bar at rest lies in the foot's cone in every row",
          "[event][redundant]") {
  if (!has_sundials()) return;
  for (const double mu : {0.05, 0.3, 2.0}) {
    const Model model = leaning(mu);
    EventDriven stepper;
    const Trajectory run = simulate(model, stepper, model.rest(), {.t_end = 0.5});
    REQUIRE(run.size() > 1);
    CAPTURE(mu);
    for (std::size_t k = 0; k < run.steps(); ++k) {
      const StepReport row = run.report(k);
      REQUIRE(row.contacts.size() == 1);
      const ContactRow& foot = row.contacts.front();
      CAPTURE(k, foot.force, foot.impulse);
      const double n = foot.force.z(), p = foot.impulse.z();
      CHECK(n > 0);
      CHECK(foot.force.head<2>().norm() <= mu * n * (1 + 1e-9));
      CHECK(foot.impulse.head<2>().norm() <= mu * p * (1 + 1e-9));
      CHECK(foot.impulse.isApprox(row.h * foot.force, 1e-9));
      // moments about the hinge, the foot 1 m aside and 1.1 m below
      CHECK(n - 1.1 * foot.force.x() == Approx(2 * 9.81 * 0.5).epsilon(1e-9));
      CHECK(row.residuals.friction < 1e-12);
    }
    CHECK(run.back().nu.norm() < 1e-14);
  }
}

TEST_CASE("An impact on what joints hold still is not solved", "[impact]") {
  Model model;
  const BodyId lift = model.add_prescribed(PrescribedMotion::shaker({0, 0, 1}, 3));
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {{0.3, 0.2, 0.1}}});
  model.add_joint(fixed(ground, ball, {.point = {0.3, 0.5, 0.7}}));
  model.add_contact(lift, ball, sphere_on_plane(0.1), {.mu = 0.3});
  const Impact impact = solve_impact(model, model.rest());
  CHECK_FALSE(impact.solved);
  CHECK(impact.nu == model.rest().nu);
}
