// Dry friction along each freedom of joints with several.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;
using Catch::Matchers::Contains;

namespace {

/// What slides or turns at rate u, of inertia m, under the constant friction c.
double rate_at(double u, double c, double m, double t) { return std::max(0.0, u - c / m * t); }

}  // namespace

TEST_CASE("a cylindrical joint's slide and turn are braked each by its own friction", "[joints]") {
  const double mass = 2, J = 0.5, v = 1, w = 4;
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId sleeve = model.add_body(Inertia::principal(mass, {0.3, 0.4, J}), {.name = "sleeve"});
  model.add_joint(cylindrical(ground, sleeve, {.frictions = {0.8, 1.5}, .name = "shaft"}));  // N m, N
  State x = model.rest();
  model.set_velocity(x, sleeve, {0, 0, v}, {0, 0, w});
  for (const char* name : {"lcp", "ncp", "ncp2", "event", "extrapolated"}) {
    const std::unique_ptr<Stepper> stepper = make_stepper(name);
    for (const double t : {1.0, 2.0, 3.0}) {  // the slide stops after 4/3 s, the turn after 2.5 s
      SimulateOptions options{.t_end = t};
      if (!chooses_steps(*stepper)) options.h = 1e-2;
      const Trajectory run = simulate(model, *stepper, x, options);
      CAPTURE(name, t);
      CHECK(model.velocity(run.back(), sleeve).z() == Approx(rate_at(v, 1.5, mass, t)).margin(1e-9));
      CHECK(model.angular_velocity(run.back(), sleeve).z() == Approx(rate_at(w, 0.8, J, t)).margin(1e-9));
      const StepReport& last = run.report(run.steps() - 1);
      CHECK(last.joint("shaft.slide").friction == Approx(t > 4.0 / 3 ? 0 : -1.5 * last.h).margin(1e-9));
    }
  }
}

TEST_CASE("a planar joint has a friction for each of x, y and its angle", "[joints]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId puck = model.add_body(Inertia::principal(1, {0.1, 0.1, 0.2}), {.name = "puck"});
  model.add_joint(planar(ground, puck, {.frictions = {1, 0, 0.1}, .name = "table"}));
  State x = model.rest();
  model.set_velocity(x, puck, {1, 1, 0}, {0, 0, 1});
  const std::unique_ptr<Stepper> stepper = make_stepper("ncp2");
  const State end = simulate(model, *stepper, x, {.t_end = 1.5, .h = 1e-2}).back();
  CHECK(model.velocity(end, puck).norm() == Approx(1).epsilon(1e-9));  // along y alone
  CHECK(model.angular_velocity(end, puck).z() == Approx(0.25).epsilon(1e-9));
}

TEST_CASE("a joint says which frictions it cannot have", "[joints]") {
  Model model;
  const BodyId a = model.add_body(Inertia::solid_sphere(1, 1));
  CHECK_THROWS_WITH(model.add_joint(cylindrical(ground, a, {.friction = 1})), Contains("friction is 1"));
  CHECK_THROWS_WITH(model.add_joint(cylindrical(ground, a, {.frictions = {1}})), Contains("frictions is 1"));
  CHECK_THROWS_WITH(model.add_joint(cylindrical(ground, a, {.frictions = {1, -1}})),
                    Contains("frictions is -1"));
  CHECK_THROWS_WITH(model.add_joint(revolute(ground, a, {.friction = 1, .frictions = {1}})),
                    Contains("friction or frictions"));
  CHECK(model.joints().empty());
}
