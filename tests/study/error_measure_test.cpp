#include "perp/study/error_measure.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

using std::numbers::pi;

/// A spatial, a planar body and a particle.
struct Zoo {
  Model model;
  BodyId ball = model.add_body(Inertia::solid_sphere(1, 1), {.name = "ball"});
  BodyId disc = model.add_planar_body(1, 1, {.name = "disc"});
  BodyId bead = model.add_particle(1, {.name = "bead"});
};

/// A velocity of one component through the points given.
VelocityPath path(std::vector<double> t, std::vector<double> v) {
  VelocityPath result{.t = std::move(t), .v = Matrix(1, static_cast<Eigen::Index>(v.size()))};
  for (std::size_t i = 0; i < v.size(); ++i) result.v(0, static_cast<Eigen::Index>(i)) = v[i];
  return result;
}

}  // namespace

TEST_CASE("the configuration error is the largest of lengths, planar angles and angles of rotation",
          "[error_measure]") {
  const Zoo zoo;
  const State a = zoo.model.rest();
  const auto error = [&](auto change) {
    State b = a;
    change(b);
    CHECK(configuration_error(zoo.model, a, b) == configuration_error(zoo.model, b, a));
    return configuration_error(zoo.model, a, b);
  };
  CHECK(error([](State&) {}) == 0);
  CHECK(error([&](State& b) { zoo.model.set_position(b, zoo.ball, {0.1, -0.3, 0.2}); }) == 0.3);
  CHECK(error([&](State& b) { zoo.model.set_position(b, zoo.bead, {0, 0, -2}); }) == 2);
  CHECK(error([&](State& b) {
          zoo.model.set_orientation(b, zoo.disc, rotation({0, 0, 0.7}));
        }) == Approx(0.7).epsilon(1e-14));
  const Vector3 axis = Vector3(1, 2, -2) / 3;
  CHECK(error([&](State& b) { zoo.model.set_orientation(b, zoo.ball, rotation(0.4 * axis)); }) ==
        Approx(0.4).epsilon(1e-14));
  CHECK(error([&](State& b) { zoo.model.set_orientation(b, zoo.ball, rotation(1e-9 * axis)); }) ==
        Approx(1e-9).epsilon(1e-6));
  CHECK(error([&](State& b) { b.q.segment<4>(3) *= -1; }) == 0);  // the same orientation
  CHECK(error([&](State& b) {
          zoo.model.set_position(b, zoo.ball, {0.1, 0, 0});
          zoo.model.set_orientation(b, zoo.ball, rotation({0, 0.2, 0}));
        }) == Approx(0.2).epsilon(1e-14));
}

TEST_CASE("a rotation's error does not depend on the orientation that it starts from", "[error_measure]") {
  const Zoo zoo;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  for (int i = 0; i < 20; ++i) {
    const Quaternion from = rotation(2 * vector());
    const Vector3 turn = vector();
    State a = zoo.model.rest(), b = a;
    zoo.model.set_orientation(a, zoo.ball, from);
    zoo.model.set_orientation(b, zoo.ball, rotation(turn) * from);
    const double angle = std::fmod(turn.norm(), 2 * pi);
    CHECK(configuration_error(zoo.model, a, b) == Approx(std::min(angle, 2 * pi - angle)).epsilon(1e-12));
  }
}

TEST_CASE("the velocity error compares velocities in world axes", "[error_measure]") {
  const Zoo zoo;
  State a = zoo.model.rest(), b = a;
  zoo.model.set_orientation(b, zoo.ball, rotation({0.3, 0.2, 1}));
  for (State* x : {&a, &b}) zoo.model.set_velocity(*x, zoo.ball, {1, 2, 3}, {4, 5, 6});
  CHECK(velocity_error(zoo.model, a, b) < 1e-14);
  CHECK((a.nu - b.nu).norm() > 1);  // in their own axes they differ
  zoo.model.set_velocity(b, zoo.disc, {0, 0, 0}, {0, 0, -0.25});
  CHECK(velocity_error(zoo.model, a, b) == Approx(0.25).epsilon(1e-14));
}

