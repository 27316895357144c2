// Loads that come and go while nothing else happens, the user's own events, and states between rows.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "perp/io/scene_file.hpp"
#include "perp/model/gaps.hpp"
#include "perp/model/timing.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

constexpr double strength = 1e4, begin = 20;  // [N], [s]

long count(const Trajectory& run, EventKind kind) {
  return std::count_if(run.events.begin(), run.events.end(), [&](const Event& e) { return e.kind == kind; });
}

/// A particle of 1 kg that nothing holds, under a force along x written as text.
Scene pushed(const std::string& force, const std::string& more = "") {
  return read_scene("gravity = [0, 0, 0]\n[[body]]\nname = \"p\"\nkind = \"particle\"\nmass = 1\n" + more +
                        "[[force]]\nbody = \"p\"\nforce = [\"" + force + "\", 0, 0]\n",
                    "pushed.toml");
}

Trajectory run_to(const Scene& s, double t_end, const EventDrivenOptions& options = {}) {
  EventDriven stepper(options);
  return simulate(s.model, stepper, s.start, {.t_end = t_end});
}

using Push = std::function<Wrench(const Model&, const State&)>;

Push square_push(double width) {
  return [width](const Model&, const State& x) {
    return Wrench{{x.t >= begin && x.t < begin + width ? strength : 0, 0, 0}, Vector3::Zero()};
  };
}

}  // namespace

TEST_CASE("A push that a scene file switches on and off acts however short it is", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-6, 1e-3, 1e-2, 0.1, 1.0);
  const std::string from = std::to_string(begin), to = std::to_string(begin + width);
  const Scene s = pushed("10000*(step(t - " + from + ") - step(t - " + to + "))");
  const Trajectory run = run_to(s, 30);
  CAPTURE(width);
  const double v = strength * (std::stod(to) - std::stod(from));
  CHECK(std::abs(run.back().nu[0] - v) < 1e-10 * v);
  CHECK(std::abs(run.back().q[0] - v * (10 - 0.5 * width)) < 1e-9 * v * 10);
  CHECK(count(run, EventKind::Load) == 2);
  CHECK(run.unseen == 0);
}

TEST_CASE("A force of one's own that names its times acts however short it is; one that does not is said",
          "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-6, 1e-3, 0.1);
  Model named, unnamed;
  for (Model* model : {&named, &unnamed}) {
    model->set_gravity(Vector3::Zero());
    const BodyId p = model->add_particle(1);
    if (model == &named)
      model->add_force(p, Timed<Wrench(const Model&, const State&)>(square_push(width),
                                                                    {.times = {begin, begin + width}}));
    else
      model->add_force(p, square_push(width));
  }
  CAPTURE(width);
  EventDriven stepper;
  const Trajectory told = simulate(named, stepper, named.rest(), {.t_end = 30});
  const double v = strength * ((begin + width) - begin);
  CHECK(std::abs(told.back().nu[0] - v) < 1e-9 * v);
  CHECK(told.unseen == 0);
  const Trajectory silent = simulate(unnamed, stepper, unnamed.rest(), {.t_end = 30});
  CHECK(silent.unseen == 30.0 / 4096);
  if (width < 1e-3) return;
  EventDriven looks({.look = 0.4 * width});
  const Trajectory seen = simulate(unnamed, looks, unnamed.rest(), {.t_end = 30});
  CHECK(std::abs(seen.back().nu[0] - v) < 1e-6 * v);
  CHECK(seen.unseen == 0.4 * width);
}

TEST_CASE("Smooth pushes are seen from a hundredth of a second on, and shorter ones by looking more often",
          "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-3, 1e-2, 0.05, 0.3);
  const Scene s = pushed("exp(-((t - 17.3)/" + std::to_string(width) + ")^2)");
  const Trajectory run = run_to(s, 30, {.look = width < 1e-2 ? 0.7 * width : not_set});
  const double v = width * std::sqrt(std::numbers::pi);
  CAPTURE(width);
  CHECK(std::abs(run.back().nu[0] - v) < 1e-8);
}

