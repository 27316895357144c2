#include "perp/step/cp1.hpp"

#include <cmath>
#include <random>

#include "perp/model/gaps.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/impact.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

/// A rod of half length 1 and mass 1 whose lower right tip touches the floor and slides at x' > 0.
struct Rod {
  Model model;
  State x;
  Rod(double theta, double mu, double rate, double slip = 1) {
    model.set_gravity({0, -9.81, 0});
    const BodyId rod = model.add_planar_body(1, 1.0 / 3, {.name = "rod"});
    model.add_contact(ground, rod, point_on_plane(Vector3::UnitX(), horizontal_line), {.mu = mu});
    x = model.rest();
    // tip at (cos, -sin) from the centre; its velocity is (slip, 0)
    const double c = std::cos(theta), s = std::sin(theta);
    x.q << 0, s, -theta;
    x.nu << slip - s * -rate * -1, 0, 0;
    x.nu[2] = -rate;  // theta falls with the planar angle
    x.nu[0] = slip + x.nu[2] * -s;
    x.nu[1] = -x.nu[2] * c;
  }
};

}  // namespace

TEST_CASE("CP1 of 1,000 random Painleve rods has as many solutions as the sign table says", "[cp1]") {
  std::mt19937 random(20031);
  const auto uniform = [&](double a, double b) {
    return a + (b - a) * (static_cast<double>(random()) / 4294967296.0);
  };
  int none = 0, several = 0, open = 0, slides = 0;
  for (int i = 0; i < 1000; ++i) {
    const double theta = uniform(0.2, 1.5), mu = uniform(0.2, 4), rate = uniform(-5, 5);
    const double c = std::cos(theta), s = std::sin(theta);
    const double A = 1 + 3 * c * (c - mu * s), b = rate * rate * s - 9.81;
    if (std::abs(A) < 1e-9 || std::abs(b) < 1e-9) continue;
    const Rod rod(theta, mu, rate);
    const int edges = i % 2 == 0 ? 0 : 8;
    const Cp1Solution solution = solve_cp1(rod.model, rod.x, {.edges = edges});
    CAPTURE(theta, mu, rate, A, b, edges);
    REQUIRE(solution.contacts.size() == 1);
    REQUIRE(solution.contacts[0].sliding);
    REQUIRE(solution.complete);
    if (A < 0 && b < 0) {
      ++none;
      REQUIRE(solution.status == Cp1Status::None);
      continue;
    }
    REQUIRE(solution.status == (A < 0 ? Cp1Status::Several : Cp1Status::Unique));
    (A < 0 ? several : b > 0 ? open : slides)++;
    const double N = A > 0 && b < 0 ? -b / A : 0;
    CHECK(solution.contacts[0].c_n == Approx(N).epsilon(1e-9).margin(1e-9));
    CHECK(solution.contacts[0].acceleration.x() == Approx(b + A * N).epsilon(1e-9).margin(1e-7));
    CHECK(solution.contacts[0].mode == (b > 0 ? ContactMode::Open : ContactMode::Slip));
  }
  CHECK(none > 50);
  CHECK(several > 20);
  CHECK(open > 50);
  CHECK(slides > 300);
}

TEST_CASE("The relaxed model has a solution where Coulomb's law has none", "[cp1]") {
  const Rod rod(std::atan(2.0), 2, 0);
  REQUIRE(solve_cp1(rod.model, rod.x).status == Cp1Status::None);
  CHECK(solve_cp1(rod.model, rod.x).acceleration.size() == 0);
  const Cp1Solution relaxed = solve_cp1(rod.model, rod.x, {.relaxed = true});
  REQUIRE(relaxed.status == Cp1Status::Unique);
  CHECK(relaxed.contacts[0].force.x() <= 0);  // does not push along
  CHECK(relaxed.contacts[0].acceleration.x() == Approx(0).margin(1e-12));
}

