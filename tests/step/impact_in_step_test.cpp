// Impacts in steps of fixed size: one impulse, one law.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/impact.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "perp/step/simulate.hpp"
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

TEST_CASE("several impacts in one step never add energy, and come one after the other as steps get small",
          "[impact]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2");
  CAPTURE(method);
  Model model;
  model.set_gravity(Vector3::Zero());
  std::vector<BodyId> balls;
  for (const double x : {0.0, 1.02, 2.021, 3.022, 4.023})
    balls.push_back(model.add_body(Inertia::solid_sphere(1, 0.5), {.pose = {.p = {x, 0, 0}}}));
  for (std::size_t i = 0; i < 4; ++i)
    model.add_contact(balls[i], balls[i + 1], sphere_on_sphere(0.5, 0.5), {.e = 1});
  const auto stepper = make_stepper(method);
  for (const double h : {1e-2, 4e-3, 2.3e-3, 1e-3, 7e-4, 4e-4, 1e-4, 1e-5}) {
    CAPTURE(h);
    State x = model.rest();
    model.set_velocity(x, balls[0], {5, 0, 0});
    const Trajectory run = simulate(model, *stepper, x, {.t_end = 0.02, .h = h});
    for (std::size_t i = 0; i < run.steps(); ++i) CHECK(run.figures(i).energy <= 12.5 * (1 + 1e-11));
    CHECK(model.momentum(run.back()).linear.x() == Approx(5).epsilon(1e-11));
    if (h > 1e-4) continue;
    for (std::size_t i = 0; i < 5; ++i)
      CHECK(model.velocity(run.back(), balls[i]).x() == Approx(i == 4 ? 5 : 0).margin(1e-9));
  }
}

TEST_CASE("An impact changes no body that nothing ties to it", "[impact][lcp]") {
  Model model;
  const auto ball = [&](const char* name) {
    const BodyId b = model.add_body(Inertia::solid_sphere(1, 0.1), {.name = name});
    model.add_contact(ground, b, sphere_on_plane(0.1), {.e = 0.5, .name = name});
    return b;
  };
  const BodyId arriving = ball("arriving"), sunk = ball("sunk");
  State x = model.rest();
  model.set_position(x, arriving, {0, 0, 0.11});
  model.set_velocity(x, arriving, {0, 0, -3});
  model.set_position(x, sunk, {1, 0, 0.099});  // pushed out over the step, at 1 mm/h
  const State before = x;
  const double h = 0.01;
  LcpStepper lcp;
  const StepReport report = lcp.step(model, x, h);
  REQUIRE(report.advanced());
  CHECK(std::abs(model.velocity(x, arriving).z() - 1.5) < 1e-12);
  const double rate = (model.position(x, sunk).z() - model.position(before, sunk).z()) / h;
  CHECK(std::abs(rate - 0.1) < 1e-12);
  CHECK(std::abs(model.velocity(x, sunk).z() - rate) < 1e-12);
}

TEST_CASE("A contact that the step left open takes no part in an impact", "[impact][lcp]") {
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId rod = model.add_planar_body(1, 1.0 / 12, {.name = "rod"});
  const auto foot = [&](const char* name, double along, double above, double e) {
    const Gap gap = [=](const Pose&, const Pose& X, double) {
      const Vector3 x = X * Vector3(along, above, 0);
      return ContactPoint{.gap = x.y(), .normal = Vector3::UnitY(), .point = x};
    };
    model.add_contact(ground, rod, gap, {.e = e, .name = name});
  };
  foot("left", -0.5, 0.0005, 1);
  foot("middle", 0, 0.001, 0);
  foot("right", 0.5, 0.005, 0);  // without the others it would close too
  State x = model.rest();
  model.set_velocity(x, rod, {0, -1, 0});
  const Vector q = x.q;
  LcpStepper lcp;
  const StepReport report = lcp.step(model, x, 0.01);
  REQUIRE(report.advanced());
  x.q = q;  // where the impact is posed
  Instant s;
  evaluate(model, x, s);
  CHECK(report.contact("right").impulse.norm() == 0);
  CHECK(s.contacts[0].velocity(x.nu).x() == Approx(1).epsilon(1e-12));
  CHECK(std::abs(s.contacts[1].velocity(x.nu).x()) < 1e-12);
  CHECK(s.contacts[2].velocity(x.nu).x() == Approx(-1).epsilon(1e-12));
}