TEST_CASE("A plate that rises for a moment knocks a ball away", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-2, 0.1);
  const Scene s = read_scene(
      "gravity = [0, 0, 0]\n[[body]]\nname = \"plate\"\nkind = \"prescribed\"\nmotion = { kind = "
      "\"function\", position = [0, 0, "
      "\"0.02*exp(-((t - 17.3)/" +
          std::to_string(width) +
          ")^2)\"], rotation = [0, 0, 0] }\n"
          "[[body]]\nname = \"ball\"\nkind = \"particle\"\nmass = 1\nposition = [0, 0, 0.01]\n"
          "[[contact]]\na = \"plate\"\nb = \"ball\"\ngap = { kind = \"particle_on_plane\" }\ne = 1\n",
      "plate.toml");
  const Trajectory run = run_to(s, 30);
  // at the half height s = sqrt(ln 2) before the top the plate rises at .02 2 s exp(-s^2)/width; the ball leaves at twice that
  const double rise = 0.02 * 2 * std::sqrt(std::numbers::ln2) * 0.5 / width;
  CAPTURE(width);
  CHECK(std::abs(run.back().nu[2] - 2 * rise) < 1e-8 * rise);
}

TEST_CASE("A box at rest that gets one short push slides as far as its friction lets it", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = 0.01, mu = 0.3, g = 9.81, a = 100 - mu * g;
  const Scene s = read_scene(
      "[[body]]\nname = \"box\"\nkind = \"spatial\"\nmass = 1\ninertia = { shape = \"box\", size = [0.2, "
      "0.2, 0.1] }\nposition = "
      "[0, 0, 0.05]\n"
      "[[contact]]\na = \"ground\"\nb = \"box\"\ngap = { kind = \"box_on_plane\", size = [0.2, 0.2, 0.1] "
      "}\nmu = 0.3\n"
      "[[force]]\nbody = \"box\"\nforce = [\"100*(step(t - 5) - step(t - 5.01))\", 0, 0]\n",
      "box.toml");
  const Trajectory run = run_to(s, 10);
  const double v = a * width;
  CHECK(std::abs(run.back().q[0] - (0.5 * v * width + v * v / (2 * mu * g))) < 1e-9);
  CHECK(count(run, EventKind::Load) == 2);
}

TEST_CASE("A door at rest by its friction gives way to a shove of its motor", "[event][loads]") {
  if (!has_sundials()) return;
  const Scene s = read_scene(
      "gravity = [0, 0, 0]\n[[body]]\nname = \"door\"\nkind = \"spatial\"\nmass = 20\ninertia = { shape = "
      "\"box\", size = [0.8, "
      "0.04, 2] }\n"
      "position = [0.4, 0, 1]\n[[joint]]\nname = \"hinge\"\nkind = \"revolute\"\na = \"ground\"\nb = "
      "\"door\"\nfriction = 1\n"
      "[[motor]]\njoint = \"hinge\"\neffort = \"60*(step(t - 3) - step(t - 3.05))\"\n",
      "door.toml");
  const Trajectory run = run_to(s, 8);
  const double J = 20.0 / 12 * (0.64 + 0.0016) + 20 * 0.16, w = 59 / J * 0.05;
  CHECK(std::abs(s.model.coordinate(run.back(), s.model.find_joint("hinge")) -
                 (0.5 * w * 0.05 + w * w * J / 2)) < 1e-8);
}

TEST_CASE("A force that jumps where the body is jumps there", "[event][loads]") {
  if (!has_sundials()) return;
  const Scene s = pushed("-100*step(x - 1)", "velocity = [1, 0, 0]\n");
  const Trajectory run = run_to(s, 3);
  // into the field at t = 1, back at 1.02 with the same speed
  CHECK(std::abs(run.back().q[0] + 0.98) < 1e-8);
  CHECK(count(run, EventKind::Load) == 2);
}

TEST_CASE("A square wave jumps at each of its edges", "[event][loads]") {
  if (!has_sundials()) return;
  const Scene s = pushed("step(sin(10*t))");
  const Trajectory run = run_to(s, 2);
  CHECK(count(run, EventKind::Load) == 6);
  CHECK(std::abs(run.back().nu[0] - (3 * std::numbers::pi / 10 + (2 - 6 * std::numbers::pi / 10))) < 1e-10);
}

