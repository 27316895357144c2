#include "scenes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace peers {
namespace {

constexpr double g = 9.81;
const double pi = std::acos(-1.0);

/// A solid sphere of 1 kg and 1 m on the floor: slides by Coulomb's law until its lowest point rests, then rolls. The
/// slip's direction is constant, since the friction's force and its moment both lie along it.
Scene sphere(const std::string& name, const Vec& v, const Vec& w, double t_end) {
  Scene s{.name = name,
          .bodies = {{.radius = 1, .x = {0, 0, 1}, .v = v, .w = w}},
          .floor = true,
          .mu = 0.2,
          .t_end = t_end};
  s.end = [=, mu = s.mu] {
    const Vec slip{v[0] - w[1], v[1] + w[0], 0};
    const double sliding = std::min(t_end, norm(slip) / (3.5 * mu * g));
    const Vec a = -mu * g / norm(slip) * slip, rolling = v + sliding * a;
    return std::vector<Vec>{Vec{0, 0, 1} + sliding * v + 0.5 * sliding * sliding * a +
                            (t_end - sliding) * rolling};
  };
  return s;
}

/// A cube of 1 kg and 1 m that slides flat, .3 rad off its edges, and stops.
Scene sliding_box() {
  const Vec along{std::cos(0.3), std::sin(0.3), 0};
  Scene s{.name = "sliding-box",
          .bodies = {{.half = {0.5, 0.5, 0.5}, .x = {0, 0, 0.5}, .v = 3 * along}},
          .floor = true,
          .mu = 0.3,
          .t_end = 1.5};
  s.end = [=, mu = s.mu] { return std::vector<Vec>{Vec{0, 0, 0.5} + 9 / (2 * mu * g) * along}; };
  return s;
}

/// The cube on a slope of tangent .31 with mu = .3: the slope is a gravity that leans, .3 rad off the edges.
Scene slope() {
  const Vec along{std::cos(0.3), std::sin(0.3), 0};
  const double lean = std::atan(0.31);
  Scene s{.name = "slope",
          .bodies = {{.half = {0.5, 0.5, 0.5}, .x = {0, 0, 0.5}}},
          .floor = true,
          .mu = 0.3,
          .t_end = 2};
  s.gravity = g * std::sin(lean) * along - Vec{0, 0, g * std::cos(lean)};
  s.end = [=, mu = s.mu, t = s.t_end] {
    return std::vector<Vec>{Vec{0, 0, 0.5} +
                            0.5 * t * t * g * (std::sin(lean) - mu * std::cos(lean)) * along};
  };
  return s;
}

/// Ten cubes of 1 kg at rest, the last of them `ratio` times heavier.
Scene stack(const std::string& name, double ratio) {
  Scene s{.name = name, .floor = true, .mu = 0.5, .t_end = 5};
  for (int i = 0; i < 10; ++i)
    s.bodies.push_back({.half = {0.5, 0.5, 0.5}, .mass = i == 9 ? ratio : 1, .x = {0, 0, 0.5 + i}});
  s.end = [bodies = s.bodies] {
    std::vector<Vec> rest;
    for (const Body& b : bodies) rest.push_back(b.x);
    return rest;
  };
  return s;
}

/// Angles from the vertical of one or two equal rods of 1 kg and 1 m that hang from each other, and their rates.
using Swing = std::array<long double, 4>;

Swing rate(const Swing& y, bool two, long double I) {
  const long double l = 1, c = 0.5L, m = 1, G = 9.81L;
  if (!two) return {y[2], 0, -m * G * c * std::sin(y[0]) / (I + m * c * c), 0};
  const long double cd = std::cos(y[0] - y[1]), sd = std::sin(y[0] - y[1]);
  const long double A = I + m * c * c + m * l * l, B = m * l * c * cd, C = I + m * c * c;
  const long double p = -m * l * c * sd * y[3] * y[3] - m * (c + l) * G * std::sin(y[0]);
  const long double q = m * l * c * sd * y[2] * y[2] - m * c * G * std::sin(y[1]), det = A * C - B * B;
  return {y[2], y[3], (C * p - B * q) / det, (A * q - B * p) / det};
}

/// Rods let go at `angle` from the vertical; the end by Runge and Kutta's fourth order in angles, 200,000 steps.
Scene pendulum(const std::string& name, int links, double angle) {
  Scene s{.name = name, .t_end = 5};
  const Vec along{std::sin(angle), 0, -std::cos(angle)};
  for (int i = 0; i < links; ++i) {
    s.bodies.push_back({.half = {0.05, 0.05, 0.5},
                        .x = (i + 0.5) * along,
                        .q = {std::cos(angle / 2), 0, -std::sin(angle / 2), 0}});
    s.hinges.push_back({i - 1, i, double(i) * along, {0, 1, 0}});
  }
  s.end = [=, I = s.bodies[0].inertia()[1], t = s.t_end] {
    const int n = 200'000;
    const long double h = static_cast<long double>(t) / n;
    Swing y{angle, links == 2 ? angle : 0, 0, 0};
    const auto beyond = [](const Swing& from, long double step, const Swing& k) {
      Swing z = from;
      for (std::size_t i = 0; i < 4; ++i) z[i] += step * k[i];
      return z;
    };
    for (int i = 0; i < n; ++i) {
      const Swing a = rate(y, links == 2, I), b = rate(beyond(y, h / 2, a), links == 2, I);
      const Swing c = rate(beyond(y, h / 2, b), links == 2, I), d = rate(beyond(y, h, c), links == 2, I);
      for (std::size_t j = 0; j < 4; ++j) y[j] += h / 6 * (a[j] + 2 * b[j] + 2 * c[j] + d[j]);
    }
    const auto rod = [&](std::size_t i, double length) {
      return Vec{length * double(std::sin(y[i])), 0, -length * double(std::cos(y[i]))};
    };
    std::vector<Vec> centres{rod(0, 0.5)};
    if (links == 2) centres.push_back(rod(0, 1) + rod(1, 0.5));
    return centres;
  };
  return s;
}

}  // namespace

