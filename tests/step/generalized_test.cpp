// Systems in coordinates of their own, beside the same made of bodies and joints.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

using namespace perp;
using Catch::Contains;

namespace {

constexpr double r = 0.15, l = 0.4, tau = 0.2, rate = 20;  // crank, rod [m]; friction [N m]; [rad/s]

/// The slider-crank of spatial bodies and revolute joints about z: 20 equations, three more than they need.
Scene spatial_slider_crank() {
  const Scene planar = scene("slider-crank");
  Scene s;
  s.model.set_gravity(Vector3::Zero());
  std::vector<BodyId> bodies{ground};
  for (const Body& b : planar.model.bodies())
    if (b.nv > 0) {
      const double J = b.J(2, 2);
      bodies.push_back(s.model.add_body(Inertia::principal(b.mass, {0.6 * J, 0.7 * J, J}),
                                        {.pose = b.rest, .name = b.name}));
    }
  for (const JointGeometry& j : planar.model.joints())
    s.model.add_joint({j.kind, bodies[static_cast<std::size_t>(j.a.index)],
                       bodies[static_cast<std::size_t>(j.b.index)], j.asked});
  s.start = s.model.rest();
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const BodyId id{static_cast<int>(i)};
    s.model.set_velocity(s.start, bodies[i], planar.model.velocity(planar.start, id),
                         planar.model.angular_velocity(planar.start, id));
  }
  return s;
}

/// The same in the crank's angle alone: I(theta) theta'' + I'/2 theta'^2 = -tau, while it turns forwards.
Scene one_coordinate() {
  const auto slope = [](double theta) {  // of the slider's place by theta, and of the slope
    const double s = std::sin(theta), c = std::cos(theta), root = std::sqrt(l * l - r * r * s * s);
    const double root_1 = -r * r * s * c / root;
    return std::pair(-r * s - r * r * s * c / root,
                     -r * c - r * r * ((c * c - s * s) / root - s * c * root_1 / (root * root)));
  };
  Scene s;
  const BodyId crank = s.model.add_generalized(
      1,
      {.mass =
           [=](const Vector& q) {
             return Matrix::Constant(1, 1, 0.01 + 0.5 * std::pow(slope(q[0]).first, 2));
           },
       .force = [=](const Vector& q, const Vector& nu, double) -> Vector {
         const auto [first, second] = slope(q[0]);
         return Vector::Constant(1, -0.5 * first * second * nu[0] * nu[0] - tau);
       }},
      "crank");
  s.start = s.model.rest();
  s.model.set_coordinates(s.start, crank, Vector::Zero(1), Vector::Constant(1, rate));
  return s;
}

}  // namespace

TEST_CASE("a slider-crank of planar bodies, of spatial ones and in one coordinate turns alike",
          "[generalized][joint]") {
  const Scene planar = scene("slider-crank"), space = spatial_slider_crank(), one = one_coordinate();
  LcpStepper stepper;
  const auto error = [&](double h) {
    const SimulateOptions options{.t_end = 0.3, .h = h};
    const State a = simulate(planar.model, stepper, planar.start, options).back();
    const Trajectory run = simulate(space.model, stepper, space.start, options);
    const State c = simulate(one.model, stepper, one.start, options).back();
    const double crank = planar.model.angle(a, planar.model.find_body("crank"));
    CHECK(space.model.coordinate(run.back(), space.model.find_joint("bearing")) ==
          Approx(crank).epsilon(1e-9));
    return c.q[0] - crank;  // a step in one coordinate is another step of first order
  };
  const double coarse = error(2e-3), fine = error(5e-4);
  CHECK(std::abs(fine) < 0.05);
  CHECK(coarse / fine == Approx(4).epsilon(0.4));
  CHECK(one.model.nv() == 1);
}

TEST_CASE("the woodpecker's cycle is that of its toy, to the order of the step", "[generalized]") {
  const Scene s = scene("woodpecker");
  LcpStepper stepper;
  const double h = 1e-4;
  State x = s.start;
  StepReport report;
  double first_t = 0, first_y = 0, last_t = 0, last_y = 0;
  int cycles = 0;
  for (int i = 1; i <= 10000; ++i) {
    const State before = x;
    stepper.step(s.model, x, {.h = h, .t_end = i * h}, report);
    REQUIRE(report.advanced());
    CHECK(report.residuals.newton_euler < 1e-12);
    if (!(before.q[2] < -0.1 && x.q[2] >= -0.1)) continue;  // the bird swings back
    const double part = (-0.1 - before.q[2]) / (x.q[2] - before.q[2]);
    last_t = before.t + part * h;
    last_y = before.q[0] + part * (x.q[0] - before.q[0]);
    if (cycles++ == 0) {
      first_t = last_t;
      first_y = last_y;
    }
  }
  REQUIRE(cycles >= 6);
  CHECK((last_t - first_t) / (cycles - 1) == Approx(0.145976).epsilon(0.02));
  CHECK((first_y - last_y) / (cycles - 1) == Approx(0.0194452).epsilon(0.07));
}

TEST_CASE("a generalized body is refused where it does not fit", "[generalized]") {
  Model model;
  const GeneralizedSystem mass{.mass = [](const Vector&) { return Matrix::Identity(2, 2); },
                               .force = [](const Vector&, const Vector&, double) { return Vector::Zero(2); }};
  CHECK_THROWS_WITH(model.add_generalized(7, mass), Contains("1 to 6"));
  CHECK_THROWS_WITH(model.add_generalized(2, {}), Contains("mass or force"));
  const BodyId body = model.add_generalized(2, mass, "toy");
  CHECK_THROWS_WITH(model.add_joint(ball(ground, body)), Contains("no pose"));
  State x = model.rest();
  CHECK_THROWS_WITH(model.set_position(x, body, {1, 0, 0}), Contains("no such coordinate"));
  CHECK_THROWS_WITH(model.set_coordinates(x, body, Vector::Zero(3), Vector::Zero(2)), Contains("2 finite"));
}