TEST_CASE("An event of the user's is found exactly, may change the state and may end the run", "[event]") {
  if (!has_sundials()) return;
  Model model;
  const BodyId ball = model.add_particle(1);
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 5});
  const auto height = [ball](const Model& m, const State& s) { return m.position(s, ball).z() - 1; };
  const double falls = std::sqrt(2 * 4 / 9.81);
  EventDriven stepper;

  const Trajectory marked =
      simulate(model, stepper, x, {.t_end = 2, .events = {{.name = "low", .when = height}}});
  REQUIRE(marked.events.size() == 1);
  CHECK(marked.events[0].kind == EventKind::User);
  CHECK(marked.events[0].contact == "low");
  CHECK(std::abs(marked.events[0].t - falls) < 1e-12);
  CHECK(marked.back().t == 2);

  const auto turn = [](const Model&, State& s) {
    s.nu[2] = -s.nu[2];
    return true;
  };
  const Trajectory turned = simulate(
      model, stepper, x,
      {.t_end = 2.5 * falls, .events = {{.name = "net", .when = height, .direction = -1, .then = turn}}});
  REQUIRE(turned.events.size() == 1);
  CHECK(std::abs(model.position(turned.back(), ball).z() - (5 - 0.5 * 9.81 * 0.25 * falls * falls)) < 1e-9);

  const auto stop = [](const Model&, State&) { return false; };
  const Trajectory stopped =
      simulate(model, stepper, x,
               {.t_end = 2, .events = {{.name = "end", .when = height, .direction = -1, .then = stop}}});
  CHECK(std::abs(stopped.back().t - falls) < 1e-12);
  const Trajectory other =
      simulate(model, stepper, x,
               {.t_end = 2, .events = {{.name = "up", .when = height, .direction = 1, .then = stop}}});
  CHECK(other.events.empty());
  CHECK(other.back().t == 2);
}

TEST_CASE("Steps of fixed size find the user's events in the cubics between their states", "[simulate]") {
  const auto stepper = make_stepper(GENERATE("lcp", "ncp", "ncp2"));
  const std::string text =
      "[[body]]\nname = \"ball\"\nkind = \"particle\"\nmass = 1\nposition = [0, 0, 5]\n"
      "[[event]]\nname = \"low\"\nwhen = \"ball.z - 1\"\ndirection = -1\nthen = \"stop\"\n";
  const Scene s = read_scene(text, "falls.toml");
  const double falls = std::sqrt(2 * 4 / 9.81);
  const Trajectory run = simulate(s.model, *stepper, s.start,
                                  {.t_end = 2, .h = 1e-3, .events = read_events(text, "falls.toml")});
  REQUIRE(run.events.size() == 1);
  CHECK(run.events[0].contact == "low");
  CHECK(std::abs(run.events[0].t - falls) < (stepper->order() == 2 ? 1e-9 : 2e-3));
  CHECK(run.back().t < falls + 1.1e-3);
}

TEST_CASE("States between those of fixed steps are of order 4 in position and 3 in velocity", "[simulate]") {
  if (!has_sundials()) return;
  const Scene s = scene("dzhanibekov");
  EventDriven exact({.rtol = 1e-13});
  const Trajectory motion = simulate(s.model, exact, s.start, {.t_end = 2});
  double error_q[2], error_nu[2];
  for (const int k : {0, 1}) {
    const double h = 0.1 / (1 << k);
    error_q[k] = error_nu[k] = 0;
    for (double t = 0.5; t < 1; t += h) {
      Trajectory two(motion.at(t), 1);
      two.add(motion.at(t + h), {});
      two.model = std::make_shared<const Model>(s.model);
      for (const double share : {0.25, 0.5, 0.7}) {
        const State x = two.at(t + share * h), right = motion.at(t + share * h);
        error_q[k] = std::max(error_q[k], (x.q - right.q).norm());
        error_nu[k] = std::max(error_nu[k], (x.nu - right.nu).norm());
      }
    }
  }
  const double order_q = std::log2(error_q[0] / error_q[1]), order_nu = std::log2(error_nu[0] / error_nu[1]);
  CAPTURE(error_q[0], error_q[1], error_nu[0], error_nu[1]);
  CHECK(order_q > 3.7);
  CHECK(order_q < 4.5);
  CHECK(order_nu > 2.7);
  CHECK(order_nu < 3.5);
}

}  // namespace perp
