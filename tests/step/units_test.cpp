// The same scene in other units is the same motion to rounding: lengths 1e-9 ... 1e9, masses 1e-18 ... 1e18, times by the root of length.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "perp/model/gaps.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "tests/step/newton_cases.hpp"

using namespace perp;

namespace {

struct Scaled {
  Model model;
  State x;
  double h = 0.01;  // at L = 1
  int steps = 60;
};

Scaled seed_sphere(double L, double M) {
  Scaled s;
  const BodyId ball = s.model.add_body(Inertia::solid_sphere(M, L));
  s.model.add_contact(ground, ball, sphere_on_plane(L), {.mu = 0.2});
  s.x = s.model.rest();
  s.model.set_position(s.x, ball, {0, 0, L});
  s.model.set_velocity(s.x, ball, {2 * std::sqrt(L), 0, 0});
  return s;
}

/// Three boxes, each smaller than the one below, the middle one lighter; the lowest is pushed and slides under the others.
Scaled stack(double L, double M) {
  Scaled s;
  s.steps = 30;
  const double masses[] = {1, 0.3, 2};
  BodyId below = ground;
  Vector3 below_size;
  std::vector<BodyId> boxes;
  double top = 0;
  for (int i = 0; i < 3; ++i) {
    const Vector3 size = (1 - 0.2 * i) * Vector3(L, L, L);
    const BodyId box =
        s.model.add_body(Inertia::solid_box(M * masses[i], size),
                         {.pose = {{0.01 * i * L, 0, top + 0.5 * size.z()}, Quaternion::Identity()}});
    s.model.add_contact(below, box, i == 0 ? box_on_plane(size) : box_on_box(below_size, size), {.mu = 0.3});
    boxes.push_back(below = box);
    below_size = size;
    top += size.z();
  }
  s.x = s.model.rest();
  s.model.set_velocity(s.x, boxes[0], {std::sqrt(L), 0, 0});
  return s;
}

/// Three bars on the ground, in the plane, with dry friction in one joint.
Scaled four_bar(double L, double M) {
  Scaled s;
  const Vector2 pins[] = {{0, 0}, {0.3, 1}, {2.1, 1.4}, {2.5, 0}};
  std::vector<BodyId> bars{ground};
  for (int i = 0; i < 3; ++i) {
    const Vector2 d = L * (pins[i + 1] - pins[i]), c = 0.5 * L * (pins[i + 1] + pins[i]);
    const double m = M * d.norm() / L;
    bars.push_back(s.model.add_planar_body(m, m * d.squaredNorm() / 12,
                                           {.pose = {{c.x(), c.y(), 0}, Quaternion::Identity()}}));
  }
  s.model.set_gravity({0, -9.81, 0});
  for (std::size_t i = 0; i < 4; ++i) {
    const double friction = i == 1 ? 0.1 * M * 9.81 * L : 0;
    s.model.add_joint(revolute(bars[i], i == 3 ? ground : bars[i + 1],
                               {.point = {L * pins[i].x(), L * pins[i].y(), 0}, .friction = friction}));
  }
  s.x = s.model.rest();
  return s;
}

Scaled rod_in_cylinder(double L, double M) {
  Scaled s;
  const double R = 1, r = 0.1, half = 0.6, tilt = 0.2, reach = std::sqrt((R - r) * (R - r) - half * half);
  const BodyId body = s.model.add_body(Inertia::principal(M, M * L * L * Vector3(0.13, 0.13, 0.01)));
  for (const double side : {-1.0, 1.0})
    s.model.add_contact(
        ground, body, testing::offset_sphere_in_cylinder(L * R, L * r, {0, 0, side * L * half}), {.mu = 0.3});
  s.x = s.model.rest();
  s.model.set_orientation(s.x, body, rotation({std::numbers::pi / 2 + tilt, 0, 0}));
  s.model.set_position(s.x, body, L * Vector3(0, std::sin(tilt) * reach, -std::cos(tilt) * reach));
  s.model.set_velocity(s.x, body, std::sqrt(L) * Vector3(0.7, 0, 0), Vector3(0.1, 0, 0.2) / std::sqrt(L));
  return s;
}

/// Lengths over L, velocities over root L, rates times root L.
Vector in_own_units(const Scaled& s, const State& x, double L) {
  std::vector<double> all;
  for (const Body& b : s.model.bodies()) {
    if (b.nv == 0) continue;
    const int linear = b.kind == BodyKind::Planar ? 2 : 3;
    for (int i = 0; i < b.nq; ++i) all.push_back(x.q[b.q0 + i] / (i < linear ? L : 1));
    for (int i = 0; i < b.nv; ++i)
      all.push_back(x.nu[b.v0 + i] * (i < linear ? 1 / std::sqrt(L) : std::sqrt(L)));
  }
  return Eigen::Map<Vector>(all.data(), static_cast<Eigen::Index>(all.size()));
}

Vector motion(const std::function<Scaled(double, double)>& make, const char* method, double L, double M) {
  const Scaled s = make(L, M);
  const auto stepper = make_stepper(method);
  const double h = s.h * std::sqrt(L);
  const Trajectory run = simulate(s.model, *stepper, s.x, {.t_end = s.steps * h, .h = h});
  return in_own_units(s, run.back(), L);
}

}  // namespace

TEST_CASE("a scene in other units moves alike to nine digits", "[units]") {
  const std::pair<const char*, Scaled (*)(double, double)> scenes[] = {
      {"seed-sphere", seed_sphere},
      {"stack", stack},
      {"four-bar", four_bar},
      {"rod in a cylinder", rod_in_cylinder}};
  int compared = 0;
  for (const auto& [name, make] : scenes)
    for (const char* method : {"lcp", "ncp", "ncp2"}) {
      const Vector here = motion(make, method, 1, 1);
      for (const auto& [L, M] : {std::pair(1e-9, 1e-18), std::pair(1e-9, 1e18), std::pair(1e-4, 1.0),
                                 std::pair(1e5, 1e-9), std::pair(1e9, 1e18)}) {
        CAPTURE(name, method, L, M);

        const Vector there = motion(make, method, L, M);
        CHECK((there - here).lpNorm<Eigen::Infinity>() < 1e-9 * here.lpNorm<Eigen::Infinity>());
        ++compared;
      }
    }
  CHECK(compared == 60);
}
