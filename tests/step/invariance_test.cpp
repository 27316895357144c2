// The same motion in other units, in other axes, in another order of bodies, at another time of asking.
#include <catch2/catch.hpp>
#include <clocale>
#include <random>

#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

/// A ball that slides, turns and falls onto a tilted plane and a wall, in units of `length` metres and `mass` kilograms,
/// the whole scene turned by R.
struct Thrown {
  Model model;
  BodyId ball;
  State x;
  Thrown(double length, double mass, const Quaternion& R) {
    const double m = 1 / length, kg = 1 / mass;  // one metre, one kilogram in these units
    model.set_gravity(R * Vector3(0.3 * m, 0.2 * m, -9.81 * m));
    ball = model.add_body(Inertia::principal(2 * kg, kg * m * m * Vector3(0.1, 0.12, 0.15)));
    model.add_contact(ground, ball, sphere_on_plane(0.4 * m, {R * Vector3::UnitZ(), Vector3::Zero()}),
                      {.mu = 0.3, .tangent = R * Vector3(1, 0.2, 0)});
    model.add_contact(ground, ball,
                      sphere_on_plane(0.4 * m, {R * -Vector3::UnitX(), R * Vector3(1.2 * m, 0, 0)}),
                      {.mu = 0.2, .e = 0.5, .tangent = R * Vector3(0, 1, 0.3)});
    x = model.rest();
    model.set_orientation(x, ball, R * rotation({0.3, 0.2, 0.1}) * R.conjugate());
    model.set_position(x, ball, R * Vector3(0, 0, 0.5 * m));
    model.set_velocity(x, ball, R * Vector3(2 * m, 0.5 * m, -1 * m), R * Vector3(3, -2, 5));
  }
};

Trajectory run(const Model& model, const State& x) {
  LcpStepper stepper;
  return simulate(model, stepper, x, {.t_end = 1, .h = 1e-3});
}

}  // namespace

TEST_CASE("a scene in millimetres and grams moves as in metres and kilograms", "[invariance]") {
  const Quaternion I = Quaternion::Identity();
  const Thrown si(1, 1, I), small(1e-3, 1e-3, I);
  const Trajectory a = run(si.model, si.x), b = run(small.model, small.x);
  double worst = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    worst = std::max(worst, (a.state(k).nu.head<3>() - 1e-3 * b.state(k).nu.head<3>()).norm() +
                                (a.state(k).q.head<3>() - 1e-3 * b.state(k).q.head<3>()).norm());
  CHECK(worst < 1e-10);
  CHECK(si.model.position(a.back(), si.ball).x() < 0.8);  // it met the wall
}

TEST_CASE("a scene turned with its tangent directions moves the same way, turned", "[invariance]") {
  // the body is turned too: same body axes relative to the scene, so its inertia is isotropic or the orientation counts
  const Quaternion R = rotation({0.7, -0.4, 1.1});
  const Thrown straight(1, 1, Quaternion::Identity());
  Thrown turned(1, 1, R);
  turned.model.set_orientation(turned.x, turned.ball, R * straight.model.pose(straight.x, straight.ball).q);
  turned.model.set_velocity(turned.x, turned.ball, R * straight.model.velocity(straight.x, straight.ball),
                            R * straight.model.angular_velocity(straight.x, straight.ball));
  const Trajectory a = run(straight.model, straight.x), b = run(turned.model, turned.x);
  double worst = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    worst = std::max(worst, (R * straight.model.position(a.state(k), straight.ball) -
                             turned.model.position(b.state(k), turned.ball))
                                .norm());
  CHECK(worst < 1e-10);
}

TEST_CASE("bodies in another order move the same way", "[invariance]") {
  // a frictionless heap of spheres falls together on a plane
  const int n = 8;
  const auto heap = [&](bool reversed) {
    Model model;
    std::vector<BodyId> ball(static_cast<std::size_t>(n));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-0.2, 0.2);
    std::vector<Vector3> place, speed;
    for (int i = 0; i < n; ++i) {
      place.emplace_back(uniform(random), uniform(random), 0.6 + 1.05 * i);
      speed.emplace_back(uniform(random), uniform(random), uniform(random));
    }
    for (int j = 0; j < n; ++j) {
      const int i = reversed ? n - 1 - j : j;
      ball[static_cast<std::size_t>(i)] = model.add_body(Inertia::solid_sphere(1 + 0.1 * i, 0.5));
    }
    for (const BodyId b : ball) model.add_contact(ground, b, sphere_on_plane(0.5));
    for (std::size_t i = 0; i < ball.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) model.add_contact(ball[j], ball[i], sphere_on_sphere(0.5, 0.5));
    State x = model.rest();
    for (std::size_t i = 0; i < ball.size(); ++i) {
      model.set_position(x, ball[i], place[i]);
      model.set_velocity(x, ball[i], speed[i]);
    }
    const Trajectory all = run(model, x);
    std::vector<Vector3> path;
    int closed = 0;
    for (std::size_t k = 0; k < all.size(); ++k)
      for (const BodyId b : ball) path.push_back(model.position(all.state(k), b));
    for (std::size_t k = 0; k < all.steps(); ++k)
      for (const ContactRow& row : all.report(k).contacts) closed += row.p_n > 0;
    return std::pair(path, closed);
  };
  const auto [forth, closed] = heap(false);
  const auto [back, closed_back] = heap(true);
  double worst = 0;
  for (std::size_t i = 0; i < forth.size(); ++i) worst = std::max(worst, (forth[i] - back[i]).norm());
  CHECK(worst < 1e-10);
  CHECK(closed > 1000);
}

TEST_CASE("the same run gives the same bits again, from a used stepper too, and under another locale",
          "[invariance]") {
  const Thrown s(1, 1, Quaternion::Identity());
  LcpStepper stepper;
  const Trajectory first = simulate(s.model, stepper, s.x, {.t_end = 1, .h = 1e-3});
  const Trajectory second = simulate(s.model, stepper, s.x, {.t_end = 1, .h = 1e-3});
  std::setlocale(LC_ALL, "de_DE.UTF-8");
  const Trajectory third = run(s.model, s.x);
  std::setlocale(LC_ALL, "C");
  bool same = true;
  for (std::size_t k = 0; k < first.size(); ++k)
    same = same && first.state(k).q == second.state(k).q && first.state(k).nu == second.state(k).nu &&
           first.state(k).q == third.state(k).q && first.state(k).nu == third.state(k).nu;
  CHECK(same);
}
