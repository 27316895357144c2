// Impacts in steps of fixed size: one impulse, one law.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/impact.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "tests/instant/random_systems.hpp"

using namespace perp;
using perp::testing::Random;

namespace {

/// A rod in the plane whose tip flies at a floor, and its state when they meet.
struct ThrownRod {
  Model model;
  State touching;

  explicit ThrownRod(Random& random, double e) {
    model.set_gravity(Vector3::Zero());
    const double angle = 0.5 + 0.4 * random.positive();
    const BodyId rod = model.add_planar_body(1, 1.0 / 12, {.name = "rod"});
    const Gap tip = [](const Pose&, const Pose& X, double) {
      const Vector3 x = X * Vector3(-0.5, 0, 0);
      return ContactPoint{.gap = x.y(), .normal = Vector3::UnitY(), .point = x};
    };
    model.add_contact(ground, rod, tip, {.mu = 0.3 * random.positive(), .e = e});
    touching = model.rest();
    model.set_orientation(touching, rod, rotation({0, 0, angle}));
    model.set_position(touching, rod, {0, 0.5 * std::sin(angle), 0});
    model.set_velocity(touching, rod, {random.number(), -1, 0});
  }
};

/// A ball that flies at the upper end of a leaning rod whose foot slides along a rough floor, and the state when they meet.
struct StruckRod {
  Model model;
  State touching;

  StruckRod(Random& random, double e) {
    model.set_gravity(Vector3::Zero());
    const double angle = 0.5 + 0.4 * random.positive();
    const Vector3 along(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0);
    const BodyId ball = model.add_particle(random.positive(), {.name = "ball"});
    const BodyId rod = model.add_planar_body(1, 1.0 / 12, {.name = "rod"});
    const Vector3 n = Vector3(1, -random.positive(), 0).normalized();
    const Gap head = [n](const Pose& A, const Pose& B, double) {
      const Vector3 end = B * Vector3(0.5, 0, 0);
      return ContactPoint{.gap = n.dot(end - A.p), .normal = n, .point = end};
    };
    const Gap foot = [](const Pose&, const Pose& X, double) {
      const Vector3 end = X * Vector3(-0.5, 0, 0);
      return ContactPoint{.gap = end.y(), .normal = Vector3::UnitY(), .point = end};
    };
    model.add_contact(ball, rod, head, {.mu = 0.2, .e = e});
    model.add_contact(ground, rod, foot, {.mu = 0.3 * random.positive()});
    touching = model.rest();
    model.set_orientation(touching, rod, rotation({0, 0, angle}));
    model.set_position(touching, rod, along);
    model.set_position(touching, ball, 2 * along);
    model.set_velocity(touching, ball, {2, -0.5 * random.positive(), 0});
    model.set_velocity(touching, rod, {random.number(), 0, 0});
  }
};

}  // namespace

TEST_CASE("the velocity after an impact is that of its law wherever in the step it falls", "[impact][step]") {
  const auto method = GENERATE("lcp", "lcp-ap", "ncp", "ncp-start", "ncp2");
  const double e = GENERATE(0.0, 0.5);
  constexpr double h = 1e-6;
  const auto stepper = make_stepper(method);
  Random random(5);
  int sticks = 0, slips = 0, turns = 0;
  for (int i = 0; i < 200; ++i) {
    const ThrownRod rod(random, e);
    const Impact law = solve_impact(rod.model, rod.touching);
    REQUIRE(law.solved);
    State x = rod.touching;
    x.q -= h * (1 + 0.5 * (1 + random.number(0.98))) * x.nu;  // in the second of three steps
    CAPTURE(method, e, i, law.nu.transpose());
    for (int k = 0; k < 3; ++k) {
      const StepReport report = stepper->step(rod.model, x, h);
      CAPTURE(k, report.message, x.nu.transpose());
      REQUIRE(report.advanced());
    }
    CAPTURE(x.nu.transpose());
    CHECK((x.nu - law.nu).norm() < 1e-4);
    const ContactMode mode = law.contacts[0].mode;
    const double before = rod.touching.nu[0], friction = law.contacts[0].impulse.x();
    sticks += mode == ContactMode::Stick ? 1 : 0;
    slips += mode == ContactMode::Slip && friction * before < 0 ? 1 : 0;
    turns += mode == ContactMode::Slip && friction * before > 0 ? 1 : 0;
  }
  CAPTURE(sticks, slips, turns);
  CHECK(sticks > 20);
  CHECK(slips > 20);
  CHECK(turns > 10);
}

TEST_CASE("what an impact drives into the floor has one law too", "[impact][step]") {
  const auto method = GENERATE("lcp", "ncp", "ncp2");
  const double e = GENERATE(0.0, 0.5);
  constexpr double h = 1e-6;
  const auto stepper = make_stepper(method, {.edges = 4});  // the floor's friction is along x: exact
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    const StruckRod struck(random, e);
    const Impact law = solve_impact(struck.model, struck.touching);
    REQUIRE(law.solved);
    State x = struck.touching;
    const double back = h * (1 + 0.5 * (1 + random.number(0.98)));
    x.q -= back * x.nu;
    CAPTURE(method, e, i, law.nu.transpose());
    for (int k = 0; k < 3; ++k) {
      const StepReport report = stepper->step(struck.model, x, h);
      CAPTURE(k, report.message);
      REQUIRE(report.advanced());
    }
    CAPTURE(x.nu.transpose());
    CHECK((x.nu - law.nu).norm() < 1e-4);
  }
}