TEST_CASE("errors of a state that is not finite are NaN, never small", "[error_measure]") {
  const Zoo zoo;
  const State a = zoo.model.rest();
  for (const double bad : {not_set, infinity}) {
    State b = a;
    b.q[0] = b.nu[0] = bad;
    CHECK(std::isnan(configuration_error(zoo.model, a, b)));
    CHECK(std::isnan(velocity_error(zoo.model, b, a)));
  }
  CHECK_THROWS_AS(configuration_error(zoo.model, a, State{}), std::invalid_argument);
}

TEST_CASE("the L1 distance of straight lines, of steps and of crossing lines is the area between them",
          "[error_measure]") {
  const VelocityPath zero = path({0, 3}, {0, 0});
  CHECK(l1_distance(path({0, 3}, {1, 1}), zero) == Approx(3));
  CHECK(l1_distance(path({0, 3}, {0, 3}), zero) == Approx(4.5));
  CHECK(l1_distance(path({0, 3}, {-1, 2}), zero) == Approx(0.5 + 2));       // two triangles, signs opposite
  CHECK(l1_distance(path({0, 1, 1, 3}, {0, 0, 2, 2}), zero) == Approx(4));  // a jump has no area
  const VelocityPath jump = path({0, 1, 1, 3}, {0, 0, 2, 2}), late = path({0, 1.25, 1.25, 3}, {0, 0, 2, 2});
  CHECK(l1_distance(jump, late) == Approx(0.25 * 2));  // height times how late
  CHECK(l1_distance(late, jump) == Approx(0.25 * 2));
  CHECK(l1_distance(jump, jump) == 0);
  // nodes at different times: v = t against the same line with more points
  CHECK(l1_distance(path({0, 0.1, 0.7, 3}, {0, 0.1, 0.7, 3}), path({0, 2, 3}, {0, 2, 3})) < 1e-15);
}

TEST_CASE("the L1 distance takes the component that is worst", "[error_measure]") {
  VelocityPath a{.t = {0, 2}, .v = Matrix::Zero(2, 2)}, b = a;
  b.v << 1, 1, -3, -3;
  CHECK(l1_distance(a, b) == Approx(6));
}

TEST_CASE("the graph distance of a late jump is how late it is, not how high", "[error_measure]") {
  const VelocityPath jump = path({0, 1, 1, 3}, {0, 0, 2, 2});
  for (const double late : {0.25, 0.01, 1e-6}) {
    const VelocityPath other = path({0, 1 + late, 1 + late, 3}, {0, 0, 2, 2});
    CHECK(graph_distance(jump, other, 1) == Approx(late).epsilon(1e-5));
    CHECK(graph_distance(other, jump, 1) == Approx(late).epsilon(1e-5));
    CHECK(graph_distance(jump, other, 0.5) == Approx(late / 2).epsilon(1e-5));
  }
}

TEST_CASE("the graph distance of shifted lines, of a spike and of a slanted jump is that of the plane",
          "[error_measure]") {
  const VelocityPath zero = path({0, 3}, {0, 0});
  CHECK(graph_distance(path({0, 3}, {0.5, 0.5}), zero, 1) == Approx(0.5));
  CHECK(graph_distance(path({0, 1, 1, 1, 3}, {0, 0, 2, 0, 0}), zero, 1) ==
        Approx(2));  // a spike without area
  CHECK(l1_distance(path({0, 1, 1, 1, 3}, {0, 0, 2, 0, 0}), zero) == 0);
  // a jump at 1 smeared over [1, 1.2]: the point (1, 2) is furthest from the slant, max(s, 2 - 10 s) at s = 2/11
  CHECK(graph_distance(path({0, 1, 1, 3}, {0, 0, 2, 2}), path({0, 1, 1.2, 3}, {0, 0, 2, 2}), 1) ==
        Approx(2 / 11.0).epsilon(1e-5));
  // lines that cross: v = t - 1 against 0, seen from (0, -1) and (3, 2)
  CHECK(graph_distance(path({0, 3}, {-1, 2}), zero, 1) == Approx(2));
}

