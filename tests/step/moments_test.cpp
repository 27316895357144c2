// Torsional and rolling friction: the law itself, who knows it, and what steps make of it.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/instant/derivatives.hpp"
#include "perp/model/gaps.hpp"
#include "perp/step/cp1.hpp"
#include "perp/step/impact.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"
#include "step/parts/moment_laws.hpp"
#include "tests/instant/random_systems.hpp"

using namespace perp;
using namespace perp::testing;
using Catch::Matchers::Contains;

namespace {

constexpr double g = 9.81;

/// A disc without height on a plane, its one contact point at its centre: slides and spins without tipping.
struct Disc {
  Model model;
  BodyId body;
  State start;
  double J = 0.005;

  Disc(double mu, double gamma, double v, double w) {
    body = model.add_body(Inertia::principal(1, {J / 2, J / 2, J}), {.name = "disc"});
    model.add_contact(ground, body, point_on_plane(Vector3::Zero()),
                      {.mu = mu, .torsion = gamma, .name = "floor"});
    start = model.rest();
    model.set_velocity(start, body, {v, 0, 0}, {0, 0, w});
  }
};

/// x, angle, v, w of such a disc at T, by Runge and Kutta's method on its two equations: nothing of perp.
std::array<double, 4> disc_at(const Disc& disc, double mu, double gamma, double v, double w, double T) {
  constexpr int steps = 40000;
  const double h = T / steps;
  std::array<double, 4> y{0, 0, v, w};
  const auto rate = [&](const std::array<double, 4>& z) {
    const double S = std::hypot(mu * z[2], gamma * z[3]);
    return std::array{z[2], z[3], -g * mu * mu * z[2] / S, -g * gamma * gamma / disc.J * z[3] / S};
  };
  const auto moved = [&](const std::array<double, 4>& k, double by) {
    std::array<double, 4> z = y;
    for (std::size_t i = 0; i < 4; ++i) z[i] += by * k[i];
    return z;
  };
  for (int n = 0; n < steps; ++n) {
    const auto a = rate(y), b = rate(moved(a, h / 2)), c = rate(moved(b, h / 2)), d = rate(moved(c, h));
    for (std::size_t i = 0; i < 4; ++i) y[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  return y;
}

std::vector<std::unique_ptr<Stepper>> exact_cones() {
  std::vector<std::unique_ptr<Stepper>> all;
  for (const char* name : {"ncp", "ncp-start", "ncp2"}) all.push_back(make_stepper(name));
  return all;
}

/// And the LCP, on motions along vertices of its polytope.
std::vector<std::unique_ptr<Stepper>> with_lcp() {
  auto all = exact_cones();
  all.push_back(make_stepper("lcp"));
  return all;
}

}  // namespace

TEST_CASE("moments of contacts turn with their bodies as differentiate_moments says",
          "[moments][derivatives]") {
  const auto seed = GENERATE(range(0u, 10u));
  Random random(seed);
  Model model;
  const BodyId a = model.add_body(random.inertia(), {.pose = {{0, 0, 2}, random.orientation()}});
  const BodyId b = model.add_body(random.inertia(), {.pose = {{1, 0.5, 3}, random.orientation()}});
  const BodyId wheel = model.add_planar_body(1, 1, {.pose = {{0, 3, 0}, {1, 0, 0, 0}}});
  const BodyId table =
      model.add_prescribed(PrescribedMotion::turntable({0.1, 0.2, 1}, 2, {{0.5, 0, 0}, {1, 0, 0, 0}}));
  model.add_contact(a, b, sphere_on_sphere(0.5, 0.4), {.mu = 0.2, .torsion = 0.1, .rolling = 0.2});
  model.add_contact(table, b, sphere_on_plane(0.4), {.torsion = 0.1, .rolling = 0.2});
  model.add_contact(
      ground, a, sphere_on_plane(0.4),
      {.rolling = 0.2, .friction_axes = FrictionAxes{.mu = {0.2, 0.5}, .of = FrictionAxes::Of::B}});
  model.add_contact(ground, wheel, disc_on_line(0.5), {.mu = 0.1, .rolling = 0.2});
  const State x = disturbed(model, random, 0.1);
  const double step = 1e-5;
  Instant s, before, after, back, forth;
  evaluate(model, x, s);
  evaluate(model, moved(model, x, -step), before, &s);
  evaluate(model, moved(model, x, step), after, &s);
  const Vector xi = Vector::NullaryExpr(model.nv(), [&] { return random.number(); });
  const auto moved_by = [&](double by) {
    State y = x;
    move(model, xi, by, y.q);
    return y;
  };
  evaluate(model, moved_by(-step), back, &s);
  evaluate(model, moved_by(step), forth, &s);
  ContactDerivatives geometry;
  geometry.evaluate(model, s);
  REQUIRE(s.moments.size() == 4);
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    ContactInstant kept = s.contacts[i];
    const bool own_axes = model.contacts()[i].friction_axes.has_value();
    if (kept.tangents == 2 && !own_axes) kept.wish = kept.frame.col(1);
    CAPTURE(seed, i);
    const Vector3 rate = (after.moments[i].velocity(x.nu) - before.moments[i].velocity(x.nu)) / (2 * step);
    CHECK((moments_acceleration_bias(model, x, s, kept, geometry[i]) - rate).norm() < 5e-7);
    const Vector3 slip = (after.contacts[i].velocity(x.nu) - before.contacts[i].velocity(x.nu)) / (2 * step);
    CHECK((acceleration_bias(model, x, s, kept, geometry[i]) - slip).head(1 + kept.tangents).norm() < 5e-7);
    const WrenchMap<3>& W = s.moments[i].W;
    Eigen::Matrix<double, 12, 1> local = Eigen::Matrix<double, 12, 1>::Zero();
    for (int k = 0; k < W.na; ++k) local[k] = xi[W.va + k];
    for (int k = 0; k < W.nb; ++k) local[6 + k] = xi[W.vb + k];
    const Vector3 used = (W.A.colwise().norm() + W.B.colwise().norm()).transpose();
    Vector3 p = random.vector();
    for (int j = 0; j < 3; ++j)
      if (used[j] == 0) p[j] = 0;
    PairDerivative<3> d;
    differentiate_moments(model, x, s, kept, geometry[i], p, d);
    Vector f = Vector::Zero(model.nv()), minus = f, expected = f;
    forth.moments[i].W.add_impulse(p, f);
    back.moments[i].W.add_impulse(p, minus);
    const Eigen::Matrix<double, 12, 1> turned = d.force * local;
    for (int k = 0; k < W.na; ++k) expected[W.va + k] += turned[k];
    for (int k = 0; k < W.nb; ++k) expected[W.vb + k] += turned[6 + k];
    CHECK(((f - minus) / (2 * step) - expected).norm() < 5e-7);
    const Vector3 du = (forth.moments[i].velocity(x.nu) - back.moments[i].velocity(x.nu)) / (2 * step);
    CHECK((d.velocity * local - du).norm() < 5e-7);
  }
}

TEST_CASE("a contact says which torsion, rolling and friction axes it cannot have", "[moments]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1)), point = model.add_particle(1),
               plate = model.add_planar_body(1, 1);
  const auto add = [&](BodyId b, ContactOptions options) {
    model.add_contact(ground, b, sphere_on_plane(1), options);
  };
  CHECK_THROWS_WITH(add(ball, {.torsion = -1}), Contains("torsion is -1") && Contains(">= 0"));
  CHECK_THROWS_WITH(add(ball, {.rolling = infinity}), Contains("rolling is inf"));
  CHECK_THROWS_WITH(add(point, {.rolling = 1}), Contains("rolling is 1") && Contains("no orientation"));
  CHECK_THROWS_WITH(add(plate, {.torsion = 1}), Contains("torsion is 1") && Contains("planar bodies"));
  CHECK_THROWS_WITH(add(ball, {.friction_axes = FrictionAxes{.mu = {1, -1}}}),
                    Contains("friction_axes.mu is -1"));
  CHECK_THROWS_WITH(add(ball, {.mu = 1, .friction_axes = FrictionAxes{.mu = {1, 1}}}), Contains("mu is 1"));
  CHECK_THROWS_WITH(add(ball, {.friction_axes = FrictionAxes{.mu = {1, 1}, .t = Vector3::Zero()}}),
                    Contains("friction_axes.t"));
  CHECK(model.contacts().empty());
}

TEST_CASE("methods that do not know a contact's moments say so and name it", "[moments]") {
  const Disc disc(0.3, 0.01, 1, 1);
  for (const Method& m : methods()) {
    const std::unique_ptr<Stepper> stepper = m.make({});
    CAPTURE(m.name);
    if (stepper->knows_moments()) continue;
    State x = disc.start;
    const std::string torsion = "contact 'floor': torsion is 0.01", method(m.name);
    CHECK_THROWS_WITH((void)stepper->step(disc.model, x, 0.01), Contains(torsion) && Contains(method));
    CHECK_THROWS_WITH(simulate(disc.model, *stepper, x, {.t_end = 1, .h = 0.01}),
                      Contains(torsion) && Contains(method));
  }
  Ncp2Stepper least({.reactions = Reactions::MinimumNorm});
  State x = disc.start;
  CHECK_THROWS_WITH((void)least.step(disc.model, x, 0.01), Contains("minimum-norm"));
}

TEST_CASE("a disc that slides and spins at once goes as an integration of its own equations does",
          "[moments]") {
  const double mu = 0.3, T = 0.3;
  for (const double gamma : {0.0212, 0.01, 0.04}) {
    const Disc disc(mu, gamma, 1, 12);
    const auto [x, angle, v, w] = disc_at(disc, mu, gamma, 1, 12, T);
    Ncp2Stepper ncp2;
    const Trajectory run = simulate(disc.model, ncp2, disc.start, {.t_end = T, .h = T / 400});
    CAPTURE(gamma, x, v, w);
    CHECK(disc.model.position(run.back(), disc.body).x() == Approx(x).margin(2e-6));
    CHECK(disc.model.velocity(run.back(), disc.body).x() == Approx(v).margin(2e-5));
    CHECK(disc.model.angular_velocity(run.back(), disc.body).z() == Approx(w).margin(1e-3));
  }
}

TEST_CASE("sliding and spinning under the ellipsoid end together", "[moments]") {
  const double mu = 0.3;
  for (const double gamma : {0.0212, 0.015}) {
    const Disc disc(mu, gamma, 1, 12);
    for (const std::unique_ptr<Stepper>& stepper : exact_cones()) {
      const double h = 1e-3;
      State x = disc.start;
      double slides_until = 0, spins_until = 0;
      while (x.t < 1) {
        REQUIRE(stepper->step(disc.model, x, h).advanced());
        if (disc.model.velocity(x, disc.body).norm() > 1e-9) slides_until = x.t;
        if (disc.model.angular_velocity(x, disc.body).norm() > 1e-9) spins_until = x.t;
      }
      CAPTURE(stepper->name(), gamma);
      CHECK(slides_until == Approx(spins_until).margin(1.01 * h));
      CHECK(slides_until < 0.9);
    }
  }
}

TEST_CASE("energy that twisting and rolling take is accounted for, and stands in contacts.csv", "[moments]") {
  for (const std::unique_ptr<Stepper>& stepper : with_lcp()) {
    const Scene s = scene("spun-sphere");
    State x = s.start;
    double friction = 0, twist = 0;
    while (x.t < 0.8) {
      const StepReport r = stepper->step(s.model, x, 1e-2);
      REQUIRE(r.advanced());
      friction += r.energy_friction;
      REQUIRE(r.contacts.size() == 1);
      twist += r.contacts[0].moment.z();
      if (x.t < 0.615) CHECK(r.contacts[0].mode == ContactMode::Slip);
      if (x.t > 0.625) CHECK(r.contacts[0].mode == ContactMode::Stick);
      CHECK(std::abs(r.residuals.friction) < 1e-9);
      CHECK(std::abs(r.residuals.newton_euler) < 1e-9);
      CHECK(std::abs(r.residuals.normal) < 1e-9);
      CHECK(std::abs(r.energy_left) <= 0.5 * 0.004 * std::pow(0.02 * g * 1e-2 / 0.004, 2) * 1.001);
    }
    CAPTURE(stepper->name());
    CHECK(twist == Approx(-0.4 * 0.01 * 30).epsilon(1e-9));  // J w
    CHECK(friction == Approx(-0.5 * 0.004 * 900).epsilon(0.02));
  }
}

TEST_CASE("a wheel stands on a slope if and only if its tangent is no more than rolling/R", "[moments]") {
  const double rho = 0.01, R = 0.2;
  for (const double off : {-1e-6, 1e-6}) {
    const Scene s =
        scene("coasting-wheel", {{"slope", std::atan(rho / R) + off}, {"v0", 0}, {"rolling", rho}});
    for (const std::unique_ptr<Stepper>& stepper : with_lcp()) {
      const State x = simulate(s.model, *stepper, s.start, {.t_end = 2, .h = 0.1}).back();
      CAPTURE(stepper->name(), off);
      if (off < 0)
        CHECK(std::abs(x.nu[0]) < 1e-12);
      else
        CHECK(x.nu[0] == Approx(s.exact(2).nu[0]).epsilon(1e-4));
    }
  }
}

TEST_CASE("contacts without friction forces twist and roll too", "[moments]") {
  for (const std::unique_ptr<Stepper>& stepper : with_lcp()) {
    Scene s = scene("spun-sphere", {{"mu", 0}});
    s.model.set_velocity(s.start, {1}, {1, 0, 0}, {0, 0, 30});
    const State x = simulate(s.model, *stepper, s.start, {.t_end = 0.7, .h = 1e-2}).back();
    CAPTURE(stepper->name());
    CHECK(x.nu.head<3>().isApprox(Vector3(1, 0, 0), 1e-12));
    CHECK(x.nu.tail<3>().norm() < 1e-9);
  }
}

TEST_CASE("four feet with torsion of their own stop a block that turns on them", "[moments]") {
  // at rate w each foot rubs with mu N along its path and twists with it: the ellipsoid of one foot at the radius r is
  // mu² r w/S and gamma² w/S of N, S = √(mu² r² + gamma²)
  const double mu = 0.2, gamma = 0.05, J = 0.1, w = 5;
  for (const std::unique_ptr<Stepper>& stepper : exact_cones()) {
    Model model;
    const BodyId block = model.add_body(Inertia::principal(2, {0.1, 0.1, J}), {.name = "block"});
    model.add_contact(ground, block, box_on_plane({0.3, 0.4, 0.2}),
                      {.mu = mu, .torsion = gamma, .name = "feet"});
    State x = model.rest();
    model.set_position(x, block, {0, 0, 0.1});
    model.set_velocity(x, block, Vector3::Zero(), {0, 0, w});
    const double r = 0.25, moment = 2 * g * std::hypot(mu * r, gamma), stops = J * w / moment;
    const State half = simulate(model, *stepper, x, {.t_end = stops / 2, .h = stops / 100}).back();
    CAPTURE(stepper->name());
    CHECK(model.angular_velocity(half, block).z() == Approx(w / 2).epsilon(1e-3));
    const State rest = simulate(model, *stepper, x, {.t_end = 1.1 * stops, .h = stops / 100}).back();
    CHECK(rest.nu.norm() < 1e-9);
  }
}
