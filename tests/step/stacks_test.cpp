// Stacks at rest: joints that close at once, and lcp's steps that go on from the last basis.
#include <catch2/catch.hpp>
#include <string>

#include "perp/model/gaps.hpp"
#include "perp/step/methods.hpp"
#include "perp/study/scene.hpp"

using namespace perp;

namespace {

double total_mass(const Model& model) {
  double mass = 0;
  for (const Body& b : model.bodies())
    if (b.nv > 0) mass += b.mass;
  return mass;
}

/// Normal impulses on the ground.
double carried(const Model& model, const StepReport& report) {
  double sum = 0;
  for (const ContactRow& row : report.contacts)
    if (model.contacts()[static_cast<std::size_t>(row.contact)].a == ground) sum += row.p_n;
  return sum;
}

}  // namespace

TEST_CASE(
    "the steps of a stack at rest are answered by Newton's method, whatever its height, masses and step",
    "[stacks]") {
  struct Case {
    double count, ratio, h;
  };
  const auto c = GENERATE(values<Case>({{10, 1000, 0.02},
                                        {10, 100, 0.01},
                                        {15, 1000, 0.01},
                                        {20, 1000, 0.002},
                                        {30, 100, 0.01},
                                        {40, 1, 0.01}}));
  const std::string method = GENERATE("ncp", "ncp2");
  const Scene stack = scene("stack", {{"count", c.count}, {"ratio", c.ratio}});
  CAPTURE(method, c.count, c.ratio, c.h);
  const auto stepper = make_stepper(method);
  State x = stack.start;
  for (int k = 0; k < 25; ++k) {
    const StepReport report = stepper->step(stack.model, x, c.h);
    REQUIRE(report.advanced());
    CHECK(report.solver == "newton");
    CHECK(report.iterations <= 10);
    CHECK(report.contacts.size() == static_cast<std::size_t>(4 * c.count));
    const double weight = 9.81 * c.h * total_mass(stack.model);
    CHECK(std::abs(carried(stack.model, report) - weight) < 1e-8 * weight);
    CHECK(x.nu.cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("a step of lcp on a stack goes on from the last step's basis, to the answer of Lemke's method",
          "[lcp][stacks]") {
  const Scene stack = scene("stack", {{"count", 4}, {"ratio", GENERATE(1.0, 100.0)}});
  const auto stepper = make_stepper("lcp");
  State x = stack.start;
  REQUIRE(stepper->step(stack.model, x, 0.01).solver == "lemke");
  State other = x;
  const StepReport warm = stepper->step(stack.model, x, 0.01);
  const StepReport cold = make_stepper("lcp")->step(stack.model, other, 0.01);
  REQUIRE(warm.advanced());
  CHECK(warm.solver == "basis");
  CHECK(cold.solver == "lemke");
  CHECK(warm.iterations <= 4);
  CHECK((x.nu - other.nu).cwiseAbs().maxCoeff() < 1e-11);
  const double weight = 9.81 * 0.01 * total_mass(stack.model);
  CHECK(std::abs(carried(stack.model, warm) - weight) < 1e-9 * weight);
  CHECK(warm.residuals.normal < 1e-10);
}

TEST_CASE("balls on top of each other, no loop of bodies, go on from the last step's basis",
          "[lcp][stacks]") {
  Model model;
  BodyId below = ground;
  for (int i = 0; i < 7; ++i) {
    const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {.p = {0, 0, 0.1 + 0.2 * i}}});
    model.add_contact(below, ball, i == 0 ? sphere_on_plane(0.1) : sphere_on_sphere(0.1, 0.1), {.mu = 0.3});
    below = ball;
  }
  State x = model.rest();
  const auto stepper = make_stepper("lcp");
  REQUIRE(stepper->step(model, x, 0.01).solver == "lemke");
  const StepReport second = stepper->step(model, x, 0.01);
  CHECK(second.solver == "basis");
  CHECK(std::abs(carried(model, second) - 7 * 9.81 * 0.01) < 1e-10);
}

TEST_CASE("a step of lcp finds its way from the last basis when the stack begins to slide", "[lcp][stacks]") {
  Scene stack = scene("stack", {{"count", 3}, {"ratio", 1}});
  const auto stepper = make_stepper("lcp");
  State x = stack.start;
  REQUIRE(stepper->step(stack.model, x, 0.01).advanced());
  for (const double push : {0.5, 2.0, 0.0}) {
    x.nu[0] += push;
    State other = x;
    const StepReport warm = stepper->step(stack.model, x, 0.01);
    const StepReport cold = make_stepper("lcp")->step(stack.model, other, 0.01);
    CAPTURE(push, warm.solver);
    REQUIRE(warm.advanced());
    REQUIRE(cold.advanced());
    CHECK((x.nu - other.nu).cwiseAbs().maxCoeff() < 1e-9);
  }
}