double norm(const Vec& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

Vec turned(const Quat& q, const Vec& v) {
  const auto cross = [](const Vec& a, const Vec& b) {
    return Vec{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Vec u{q[1], q[2], q[3]}, t = 2 * cross(u, v);
  return v + q[0] * t + cross(u, t);
}

Vec turned_back(const Quat& q, const Vec& v) { return turned({q[0], -q[1], -q[2], -q[3]}, v); }

Vec Body::inertia() const {
  const double ball = 0.4 * mass * radius * radius;
  if (sphere()) return {ball, ball, ball};
  const double x = half[0] * half[0], y = half[1] * half[1], z = half[2] * half[2];
  return {mass / 3 * (y + z), mass / 3 * (x + z), mass / 3 * (x + y)};
}

const std::vector<std::string>& scene_names() {
  static const std::vector<std::string> names{"seed-sphere", "oblique-sphere", "sliding-box",
                                              "slope",       "stack",          "heavy-stack",
                                              "pendulum",    "double-pendulum"};
  return names;
}

Scene scene(const std::string& name) {
  if (name == "seed-sphere") return sphere(name, {2, 0, 0}, {0, 0, 0}, 0.6);
  if (name == "oblique-sphere") return sphere(name, {2, 1, 0}, {3, -4, 5}, 1.5);
  if (name == "sliding-box") return sliding_box();
  if (name == "slope") return slope();
  if (name == "stack") return stack(name, 1);
  if (name == "heavy-stack") return stack(name, 1000);
  if (name == "pendulum") return pendulum(name, 1, pi / 2);
  if (name == "double-pendulum") return pendulum(name, 2, pi / 3);
  throw std::invalid_argument("no scene '" + name + "'");
}

}  // namespace peers
