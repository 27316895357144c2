// The user's own events: found, done, and gone on from.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "perp/io/scene_file.hpp"
#include "perp/model/gaps.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

/// x'' = -x, from rest at 1 m.
struct Oscillator {
  Model model;
  BodyId body;
  State start;
  Oscillator() {
    model.set_gravity(Vector3::Zero());
    body = model.add_particle(1);
    Spring spring;
    spring.a = ground;
    spring.b = body;
    spring.stiffness = 1;
    model.add_spring(spring);
    start = model.rest();
    model.set_position(start, body, {1, 0, 0});
  }
  UserEvent at(double place, int direction, decltype(UserEvent::then) then = {}) const {
    return {
        .name = "place",
        .when = [b = body, place](const Model& m, const State& x) { return m.position(x, b).x() - place; },
        .direction = direction,
        .then = std::move(then)};
  }
};

AfterEvent turn_round(const Model&, State& x) {
  x.nu = -x.nu;
  return AfterEvent::GoOn;
}

/// The oscillator thrown back whenever it falls to `place`: it repeats cos from -acos(place) to acos(place).
double thrown_back(double place, double t) {
  const double half = std::acos(place);
  return std::cos(std::fmod(t + half, 2 * half) - half);
}

double quantity(const Trajectory& run, double StepFigures::*part) {
  double sum = 0;
  for (std::size_t i = 0; i < run.steps(); ++i)
    if (!std::isnan(run.figures(i).*part)) sum += run.figures(i).*part;
  return sum;
}

Trajectory run_by(const std::string& method, const Model& model, const State& start, double t_end, double h,
                  const std::vector<UserEvent>& events) {
  const auto stepper = make_stepper(method, {.tolerance = 1e-11});
  return simulate(model, *stepper, start,
                  {.t_end = t_end, .h = chooses_steps(*stepper) ? not_set : h, .events = events});
}

}  // namespace

TEST_CASE("An event is written down at its time in its direction and changes nothing", "[events]") {
  const std::string method = GENERATE("event", "ncp2");
  if (method == "event" && !has_sundials()) return;
  const Oscillator o;
  const double pi = std::numbers::pi, error = method == "event" ? 1e-10 : 5e-5;
  const Trajectory falling = run_by(method, o.model, o.start, 10, 0.01, {o.at(0.5, -1)});
  REQUIRE(falling.events.size() == 2);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(falling.events[k].kind == EventKind::User);
    CHECK(falling.events[k].contact == "place");
    CHECK(std::abs(falling.events[k].t - (pi / 3 + 2 * pi * static_cast<double>(k))) < error);
  }
  const Trajectory rising = run_by(method, o.model, o.start, 10, 0.01, {o.at(0.5, 1)});
  REQUIRE(rising.events.size() == 1);
  CHECK(std::abs(rising.events[0].t - 5 * pi / 3) < error);
  CHECK(run_by(method, o.model, o.start, 10, 0.01, {o.at(0.5, 0)}).events.size() == 3);
  CHECK(falling.stopped_by.empty());
  CHECK(std::abs(falling.back().q[0] - std::cos(10)) < 4 * error);
}

TEST_CASE("A run goes on from the state that an event has set, at the method's own order", "[events]") {
  const Oscillator o;
  const double place = 0.3, t_end = 20;
  const int direction = GENERATE(-1, 0);  // thrown back it rises from its zero, which is no event
  const std::vector<UserEvent> events{o.at(place, direction, turn_round)};
  const auto error_of = [&](const std::string& method, double h) {
    const Trajectory run = run_by(method, o.model, o.start, t_end, h, events);
    CHECK(run.events.size() == 8);
    CHECK(run.back().t == t_end);
    return std::abs(run.back().q[0] - thrown_back(place, t_end));
  };
  if (has_sundials()) CHECK(error_of("event", not_set) < 1e-9);
  for (const auto& [method, order] : {std::pair("ncp2", 2.0), std::pair("lcp", 1.0)}) {
    const double found = std::log2(error_of(method, 2e-3) / error_of(method, 1e-3));
    CAPTURE(method, found);
    CHECK(found > order - 0.3);
    CHECK(found < order + 0.3);
  }
}