TEST_CASE("the graph distance of rough paths is what a fine sampling of both graphs gives",
          "[error_measure]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto rough = [&] {
    std::vector<double> t{0}, v{uniform(random)};
    for (int i = 1; i < 12; ++i) {
      t.push_back(i == 11                 ? 1
                  : uniform(random) < 0.3 ? t.back()
                                          : t.back() + uniform(random) * (1 - t.back()) / 4);
      v.push_back(uniform(random));
    }
    return path(t, v);
  };
  const auto sampled = [](const VelocityPath& p) {
    std::vector<Vector2> points;
    for (std::size_t i = 1; i < p.t.size(); ++i)
      for (int k = 0; k <= 400; ++k) {
        const double s = k / 400.0;
        const auto c = static_cast<Eigen::Index>(i);
        points.emplace_back((1 - s) * p.t[i - 1] + s * p.t[i], (1 - s) * p.v(0, c - 1) + s * p.v(0, c));
      }
    return points;
  };
  const auto one_way = [](const std::vector<Vector2>& a, const std::vector<Vector2>& b) {
    double far = 0;
    for (const Vector2& p : a) {
      double near = infinity;
      for (const Vector2& q : b) near = std::min(near, (p - q).lpNorm<Eigen::Infinity>());
      far = std::max(far, near);
    }
    return far;
  };
  for (int i = 0; i < 3; ++i) {
    const VelocityPath a = rough(), b = rough();
    const auto pa = sampled(a), pb = sampled(b);
    CHECK(graph_distance(a, b, 1) == Approx(std::max(one_way(pa, pb), one_way(pb, pa))).margin(4e-3));
  }
}

TEST_CASE("a motion with jumps becomes a path that is as close to it as asked", "[error_measure]") {
  Model model;
  const BodyId bead = model.add_particle(1);
  const double jump = 1 / 3.0;
  const auto motion = [&](double t) {
    State x = model.rest();
    model.set_velocity(x, bead, {std::sin(5 * t), t < jump ? 1.0 : -0.5, 0});
    return x;
  };
  const VelocityPath p = velocity_path(model, motion, 0, 2, 1e-6);
  REQUIRE(p.t.front() == 0);
  REQUIRE(p.t.back() == 2);
  CHECK(p.t.size() < 5000);
  VelocityPath zero{.t = {0, 2}, .v = Matrix::Zero(3, 2)};
  const double wave =
      (3 * 2 + 1 - std::cos(10 - 3 * pi)) / 5;  // of |sin 5t| over [0, 2]: three arches and a part
  zero.v.row(1).setConstant(-0.5);
  CHECK(l1_distance(p, zero) == Approx(std::max(wave, 1.5 * jump)).epsilon(1e-5));
  zero.v.setZero();
  CHECK(l1_distance(p, zero) == Approx(std::max(wave, jump + 0.5 * (2 - jump))).epsilon(1e-5));
}

TEST_CASE("across impacts the LCP step's velocity converges with order 1 in L1 and in the graph norm",
          "[error_measure]") {
  const Scene s = scene("bouncing-ball", {{"e", 0.5}});
  const VelocityPath exact = velocity_path(s.model, s.exact, 0, 1);
  LcpStepper lcp;
  std::vector<double> l1, graph;
  for (const int n : {100, 1600}) {
    const VelocityPath run =
        velocity_path(s.model, simulate(s.model, lcp, s.start, {.t_end = 1, .h = 1.0 / n}));
    l1.push_back(l1_distance(run, exact));
    graph.push_back(graph_distance(run, exact, 9.81));
  }
  CHECK(std::log(l1[0] / l1[1]) / std::log(16) == Approx(1).margin(0.3));
  CHECK(std::log(graph[0] / graph[1]) / std::log(16) == Approx(1).margin(0.3));
}

TEST_CASE("paths over different times cannot be compared", "[error_measure]") {
  const VelocityPath a = path({0, 1}, {0, 0});
  CHECK_THROWS_AS(l1_distance(a, path({0, 2}, {0, 0})), std::invalid_argument);
  CHECK_THROWS_AS(graph_distance(a, path({0, 1, 0.5, 1}, {0, 0, 0, 0}), 1), std::invalid_argument);
  CHECK_THROWS_AS(graph_distance(a, a, 0), std::invalid_argument);
  CHECK_THROWS_AS(l1_distance(a, path({0, 1}, {0, not_set})), std::invalid_argument);
}

}  // namespace perp
