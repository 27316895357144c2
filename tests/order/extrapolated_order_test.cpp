// Orders of the extrapolated step, two-sided, on motions that are known.
#include <catch2/catch.hpp>

#include "perp/model/gaps.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/extrapolated.hpp"
#include "perp/study/convergence.hpp"
#include "tests/order/ladder.hpp"

namespace perp {
namespace {

struct Observed {
  double order = not_set;
  int points = 0;
};

/// The slope through the smallest errors, six at most, of those between `floor` and 1e-3 of `size`.
Observed slope(const std::vector<int>& counts, const std::vector<double>& errors, double size, double floor) {
  std::vector<int> n;
  std::vector<double> e;
  for (std::size_t i = counts.size(); i-- > 0 && n.size() < 6;) {
    if (!(errors[i] > floor * size && errors[i] < 1e-3 * size)) continue;
    n.push_back(counts[i]);
    e.push_back(errors[i]);
  }
  return {.order = n.size() >= 4 ? order_of(n, e) : not_set, .points = static_cast<int>(n.size())};
}

struct Orders {
  Observed q, v;
};

/// Steps T/n, n growing by a fifth, until both errors are rounding.
Orders observed(const Scene& s, int order, double T, double floor) {
  const State exact = s.exact(T);
  Extrapolated stepper({.order = order});
  const double size = std::max(1.0, exact.q.lpNorm<Eigen::Infinity>());
  const double speed = std::max(1.0, exact.nu.lpNorm<Eigen::Infinity>());
  std::vector<int> counts;
  std::vector<double> q, v;
  for (int n = 8; n < 3000; n = std::max(n + 1, n * 6 / 5)) {
    const State end = run(s, stepper, T, n);
    counts.push_back(n);
    q.push_back(distance(s.model, end, exact));
    v.push_back(velocity_error(s.model, end, exact));
    if (q.back() < floor * size && v.back() < floor * speed) break;
    if (order < 6 && q.back() < 1e-9 * size && v.back() < 1e-9 * speed) break;  // enough of them
  }
  return {slope(counts, q, size, floor), slope(counts, v, speed, floor)};
}

Orders observed(const char* name, int order, double T, double floor = 1e-12) {
  return observed(scene(name), order, T, floor);
}

/// Two balls of 1 kg and radius .2 m on one vertical line, a spring between their centres, above a floor.
struct Balls {
  static constexpr double stiffness = 1e4, length = 1, radius = 0.2, e = 0.8, gravity = 9.81;
  long double t = 0, z1 = 1, v1 = 0, z2 = 2, v2 = 0;

  /// In flight: the centre of mass falls, and what the spring is longer than its length is a harmonic oscillation.
  Balls after(long double dt) const {
    const long double w = std::sqrt(2.0L * stiffness), c = (z1 + z2) / 2, u = (v1 + v2) / 2;
    const long double r = z2 - z1 - length, s = v2 - v1, C = std::cos(w * dt), S = std::sin(w * dt);
    const long double g = gravity, fallen = c + dt * (u - g * dt / 2), falls = u - g * dt;
    const long double r_then = r * C + s / w * S, s_then = s * C - r * w * S;
    return {t + dt, fallen - (length + r_then) / 2, falls - s_then / 2, fallen + (length + r_then) / 2,
            falls + s_then / 2};
  }