TEST_CASE("An event ends the run at its time, and the run says which", "[events]") {
  const std::string method = GENERATE("event", "ncp2", "ncp", "lcp");
  if (method == "event" && !has_sundials()) return;
  const Oscillator o;
  UserEvent stop = o.at(0.5, -1, stop_run), other = o.at(0.7, 0);
  other.name = "on the way";
  const Trajectory run = run_by(method, o.model, o.start, 10, 1e-3, {stop, other});
  const double error = method == "event" ? 1e-10 : method == "ncp2" ? 1e-6 : 1e-3;
  CHECK(run.stopped_by == "place");
  CHECK(std::abs(run.back().t - std::numbers::pi / 3) < error);
  CHECK(std::abs(run.back().q[0] - 0.5) < error);
  REQUIRE(run.events.size() == 2);
  CHECK(run.events[0].contact == "on the way");
  CHECK(run.events[1].t == run.back().t);

  struct Count final : RunSink {
    int rows = 0, found = 0;
    void step(const State&, const StepReport&) override { ++rows; }
    void event(const Event&) override { ++found; }
  } count;
  const auto stepper = make_stepper(method, {.tolerance = 1e-11});
  const RunEnd end =
      simulate(o.model, *stepper, o.start,
               {.t_end = 10, .h = chooses_steps(*stepper) ? not_set : 1e-3, .events = {stop, other}}, count);
  CHECK(end.stopped_by == "place");
  CHECK_FALSE(end.reached);
  CHECK(end.x.t == run.back().t);
  CHECK(static_cast<std::size_t>(count.rows) == run.steps());
  CHECK(count.found == 2);
}

TEST_CASE("Two zeros within one step of the integrator are two events", "[events]") {
  if (!has_sundials()) return;
  Model model;
  const BodyId ball = model.add_particle(1);
  State x = model.rest();
  const double g = 9.81, below = 1e-5, rise = GENERATE(0.7, 1.0, 1.3, 1.7, 2.9), v = g * rise;
  model.set_velocity(x, ball, {0, 0, v});
  const double top = v * v / (2 * g), half = std::sqrt(2 * below / g);
  const auto height = [=](const Model& m, const State& s) { return m.position(s, ball).z() - top + below; };
  EventDriven stepper;
  const Trajectory run =
      simulate(model, stepper, x, {.t_end = 5, .events = {{.name = "top", .when = height}}});
  REQUIRE(run.events.size() == 2);
  CHECK(std::abs(run.events[0].t - (rise - half)) < 1e-10);
  CHECK(std::abs(run.events[1].t - (rise + half)) < 1e-10);
}

TEST_CASE("`event` finds what is just past the zero, not just before", "[events]") {
  if (!has_sundials()) return;
  const Oscillator o;
  for (double place = 0.05; place < 1; place += 0.05) {
    const Trajectory run = run_by("event", o.model, o.start, 10, not_set, {o.at(place, -1, stop_run)});
    CAPTURE(place);
    CHECK(run.back().q[0] <= place);
    CHECK(run.back().q[0] > place - 1e-12);
  }
}

TEST_CASE("What starts from its zero has not passed it, and what rests there never does", "[events]") {
  const std::string method = GENERATE("event", "ncp2");
  if (method == "event" && !has_sundials()) return;
  Model model;
  const BodyId ball = model.add_particle(1);
  State x = model.rest();
  model.set_velocity(x, ball, {0, 0, 4.905});
  const auto height = [=](const Model& m, const State& s) { return m.position(s, ball).z(); };
  const Trajectory run = run_by(method, model, x, 2, 0.01, {{.name = "back", .when = height}});
  REQUIRE(run.events.size() == 1);
  CHECK(std::abs(run.events[0].t - 1) < 1e-9);

  const Scene s = scene("table");
  const auto rests = [&s, z = s.model.position(s.start, BodyId{1}).z()](const Model& m, const State& now) {
    return m.position(now, BodyId{1}).z() - z;
  };
  CHECK(run_by(method, s.model, s.start, 1, 0.01, {{.name = "rests", .when = rests}}).events.empty());
}

