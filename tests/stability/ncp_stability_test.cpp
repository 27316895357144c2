// Long runs and hard states: what the nonlinear steps must not do.
#include <catch2/catch.hpp>

#include "perp/core/errors.hpp"
#include "perp/model/gaps.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "tests/stability/course.hpp"

namespace perp {
namespace {

constexpr double g = 9.81;

/// Nothing overlaps, nothing creeps.
void stands(const Scene& s, std::string_view method, double T, double h, double tolerance) {
  const Course c = course(s, method, T, h);
  CAPTURE(s.name, method, h, c.steps);
  REQUIRE(c.finished);
  CHECK(c.gap_min > -tolerance);
  CHECK(c.drift < tolerance);
}

/// Joints stay closed; with them loops.
void stays_closed(const Model& model, const State& start, std::string_view method, double T) {
  const Course c = course(model, start, method, T, 0.005);
  CAPTURE(method, c.steps);
  REQUIRE(c.finished);
  CHECK(c.joint_error < 1e-10);
  CHECK(c.drift > 0.1);
}

/// A door on two hinges whose axis leans, so that it swings: ten rows where five would do.
std::pair<Model, State> door() {
  Model model;
  const Vector3 axis(0.2, 0, 1);
  const BodyId leaf = model.add_body(Inertia::solid_box(20, {0.05, 0.9, 2}), {.pose = {.p = {0, 0.45, 1}}});
  for (const double z : {0.2, 1.8})
    model.add_joint(revolute(ground, leaf, {.point = {0.2 * z, 0, z}, .axis = axis}));
  State x = model.rest();
  const Vector3 w = 2 * axis.normalized();
  model.set_velocity(x, leaf, w.cross(Vector3(0, 0.45, 1)), w);
  return {model, x};
}

}  // namespace

TEST_CASE("ten boxes stand under one a million times heavier, to a nanometre", "[stability]") {
  const auto method = GENERATE("ncp", "ncp2");
  const double ratio = GENERATE(1, 1000, 1e6);
  stands(scene("stack", {{"count", 10}, {"ratio", ratio}}), method, 1, 0.01, 1e-9);
}

TEST_CASE("ten boxes stand for five seconds at any step", "[stability][slow]") {
  const auto method = GENERATE("ncp", "ncp-start", "ncp2");
  const double ratio = GENERATE(1, 1000, 1e6), h = GENERATE(0.02, 0.01, 0.001);
  stands(scene("stack", {{"count", 10}, {"ratio", ratio}}), method, 5, h, 1e-9);
}

TEST_CASE("a tower of twenty boxes and one of crossed planks stand", "[stability]") {
  const auto method = GENERATE("ncp", "ncp2");
  stands(scene("tower", {{"count", 20}}), method, 0.5, 0.01, 1e-9);
  stands(scene("tower", {{"count", 5}, {"planks", 3}}), method, 0.2, 0.01, 1e-9);
}

TEST_CASE("a tower of a hundred boxes stands", "[stability][slow]") {
  stands(scene("tower"), GENERATE("ncp", "ncp2"), 2, 0.01, 1e-9);
}

TEST_CASE("linkages with more joint rows than they need stay closed", "[stability]") {
  const auto method = GENERATE("ncp", "ncp-start", "ncp2");
  for (const char* name : {"four-bar", "parallelogram", "bennett"}) {
    CAPTURE(name);
    const Scene s = scene(name);
    stays_closed(s.model, s.start, method, 3);
  }
  const auto [model, start] = door();
  stays_closed(model, start, method, 3);
}

TEST_CASE("linkages with more joint rows than they need stay closed for twenty seconds",
          "[stability][slow]") {
  const auto method = GENERATE("ncp", "ncp-start", "ncp2");
  for (const char* name : {"four-bar", "parallelogram", "bennett"}) {
    CAPTURE(name);
    const Scene s = scene(name);
    stays_closed(s.model, s.start, method, 20);
  }
  const auto [model, start] = door();
  stays_closed(model, start, method, 20);
}

TEST_CASE("where friction turns a circular cone's error has no floor", "[stability]") {
  const Scene s = scene("oblique-sphere");
  const auto error = [&](std::string_view method, double h) {
    return (course(s, method, 2, h).end.q - s.exact(2).q).head<3>().norm();
  };
  CHECK(error("ncp", 2e-3) < 0.025);
  CHECK(error("ncp", 2e-4) < 0.0025);  // the polygon with 64 edges stalls at .0076
  CHECK(error("ncp2", 2e-3) < 2e-5);
  CHECK(error("ncp2", 2e-4) < 2e-7);
}

TEST_CASE("a box held by friction does not creep down its slope in a hundred seconds", "[stability]") {
  stands(scene("creep"), GENERATE("ncp", "ncp-start", "ncp2"), 100, 0.02, 1e-12);
}

TEST_CASE("a sliding cube neither lifts nor tips, and stops where it should", "[stability]") {
  const Scene s = scene("sliding-cube");
  const auto [method, h, error] = GENERATE(table<const char*, double, double>(
      {{"ncp", 0.01, 0.04}, {"ncp", 0.001, 0.004}, {"ncp2", 0.01, 2e-4}, {"ncp2", 0.001, 2e-6}}));
  const Course c = course(s, method, 1.5, h);
  CAPTURE(method, h);
  REQUIRE(c.finished);
  CHECK(c.height_drift < 1e-12);
  CHECK(rotation_vector(s.model.pose(c.end, s.model.find_body("cube")).q).norm() < 1e-11);
  CHECK(c.end.nu.norm() < 1e-9);  // [m/s, rad/s]
  CHECK(std::abs(c.end.q[0] - 3.669724770642202) < error);
  CHECK(c.friction + c.left == Approx(-18).epsilon(1e-10));  // what it had: m v²/2
  CHECK(std::abs(c.left) <
        (method == std::string("ncp") ? 16 * h : 2 * h * h));  // the method's own part of it [J]
}

TEST_CASE("the impulses reported for a box at rest on a slope carry its weight", "[stability]") {
  const Scene s = scene("creep");
  const auto stepper = make_stepper(GENERATE("ncp", "ncp-start", "ncp2"));
  State x = s.start;
  Vector3 sum = Vector3::Zero();
  const StepReport report = stepper->step(s.model, x, 0.01);
  REQUIRE(report.advanced());
  for (const ContactRow& row : report.contacts) {
    sum += row.impulse;
    CHECK(row.mode == (row.p_n > 0 ? ContactMode::Stick : ContactMode::Open));
  }
  CHECK((sum + 0.01 * s.model.gravity()).norm() < 1e-12);
}

TEST_CASE("a roller in a cylinder keeps its gap closed to rounding", "[stability]") {
  const auto method = GENERATE("ncp", "ncp2");
  const double h = GENERATE(0.05, 0.01, 1e-3);
  const Course c = course(scene("roller-in-cylinder"), method, 3, h);
  CAPTURE(method, h);
  REQUIRE(c.finished);
  CHECK(c.gap_min > -1e-12);
  CHECK(c.gap_max < 1e-12);
}

TEST_CASE("a stiff free body keeps its angular momentum under the second-order step", "[stability]") {
  const Scene s = scene("free-spin");
  const auto momentum = [&](const State& x) {
    const Pose pose = s.model.pose(x, s.model.find_body("body"));
    const Vector3 w = x.nu.segment<3>(3);
    return Vector3(pose.q * Vector3(s.model.body({1}).J * w));
  };
  const Vector3 L = momentum(s.start);
  const Course c = course(s, "ncp2", 0.2, 1e-4);
  REQUIRE(c.finished);
  CHECK(std::abs(momentum(c.end).norm() - L.norm()) < 1e-12 * L.norm());
  CHECK((momentum(c.end) - L).norm() < 1e-11 * L.norm());
  // others: bounded, not kept
  for (const char* method : {"ncp", "ncp-start"}) {
    const Course loses = course(s, method, 0.2, 1e-3);
    REQUIRE(loses.finished);
    CHECK(momentum(loses.end).norm() < L.norm());
    CHECK(momentum(loses.end).norm() > 0.2 * L.norm());
  }
}

TEST_CASE("a box that starts in the floor is put on it without motion, or pushed out no faster than asked",
          "[stability]") {
  const Scene s = scene("sunk-box");
  for (const char* method : {"ncp", "ncp-start", "ncp2"}) {
    CAPTURE(method);
    const auto stepper = make_stepper(method);
    const Trajectory projected =
        simulate(s.model, *stepper, s.start, {.t_end = 0.5, .h = 0.001, .project_initial = true});
    CHECK(projected.back().nu.norm() < 1e-12);
    CHECK(std::abs(projected.back().q[2] - 0.5) < 1e-12);
    const Course capped = course(s.model, s.start, method, 0.1, 0.001, 0.5);
    REQUIRE(capped.finished);
    CHECK(capped.end.q[2] == Approx(0.4 + 0.1 * 0.5).margin(1e-3));
    CHECK(capped.end.nu.head<3>().norm() < 0.51);
    CHECK(course(s.model, s.start, method, 1, 0.001, 0.5).end.q[2] <
          0.52);  // it comes out with speed, and falls back
  }
}

TEST_CASE("large steps stay bounded and seldom need a stand-in", "[stability]") {
  const auto method = GENERATE("ncp", "ncp2");
  CAPTURE(method);
  const Scene sphere = scene("seed-sphere");
  const Course rolls = course(sphere, method, 0.6, 0.1);
  REQUIRE(rolls.finished);
  CHECK(rolls.stand_ins() == 0);
  CHECK(std::abs(rolls.end.q[0] - sphere.exact(0.6).q[0]) <
        0.2 * g * 0.1 * 0.6);  // h times friction's whole push
  const Course stack = course(scene("stack", {{"count", 10}}), method, 5, 0.1);
  REQUIRE(stack.finished);
  CHECK(stack.drift < 1e-9);
  CHECK(stack.stand_ins() == 0);
}

TEST_CASE("a linkage that swings stays closed and bounded at large steps of the fully implicit method",
          "[stability]") {
  const Scene bars = scene("four-bar");
  const Course swings = course(bars, "ncp", 10, 0.1);
  REQUIRE(swings.finished);
  CHECK(swings.stand_ins() == 0);
  CHECK(swings.joint_error < 1e-10);
  CHECK(swings.energy_max < bars.model.energy(bars.start) + 2);
}

TEST_CASE("one step from Painlevé's state tends to the impact without a collision", "[stability]") {
  struct Jump {
    double theta;
    Vector3 after;
  };
  for (const Jump& jump :
       {Jump{std::atan(2.0), {0.6, 0.3, -0.670820393249937}},
        Jump{std::acos(0.5), {0.5625, 0.324759526419164, -0.649519052838329}},
        Jump{50 * std::acos(-1.0) / 180, {0.440118066625099, 0.369302907379578, -0.574533332339234}}}) {
    const Scene s = scene("painleve-rod", {{"theta", jump.theta}});
    for (const char* method : {"ncp", "ncp-start", "ncp2"}) {
      CAPTURE(method, jump.theta);
      double last = 0;
      for (const double h : {1e-2, 1e-3, 1e-4, 1e-5}) {
        const Course c = course(s, method, h, h);
        REQUIRE(c.finished);
        const double error = (c.end.nu - jump.after).norm();
        CHECK(error < 10 * h);
        if (last > 0) CHECK(last / error == Approx(10).epsilon(0.2));
        last = error;
        CHECK(c.energy_max < s.model.energy(s.start));
      }
    }
  }
}

TEST_CASE("a sphere on a turntable rolls in its circle, and a plate throws and catches a particle",
          "[stability]") {
  const auto [method, error] = GENERATE(table<const char*, double>({{"ncp", 0.02}, {"ncp2", 2e-4}}));
  CAPTURE(method);
  const Scene disc = scene("turntable");
  const Course rolls = course(disc, method, 5, 0.005);
  REQUIRE(rolls.finished);
  CHECK(std::abs(rolls.end.q[0] + 0.04296783521384824) < error);
  CHECK(std::abs(rolls.end.q[1] - 0.04911014491501246) < error);
  CHECK(rolls.gap_max < 1e-12);
  const Course thrown = course(scene("shaker"), method, 1, 0.001);
  REQUIRE(thrown.finished);
  CHECK(thrown.gap_min > -1e-12);
}

TEST_CASE("blocks pushed out by .999 of the harmonic overhang stand, by 1.001 fall", "[stability]") {
  const auto top = [](const Scene& s, const State& x) {
    return s.model.position(x, s.model.find_body("block-10")).z();
  };
  for (const auto method : {"ncp", "ncp2"})
    stands(scene("overhang", {{"scale", 0.999}}), method, 5, 0.02, 1e-9);
  const Scene falls = scene("overhang", {{"scale", 1.001}});
  const Course c =
      course(falls, "ncp", 2, 0.02);  // ncp2 stops on its way down: doc/shapes.md, known failures
  CAPTURE(c.steps);
  CHECK(top(falls, falls.start) - top(falls, c.end) > 0.02);
}

TEST_CASE("a card stands on a floor rough enough and slides on one a thousandth smoother", "[stability]") {
  const auto method = GENERATE("ncp", "ncp-start", "ncp2");
  stands(scene("card", {{"mu", 0.2888}}), method, 2, 0.001, 1e-11);
  CHECK(course(scene("card", {{"mu", 0.2885}}), method, 2, 0.001).drift > 0.01);
}

TEST_CASE("an arch of thickness .112 stands, with directions at the end and of second order", "[stability]") {
  stands(scene("arch"), GENERATE("ncp", "ncp2"), 2, 0.01, 1e-6);
}

TEST_CASE("an arch of thickness .103 falls, with directions at the end and of second order", "[stability]") {
  const Course c = course(scene("arch", {{"thickness", 0.103}}), GENERATE("ncp", "ncp2"), 0.4, 0.01);
  CAPTURE(c.steps);
  CHECK(c.drift > 0.05);
}

TEST_CASE("a wedge and a peg stay jammed while friction's angle spans them, and let go below",
          "[stability]") {
  const auto method = GENERATE("ncp", "ncp-start", "ncp2");
  CAPTURE(method);
  const double threshold = std::tan(0.3);
  const Course locked = course(scene("wedge", {{"mu", 1.3 * threshold}}), method, 0.5, 0.01);
  REQUIRE(locked.finished);
  CHECK(locked.end.nu.norm() < 1e-10);
  CHECK(course(scene("wedge", {{"mu", 0.999 * threshold}}), method, 0.5, 0.01).end.nu.norm() > 1);
  const Course jammed = course(scene("peg"), method, 0.5, 0.01);
  REQUIRE(jammed.finished);
  CHECK(jammed.end.nu.norm() < 1e-10);
  CHECK(course(scene("peg", {{"mu", 0.3996}}), method, 0.5, 0.01).end.nu.norm() > 0.1);
}

TEST_CASE("a contact point that vanishes within the step does not loosen the step's tolerance",
          "[stability]") {
  // a ball slides off the end of a rough table that is there up to x = 0; a second point of it stays
  const Gap table = Gap::patch(2, [](const Pose&, const Pose& ball, double, std::span<ContactPoint> out) {
    for (std::size_t i = 0; i < 2; ++i)
      out[i] = {.gap = ball.p.z() - 1, .normal = Vector3::UnitZ(), .point = ball.p - Vector3::UnitZ()};
    if (ball.p.x() > 0) out[1] = {};
  });
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1), {.pose = {.p = {-0.01, 0, 1}}});
  model.add_contact(ground, ball, table, {.mu = 0.3});
  State x = model.rest();
  model.set_velocity(x, ball, {3, 0, 0});
  for (const char* method : {"ncp", "ncp-start", "ncp2"}) {
    State after = x;
    const StepReport report = make_stepper(method)->step(model, after, 0.01);
    CAPTURE(method);
    REQUIRE(report.advanced());
    CHECK(std::max(report.residuals.normal, report.residuals.friction) < 1e-9);
    CHECK(after.nu[0] == Approx(3 - 0.3 * g * 0.01));
  }
}

}  // namespace perp
