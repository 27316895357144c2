// The scene files in examples/: each runs, and does what mechanics says.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "perp/io/scene_file.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

Scene example(const std::string& name, const SceneParameters& set = {}) {
  const std::filesystem::path folder =
      std::filesystem::path(PERP_TEST_FOLDER) / ".." / ".." / "examples" / "scenes";
  return load_scene((folder / (name + ".toml")).string(), set);
}

/// The state at the scene's end, after steps of h.
State end_of(const Scene& s, double h) {
  LcpStepper stepper;
  return simulate(s.model, stepper, s.start, {.t_end = s.t_end, .h = h}).back();
}

}  // namespace

TEST_CASE("the marble rolls to the edge, leaves it level, and falls in a parabola", "[scene_file]") {
  const Scene s = example("marble-off-table");
  const BodyId marble = s.model.find_body("marble");
  const double h = 1e-3, v = 0.5, fall = 0.7 - 0.2 / v;  // v^2 > g r: it does not turn about the edge
  const State x = end_of(s, h);
  const Vector3 p = s.model.position(x, marble), u = s.model.velocity(x, marble);
  CHECK(p.x() == Approx(0.5 + v * fall).margin(2 * v * h));
  CHECK(p.z() == Approx(0.01 - 9.81 / 2 * fall * fall).margin(2 * 9.81 * fall * h));
  CHECK(u.x() == Approx(v).margin(1e-9));
  CHECK(u.z() == Approx(-9.81 * fall).margin(2 * 9.81 * h));
  CHECK(s.model.angular_velocity(x, marble).y() == Approx(v / 0.01).margin(1e-9));

  const State slow = end_of(example("marble-off-table", {{"v", 0.25}}), h);  // still on the table
  CHECK(s.model.position(slow, marble).x() == Approx(0.475).margin(1e-12));
  CHECK(s.model.position(slow, marble).z() == Approx(0.01).margin(1e-12));
}

TEST_CASE("the shaken pendulum follows its equation of motion, and a rougher hinge takes more",
          "[scene_file]") {
  // J phi'' = -m c (g sin phi + a(t) cos phi) + tau while it swings back (phi' < 0), phi from hanging towards +x
  const double m = 1, l = 0.5, r = 0.01, c = l / 2, J = m * (3 * r * r + l * l) / 12 + m * c * c, A = 0.02,
               w = 15, tau = 0.1;
  double phi = M_PI / 3, rate = 0;
  const int n = 50000;
  const double k = 0.5 / n;
  const auto acceleration = [&](double t, double angle) {
    const double support = -A * w * w * std::sin(w * t);
    return (-m * c * (9.81 * std::sin(angle) + support * std::cos(angle)) + tau) / J;
  };
  for (int i = 0; i < n; ++i) {  // the midpoint rule, error about k^2
    const double half_phi = phi + k / 2 * rate, half_rate = rate + k / 2 * acceleration(i * k, phi);
    phi += k * half_rate;
    rate += k * acceleration((i + 0.5) * k, half_phi);
    if (i > n / 100) REQUIRE(rate < 0);
  }
  const Scene s = example("shaken-pendulum");
  const BodyId rod = s.model.find_body("rod");
  const auto angle_error = [&](double h) {
    const State x = end_of(s, h);
    return -rotation_vector(s.model.pose(x, rod).q).y() - phi;
  };
  const double coarse = angle_error(2e-3), fine = angle_error(1e-3);
  CHECK(std::abs(fine) < 5e-3);
  CHECK(coarse / fine > 1.6);  // a method of first order
  CHECK(coarse / fine < 2.4);
  const State x = end_of(s, 1e-3);
  const Vector3 hinge = s.model.pose(x, rod) * Vector3(0, 0, c);
  CHECK((hinge - Vector3(A * std::sin(w * 0.5), 0, 0)).norm() < 1e-5);
}

TEST_CASE("the box slides on the belt with mu g and then travels with it", "[scene_file]") {
  const Scene s = example("box-on-belt");
  const BodyId box = s.model.find_body("box");
  const double h = 1e-3, sliding = 1 / (0.4 * 9.81);
  const State x = end_of(s, h);
  CHECK(s.model.velocity(x, box).x() == Approx(1).margin(1e-10));
  CHECK(s.model.position(x, box).x() == Approx(1 - sliding / 2).margin(h));
  CHECK(s.model.position(x, box).z() == Approx(0.05).margin(1e-12));
  const State slippery = end_of(example("box-on-belt", {{"mu", 0.05}}), h);  // does not get there in 1 s
  CHECK(s.model.velocity(slippery, box).x() == Approx(0.05 * 9.81).margin(1e-9));
}