TEST_CASE("A velocity that an event sets against a joint is taken away by the joint", "[events]") {
  const std::string method = GENERATE("event", "ncp2");
  if (method == "event" && !has_sundials()) return;
  const double length = 1, g = 9.81, kick = 2;
  Model model;
  const BodyId bob = model.add_body(Inertia::solid_sphere(1, 1e-3), {.pose = {{0, 0, -length}}});
  model.add_joint(revolute(ground, bob, {.point = {0, 0, 0}, .axis = {0, 1, 0}}));
  const State x = model.rest();
  const auto clock = [](const Model&, const State& s) { return s.t - 0.5; };
  const auto kicked = [=](const Model& m, State& s) {
    m.set_velocity(s, bob, {kick, 0, 7}, {0, -kick / length, 3});
    return AfterEvent::GoOn;
  };
  const Trajectory run =
      run_by(method, model, x, 0.75, 1e-3, {{.name = "kick", .when = clock, .then = kicked}});
  REQUIRE(run.events.size() == 1);
  CHECK(std::abs(run.events[0].t - 0.5) < 1e-12);
  const Vector3 p = model.position(run.back(), bob), v = model.velocity(run.back(), bob);
  CAPTURE(method, p.transpose(), v.transpose());
  CHECK(std::abs(p.norm() - length) < 1e-9);
  CHECK(std::abs(p.y()) < 1e-9);
  // the sphere's own inertia is 4e-7 of that about the pivot
  CHECK(std::abs(0.5 * v.squaredNorm() - (0.5 * kick * kick - g * (p.z() + length))) < 1e-5);
}

TEST_CASE("A velocity that an event sets against a contact is answered by the contact", "[events]") {
  const std::string method = GENERATE("event", "ncp2", "ncp", "lcp");
  if (method == "event" && !has_sundials()) return;
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.1), {.pose = {{0, 0, 0.1}}});
  model.add_contact(ground, ball, sphere_on_plane(0.1), {.e = 0.5});
  const auto clock = [](const Model&, const State& s) { return s.t - 0.5; };
  const auto thrown = [=](const Model& m, State& s) {
    m.set_velocity(s, ball, {0, 0, -3});
    return AfterEvent::GoOn;
  };
  const Trajectory run =
      run_by(method, model, model.rest(), 0.6, 1e-4, {{.name = "throw", .when = clock, .then = thrown}});
  const double t = 0.1;  // since it was thrown, on its way up
  CAPTURE(method);
  CHECK(std::abs(model.position(run.back(), ball).z() - (0.1 + 1.5 * t - 0.5 * 9.81 * t * t)) <
        (method == "event" ? 1e-9 : 1e-3));
}

TEST_CASE("A run in pieces passes an event where two pieces meet once", "[events]") {
  const Oscillator o;
  const auto clock = [](const Model&, const State& s) { return s.t - 12.8; };
  Ncp2Stepper stepper;
  SimulateOptions options{.t_end = 30, .h = 0.05, .events = {{.name = "noon", .when = clock}}};
  options.t_start = 0;
  options.most = 64;
  std::vector<Event> found;
  State x = o.start;
  while (x.t < 30) {
    const Trajectory piece = simulate(o.model, stepper, x, options);
    found.insert(found.end(), piece.events.begin(), piece.events.end());
    options.taken += piece.steps();
    x = piece.back();
  }
  REQUIRE(found.size() == 1);
  CHECK(std::abs(found[0].t - 12.8) < 1e-12);
}