  /// At T, by the flights' own formula and bisection for the times between them.
  Balls at(long double T, int& impacts) const {
    Balls b = *this;
    constexpr long double look = 1e-5L;
    while (b.t < T) {
      Balls next = b.after(std::min(look, T - b.t));
      if (next.z1 < radius) {
        long double low = 0, high = next.t - b.t;
        for (int i = 0; i < 100; ++i) {
          const long double middle = (low + high) / 2;
          (b.after(middle).z1 < radius ? high : low) = middle;
        }
        next = b.after(high);
        if (next.v1 < 0) next.v1 *= -e, ++impacts;
      }
      b = next;
    }
    return b;
  }
};

struct BallsScene {
  Scene scene;
  Balls balls;
  BallsScene() {
    Model& m = scene.model;
    m.set_gravity({0, 0, -Balls::gravity});
    const BodyId low = m.add_body(Inertia::solid_sphere(1, Balls::radius), {.pose = {.p = {0, 0, 1}}});
    const BodyId top = m.add_body(Inertia::solid_sphere(1, Balls::radius), {.pose = {.p = {0, 0, 2}}});
    m.add_contact(ground, low, sphere_on_plane(Balls::radius), {.mu = 0, .e = Balls::e, .name = "floor"});
    m.add_spring({.a = low, .b = top, .stiffness = Balls::stiffness, .length = Balls::length});
    scene.start = m.rest();
  }
  State at(double T, int& impacts) const {
    const Balls b = balls.at(T, impacts);
    State x = scene.start;
    x.t = T;
    scene.model.set_position(x, {1}, {0, 0, static_cast<double>(b.z1)});
    scene.model.set_position(x, {2}, {0, 0, static_cast<double>(b.z2)});
    scene.model.set_velocity(x, {1}, {0, 0, static_cast<double>(b.v1)});
    scene.model.set_velocity(x, {2}, {0, 0, static_cast<double>(b.v2)});
    return x;
  }
};

void check(const Orders& found, int order) {
  CAPTURE(order, found.q.points, found.v.points);
  CHECK(found.q.order == Approx(order).margin(0.3));
  CHECK(found.v.order == Approx(order).margin(0.3));
}

/// A motion that is not known, against `event` at 1e-13.
Scene by_event(Scene s, double T) {
  EventDriven event({.rtol = 1e-13});
  const State end = simulate(s.model, event, s.start, {.t_end = T}).back();
  s.exact = [end](double) { return end; };
  return s;
}

/// A rod that carries two spheres slides down a cylinder that lies along it.
Scene rod_in_cylinder() {
  Scene s;
  const BodyId rod = s.model.add_body(Inertia::solid_box(1, {0.1, 0.8, 0.1}));
  for (const double y : {-0.3, 0.3})
    s.model.add_contact(
        ground, rod, placed(sphere_in_cylinder(1, 0.1, Vector3::UnitY()), {}, {.p = {0, y, 0}}), {.mu = 0.3});
  s.start = s.model.rest();
  s.model.set_position(s.start, rod, 0.9 * Vector3(std::sin(1.2), 0, -std::cos(1.2)));
  return s;
}

/// An ellipsoid that rolls on a plane without slipping, round all of its axes.
Scene rolling_ellipsoid() {
  Scene s;
  const Vector3 axes(0.3, 0.2, 0.1), w(1, 4, 0.5);
  const BodyId body = s.model.add_body(Inertia::solid_box(1, 2 * axes));
  s.model.add_contact(ground, body, ellipsoid_on_plane(axes), {.mu = 5});
  s.start = s.model.rest();
  s.model.set_position(s.start, body, {0, 0, axes.z()});
  s.model.set_velocity(s.start, body, w.cross(Vector3(0, 0, axes.z())), w);
  return s;
}

}  // namespace

TEST_CASE(
    "The extrapolated step has orders 4, 6 and 8 where a contact rolls, a joint swings and friction turns",
    "[order]") {
  const int order = GENERATE(4, 6, 8);
  const auto [name, T] = GENERATE(
      table<const char*, double>({{"rolling-ellipse", 0.5}, {"double-pendulum", 0.6}, {"cross-incline", 1}}));
  CAPTURE(name);
  check(observed(name, order, T), order);
}

TEST_CASE("The extrapolated step has orders 2, 4, 6 and 8 on nine smooth scenes", "[order][slow]") {
  const int order = GENERATE(2, 4, 6, 8);
  // longer than the scenes' own times where the window holds fewer than four steps, or an error passes zero
  const auto [name, T, floor] = GENERATE(table<const char*, double, double>({{"rolling-ellipse", 0.5, 1e-12},
                                                                             {"bowl", 0.6, 1e-12},
                                                                             {"roller-in-cylinder", 1, 3e-13},
                                                                             {"double-pendulum", 0.6, 1e-12},
                                                                             {"heavy-top", 0.3, 1e-12},
                                                                             {"turntable", 3, 1e-12},
                                                                             {"cross-incline", 1, 1e-12},
                                                                             {"bead-in-ring", 1, 1e-12},
                                                                             {"dzhanibekov", 3, 1e-12}}));
  CAPTURE(name);
  check(observed(name, order, T, floor), order);
}

TEST_CASE(
    "The extrapolated step has its order in a loop, on two spheres of one rod, and under a rolling ellipsoid",
    "[order][slow]") {
  if (!has_sundials()) return;
  const int order = GENERATE(4, 6, 8);
  SECTION("four-bar") { check(observed("four-bar", order, 0.6, 3e-12), order); }
  SECTION("rod in a cylinder, slipping up to .143 s") {
    check(observed(by_event(rod_in_cylinder(), 0.6), order, 0.6, 3e-12), order);
  }
  SECTION("ellipsoid") { check(observed(by_event(rolling_ellipsoid(), 1), order, 1, 3e-12), order); }
}

TEST_CASE("A box that slides straight on its four corners is where it should be, by steps of any order",
          "[order]") {
  const Scene s = scene("sliding-cube");
  for (const int order : {2, 4, 6, 8}) {
    Extrapolated stepper({.order = order});
    for (const int n : {2, 5, 20})
      CHECK(distance(s.model, run(s, stepper, s.t_end, n), s.exact(s.t_end)) < 1e-12);
  }
}

TEST_CASE("Orders 2, 4, 6 and 8 hold through the impacts of two balls tied by a spring", "[order]") {
  const BallsScene two;
  constexpr double T = 1;
  int impacts = 0;
  const State exact = two.at(T, impacts);
  const int order = GENERATE(2, 4, 6, 8);
  CAPTURE(order, impacts);
  CHECK(impacts >= 2);
  Extrapolated stepper({.order = order});
  std::vector<int> counts;
  std::vector<double> q, v;
  for (int n = 60; n < 9000; n = n * 6 / 5) {
    const Trajectory rows = simulate(two.scene.model, stepper, two.scene.start, {.t_end = T, .h = T / n});
    counts.push_back(n);
    q.push_back(distance(two.scene.model, rows.back(), exact));
    v.push_back(velocity_error(two.scene.model, rows.back(), exact));
    if (q.back() < 1e-11) break;
  }
  // velocities are measured by the spring's, some 100 m/s of a metre; positions approach their order from above
  const Observed in_q = slope(counts, q, 1, 1e-11), in_v = slope(counts, v, 100, 1e-12);
  CHECK(in_q.order > order - 0.3);
  CHECK(in_q.order < order + 0.7);
  CHECK(in_v.order == Approx(order).margin(0.3));
}

TEST_CASE("Two balls tied by a spring bounce where their formula says, to the tolerance", "[order]") {
  const BallsScene two;
  int impacts = 0;
  const State exact = two.at(1, impacts);
  Extrapolated stepper({.rtol = 1e-11});
  const Trajectory rows = simulate(two.scene.model, stepper, two.scene.start, {.t_end = 1});
  CHECK(distance(two.scene.model, rows.back(), exact) < 1e-9);
  const auto struck = std::count_if(rows.events.begin(), rows.events.end(),
                                    [](const Event& e) { return e.kind == EventKind::Impact; });
  CHECK(struck == impacts);
}

}  // namespace perp