TEST_CASE(
    "Where the rear foot of a pushed box leaves the front one sticks, though statics would have it slip",
    "[cp1][event]") {
  // the pull is beyond friction at rest, 8 > mu g, but tipping about the front foot it carries more and holds back less
  const double push = 8, g = 9.81, w = 0.5, H = 1, J = 0.1, mu = 0.6;
  REQUIRE(push > mu * g);
  const double tip = (push * H - g * w) / (J + w * w + H * H);  // angular acceleration
  REQUIRE(push - tip * H < mu * (g + tip * w));
  for (const bool front_first : {false, true}) {
    Model model;
    model.set_gravity({push, -g, 0});
    const BodyId box = model.add_planar_body(1, J);
    for (const double x : {front_first ? w : -w, front_first ? -w : w})
      model.add_contact(ground, box, point_on_plane({x, -H, 0}, horizontal_line),
                        {.mu = mu, .name = x > 0 ? "front" : "rear"});
    State x = model.rest();
    x.q[1] = H;
    for (const int edges : {0, 4}) {
      const Cp1Solution a = solve_cp1(model, x, {.edges = edges});
      REQUIRE(a.status == Cp1Status::Unique);
      CHECK(a.complete);
      CHECK(a.acceleration[2] == Approx(-tip).epsilon(1e-10));
      CHECK(a.acceleration[0] == Approx(tip * H).epsilon(1e-10));
      const Cp1Contact &front = a.contacts[front_first ? 0 : 1], &rear = a.contacts[front_first ? 1 : 0];
      CHECK(front.mode == ContactMode::Stick);
      CHECK(front.c_n == Approx(g + tip * w).epsilon(1e-10));
      CHECK(rear.mode == ContactMode::Open);
      CHECK(rear.c_n == Approx(0).margin(1e-10));
    }
    if (!has_sundials()) continue;
    EventDriven stepper({.rtol = 1e-11});
    const Trajectory run = simulate(model, stepper, x, {.t_end = 0.2});
    CHECK(run.events.empty());
    CHECK(run.report(run.steps() - 1).contact("front").mode == ContactMode::Stick);
    // turned about the front foot, with the energy that this needs
    const double angle = -run.back().q[2], rate = -run.back().nu[2];
    CHECK(run.back().q[0] == Approx(w - w * std::cos(angle) + H * std::sin(angle)).epsilon(1e-10));
    const double work = push * run.back().q[0] - g * (run.back().q[1] - H);
    CHECK(0.5 * (J + w * w + H * H) * rate * rate == Approx(work).epsilon(1e-9));
    CHECK(angle > 0.03);
  }
}

TEST_CASE("A rod that jams without a collision has the closed form's velocities", "[cp1][impact]") {
  struct Jam {
    double theta, x, y, rate;
  };
  for (const Jam& jam : {Jam{std::atan(2.0), 0.6, 0.3, 0.670820393249937},
                         Jam{M_PI / 3, 0.5625, 0.324759526419164, 0.649519052838329},
                         Jam{50 * M_PI / 180, 0.440118066625099, 0.369302907379578, 0.574533332339234}}) {
    const Rod rod(jam.theta, 2, 0);
    const double c = std::cos(jam.theta), s = std::sin(jam.theta);
    const double nn = 1 + 3 * c * c, nt = 3 * c * s, tt = 1 + 3 * s * s, det = nn * tt - nt * nt;
    const Impact impact = solve_impact(rod.model, rod.x, {.without_collision = true});
    REQUIRE(impact.solved);
    CHECK(impact.contacts[0].p_n == Approx(nt / det).epsilon(1e-12));
    CHECK(impact.contacts[0].impulse.x() == Approx(-nn / det).epsilon(1e-12));
    CHECK(impact.nu[1] == Approx(jam.y).epsilon(1e-12));
    CHECK(-impact.nu[2] == Approx(jam.rate).epsilon(1e-12));
    CHECK(impact.energy < 0);
    CHECK(impact.contacts[0].mode == ContactMode::Stick);
  }
}

TEST_CASE("Forces of CP1 in a rolling sphere are those that rolling needs", "[cp1]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.5), {.pose = {.p = {0, 0, 0.5}}});
  model.add_contact(ground, ball, sphere_on_plane(0.5), {.mu = 0.3});
  model.set_gravity({2, 0, -9.81});
  State x = model.rest();
  model.set_velocity(x, ball, {1, 0, 0}, {0, 2, 0});
  for (const int edges : {0, 8}) {
    const Cp1Solution a = solve_cp1(model, x, {.edges = edges});
    REQUIRE(a.status == Cp1Status::Unique);
    CHECK(a.contacts[0].mode == ContactMode::Stick);
    CHECK(a.contacts[0].c_n == Approx(9.81).epsilon(1e-12));
    CHECK(a.contacts[0].force.x() == Approx(-4.0 / 7).epsilon(1e-10));
    CHECK(a.acceleration[0] == Approx(10.0 / 7).epsilon(1e-10));
  }
}

TEST_CASE("A sphere thrown at a floor leaves it as Newton's and Coulomb's laws say", "[impact]") {
  for (const double mu : {0.05, 0.5}) {
    for (const Restitution law : {Restitution::Newton, Restitution::Poisson}) {
      Model model;
      const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {.p = {0, 0, 0.1}}});
      model.add_contact(ground, ball, sphere_on_plane(0.1), {.mu = mu, .e = 0.8});
      State x = model.rest();
      model.set_velocity(x, ball, {2, 0, -3});
      const Impact impact = solve_impact(model, x, {.restitution = law});
      REQUIRE(impact.solved);
      x.nu = impact.nu;
      CHECK(model.velocity(x, ball).z() == Approx(2.4).epsilon(1e-12));
      CHECK(model.velocity(x, ball).x() == Approx(mu == 0.05 ? 1.73 : 10.0 / 7).epsilon(1e-12));
      CHECK(model.angular_velocity(x, ball).y() == Approx(mu == 0.05 ? 6.75 : 100.0 / 7).epsilon(1e-12));
      CHECK(impact.contacts[0].mode == (mu == 0.05 ? ContactMode::Slip : ContactMode::Stick));
    }
  }
}

}  // namespace perp