TEST_CASE("A row says what an event did to the energy, and the sum of all rows is the run's", "[events]") {
  const std::string method = GENERATE("event", "ncp2");
  if (method == "event" && !has_sundials()) return;
  const Oscillator o;
  const auto faster = [](const Model&, State& x) {
    x.nu *= 2;
    return AfterEvent::GoOn;
  };
  const Trajectory run = run_by(method, o.model, o.start, 3, 1e-3, {o.at(0, -1, faster)});
  REQUIRE(run.events.size() == 1);
  CHECK(std::abs(quantity(run, &StepFigures::energy_load) - 1.5) < 1e-6);  // from 1/2 to 4/2
  CHECK(std::abs(run.figures(run.steps() - 1).energy - 2) < 1e-6);
  std::size_t same = 0;
  for (std::size_t i = 1; i < run.size(); ++i) same += run.t(i) == run.t(i - 1);
  CHECK(same == (method == "event" ? 2 : 1));  // before, as it was set, and as the run goes on
  const double t = run.events[0].t;
  CHECK(std::abs(run.at(t).nu[0] + 2) < 1e-6);
  CHECK(std::abs(run.at(std::nextafter(t, 0)).nu[0] + 1) < 1e-6);
}

TEST_CASE("Events that are none are refused, and functions without a value end the run", "[events]") {
  const std::string method = GENERATE("event", "ncp2");
  if (method == "event" && !has_sundials()) return;
  const Oscillator o;
  const auto run = [&](const UserEvent& event) { return run_by(method, o.model, o.start, 2, 0.01, {event}); };
  CHECK_THROWS_WITH(run({.name = "a"}), "simulate: events is a, needs a function `when`");
  CHECK_THROWS_WITH(run(o.at(0, 2)), "simulate: events: direction of 'place' is 2, needs to be -1, 0 or 1");
  const auto later = [](const Model&, State& x) {
    x.t += 1;
    return AfterEvent::GoOn;
  };
  CHECK_THROWS_WITH(run(o.at(0.5, 0, later)),
                    Catch::Contains("t is 2.04") && Catch::Contains("needs to stay 1.04"));
  const auto root = [](const Model&, const State& x) { return std::sqrt(x.q[0] - 0.5); };
  CHECK_THROWS_WITH(run({.name = "root", .when = root}),
                    Catch::Contains("`when` of the event 'root' is not a number at t = 1.") &&
                        Catch::Contains("(not-finite)"));
}

TEST_CASE("A pendulum in a scene file says when it passes its lowest point", "[events]") {
  const std::string method = GENERATE("event", "ncp2");
  if (method == "event" && !has_sundials()) return;
  const Scene s = read_scene(
      "t_end = 3\ngravity = [0, -9.81, 0]\n[[body]]\nname = \"bob\"\nkind = \"planar\"\nmass = 1\ninertia = "
      "0.01\nposition = [0, "
      "-1]\n"
      "start = { position = [1, 0], angle = 1.5707963267948966 }\n"
      "[[joint]]\nname = \"hinge\"\nkind = \"revolute\"\na = \"ground\"\nb = \"bob\"\npoint = [0, 0, 0]\n"
      "[parameters]\nbottom = 0\n"
      "[[event]]\nname = \"low\"\nwhen = \"hinge.coordinate - bottom\"\ndirection = -1\n"
      "[[event]]\nwhen = \"hinge.rate*(1 + bob.x^2)\"\nthen = \"stop\"\ndirection = 1\n",
      "pendulum.toml");
  REQUIRE(s.events.size() == 2);
  CHECK(s.events[1].name == "event-2");
  const double quarter = std::comp_ellint_1(std::numbers::sqrt2 / 2) / std::sqrt(9.81 / 1.01);
  const Trajectory run = run_by(method, s.model, s.start, s.t_end, 1e-3, s.events);
  const double error = method == "event" ? 1e-8 : 1e-5;
  REQUIRE(run.events.size() == 2);
  CHECK(std::abs(run.events[0].t - quarter) < error);
  CHECK(run.stopped_by == "event-2");
  CHECK(std::abs(run.events[1].t - 2 * quarter) < error);
}

}  // namespace perp
