// Friction that depends on direction: an ellipse whose axes turn with one of the two bodies.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

constexpr double g = 9.81, mu_t = 0.2, mu_o = 0.6;

/// A block without height on a slope that falls along x; its axes are fixed to `of`, t at the angle `phi` from x.
struct Block {
  Model model;
  BodyId body;
  State start;

  Block(FrictionAxes::Of of, double slope, double phi, const Vector3& v, double w) {
    model.set_gravity({g * std::sin(slope), 0, -g * std::cos(slope)});
    body = model.add_body(Inertia::principal(1, {0.01, 0.01, 0.02}), {.name = "block"});
    model.add_contact(ground, body, point_on_plane(Vector3::Zero()),
                      {.friction_axes = FrictionAxes{
                           .mu = {mu_t, mu_o}, .of = of, .t = {std::cos(phi), std::sin(phi), 0}}});
    start = model.rest();
    model.set_velocity(start, body, v, {0, 0, w});
  }
};

/// Place and velocity of the block at T by Runge and Kutta's method: v' = g_s - g_n A² v/|A v|, A's axes turning at w.
std::array<double, 4> slid(double slope, double phi, double w, double vx, double vy, double T) {
  constexpr int steps = 20000;
  const double h = T / steps;
  std::array<double, 4> y{0, 0, vx, vy};
  const auto rate = [&](const std::array<double, 4>& z, double t) {
    const double c = std::cos(phi + w * t), s = std::sin(phi + w * t);
    const double along = c * z[2] + s * z[3], across = -s * z[2] + c * z[3];
    const double size = std::hypot(mu_t * along, mu_o * across), n = g * std::cos(slope) / size;
    const double ft = n * mu_t * mu_t * along, fo = n * mu_o * mu_o * across;
    return std::array{z[2], z[3], g * std::sin(slope) - (c * ft - s * fo), -(s * ft + c * fo)};
  };
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const auto moved = [&](const std::array<double, 4>& k, double by) {
      std::array<double, 4> z = y;
      for (std::size_t j = 0; j < 4; ++j) z[j] += by * k[j];
      return z;
    };
    const auto a = rate(y, t), b = rate(moved(a, h / 2), t + h / 2), c = rate(moved(b, h / 2), t + h / 2),
               d = rate(moved(c, h), t + h);
    for (std::size_t j = 0; j < 4; ++j) y[j] += h / 6 * (a[j] + 2 * b[j] + 2 * c[j] + d[j]);
  }
  return y;
}

State end_of(const Block& b, const char* method, double T, double h) {
  const std::unique_ptr<Stepper> stepper = make_stepper(method, {.tolerance = 1e-11});
  SimulateOptions options{.t_end = T};
  if (!chooses_steps(*stepper)) options.h = h;
  return simulate(b.model, *stepper, b.start, options).back();
}

}  // namespace

TEST_CASE("a block stands on a slope if and only if the ellipse of its friction holds it",
          "[friction_axes]") {
  const double phi = 0.6;
  const double limit = std::atan(1 / std::hypot(std::cos(phi) / mu_t, std::sin(phi) / mu_o));
  for (const char* method : {"ncp", "ncp-start", "ncp2", "event"})
    for (const double sign : {-1.0, 1.0}) {
      // what hardly slides turns into its direction at once: a stiff equation, which `event` resolves
      const double off = sign * (std::string_view(method) == "event" ? 1e-2 : 1e-6);
      const Block block(FrictionAxes::Of::A, limit + off, phi, Vector3::Zero(), 0);
      const State x = end_of(block, method, 1, 0.05);
      CAPTURE(method, off);
      if (off < 0)
        CHECK(block.model.velocity(x, block.body).norm() < 1e-9);
      else
        CHECK(block.model.velocity(x, block.body).norm() > 1e-6);
    }
}

TEST_CASE(
    "a block slides across the axes of the slope's friction as an integration of its own says, with order 2",
    "[friction_axes]") {
  const double slope = 0.5, phi = 0.6, T = 0.4;
  const Block block(FrictionAxes::Of::A, slope, phi, {1, 1, 0}, 0);
  const auto [x, y, vx, vy] = slid(slope, phi, 0, 1, 1, T);
  const auto off = [&, x = x, y = y](double h) {
    return (block.model.position(end_of(block, "ncp2", T, h), block.body) - Vector3(x, y, 0)).norm();
  };
  CHECK(off(T / 40) < 1e-4);
  CHECK(off(T / 160) / off(T / 40) == Approx(1 / 16.0).epsilon(0.2));
  const Vector3 v = block.model.velocity(end_of(block, "event", T, 0), block.body);
  CHECK((v - Vector3(vx, vy, 0)).norm() < 1e-9);
}

TEST_CASE("friction axes that are fixed to the block turn with it", "[friction_axes]") {
  const double slope = 0.3, phi = 0.2, w = 4, T = 0.4;
  const Block block(FrictionAxes::Of::B, slope, phi, {1.5, 1, 0}, w);
  const auto [x, y, vx, vy] = slid(slope, phi, w, 1.5, 1, T);
  const auto off = [&, x = x, y = y](const char* method, double h) {
    return (block.model.position(end_of(block, method, T, h), block.body) - Vector3(x, y, 0)).norm();
  };
  CHECK(off("ncp2", T / 160) / off("ncp2", T / 40) == Approx(1 / 16.0).epsilon(0.2));
  CHECK(off("ncp", T / 160) / off("ncp", T / 40) == Approx(1 / 4.0).epsilon(0.2));
  CHECK(off("event", 0) < 1e-9);
}