TEST_CASE("an impact under ncp leaves bodies that it does not reach as they are", "[impact][step]") {
  Model model;
  const BodyId falls = model.add_particle(1), rests = model.add_particle(1);
  const Gap floor = [](const Pose&, const Pose& X, double) {
    return ContactPoint{.gap = X.p.z(), .normal = Vector3::UnitZ(), .point = X.p};
  };
  model.add_contact(ground, falls, floor, {.mu = 0.1, .e = 0.5});
  model.add_contact(ground, rests, floor, {.mu = 0.1});
  State x = model.rest();
  model.set_position(x, falls, {0, 0, 5e-4});
  model.set_velocity(x, falls, {0, 0, -1});
  NcpStepper ncp;
  REQUIRE(ncp.step(model, x, 1e-3).advanced());
  CHECK(x.nu[2] == Approx(0.5).epsilon(1e-12));
  CHECK(std::abs(x.nu[5]) < 1e-15);
}

TEST_CASE("joint friction has its impulse of a step in one with an impact as well", "[impact][step][joint]") {
  const auto method = GENERATE("ncp", "ncp2");
  constexpr double friction = 0.3, h = 1e-3;
  Model model;
  const BodyId arm = model.add_planar_body(1, 0.1, {.name = "arm"});
  const JointId hinge = model.add_joint(revolute(ground, arm, {.friction = friction, .name = "hinge"}));
  model.add_limit(hinge, {.upper = 0.1, .e = 0.5});
  State x = model.rest();
  model.set_velocity(x, arm, Vector3::Zero(), {0, 0, 5});
  const auto stepper = make_stepper(method);
  bool struck = false;
  for (int i = 0; i < 40; ++i) {
    const StepReport report = stepper->step(model, x, h);
    REQUIRE(report.advanced());
    CAPTURE(method, i);
    CHECK(std::abs(report.joint("hinge").friction) == Approx(friction * h).epsilon(1e-9));
    struck = struck || report.contact("hinge.upper").p_n > 0;
  }
  CHECK(struck);
  CHECK(x.nu[2] < 0);
}

TEST_CASE("what comes down no faster than loads make it in a step is thrown back too", "[impact][step]") {
  const auto method = GENERATE("lcp", "ncp", "ncp2");
  Model model;
  const BodyId ball = model.add_particle(1);
  const Gap floor = [](const Pose&, const Pose& X, double) {
    return ContactPoint{.gap = X.p.z(), .normal = Vector3::UnitZ(), .point = X.p};
  };
  model.add_contact(ground, ball, floor, {.e = 0.5});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 2e-6});
  model.set_velocity(x, ball, {0, 0, -0.01});
  REQUIRE(make_stepper(method)->step(model, x, 1e-3).advanced());
  CAPTURE(method);
  CHECK(x.nu[2] == Approx(0.005).epsilon(1e-12));
}

TEST_CASE("a ball that bounces under ncp2 loses the power that its page says", "[impact][step]") {
  const double h = GENERATE(0.01, 0.005), g = 9.81, t_end = 30;
  Model model;
  const BodyId ball = model.add_particle(1);
  const Gap floor = [](const Pose&, const Pose& X, double) {
    return ContactPoint{.gap = X.p.z(), .normal = Vector3::UnitZ(), .point = X.p};
  };
  model.add_contact(ground, ball, floor, {.e = 1});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 10});
  const double before = model.energy(x);
  const auto stepper = make_stepper("ncp2");
  for (int i = 0; i < std::lround(t_end / h); ++i) REQUIRE(stepper->step(model, x, h).advanced());
  const double lost = before - model.energy(x), expected = g * g * h / 4 * t_end;
  CAPTURE(h, lost, expected);
  CHECK(lost > 0.6 * expected);  // ten bounces, each somewhere in its step
  CHECK(lost < 1.4 * expected);
}

TEST_CASE("the seed's own rows spread an impact over two steps", "[impact][step][lcp]") {
  LcpStepper seed({.whole_impacts = false}), whole;
  Random random(5);
  const ThrownRod rod(random, 0);
  const double h = 1e-3;
  State x = rod.touching;
  x.q -= 0.25 * h * x.nu;
  State y = x;
  REQUIRE(seed.step(rod.model, x, h).advanced());
  REQUIRE(whole.step(rod.model, y, h).advanced());
  Instant s;
  evaluate(rod.model, x, s);
  CHECK(s.contacts[0].velocity(x.nu).x() ==
        Approx(-0.25).epsilon(2e-3));  // psi+ = 0: a quarter of the way in h
  CHECK(s.contacts[0].velocity(y.nu).x() == Approx(0).margin(1e-3));
  CHECK((x.q - y.q).norm() < 1e-15);
}
