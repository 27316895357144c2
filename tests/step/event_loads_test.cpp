// Loads that come and go while nothing else happens.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "perp/io/scene_file.hpp"
#include "perp/model/gaps.hpp"
#include "perp/model/timing.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

constexpr double strength = 1e4, begin = 20;  // [N], [s]

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
}

TEST_CASE("A force of one's own that names its times acts however short it is", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-6, 1e-3, 0.1);
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId p = model.add_particle(1);
  const auto push = [width](const Model&, const State& x) {
    return Wrench{{x.t >= begin && x.t < begin + width ? strength : 0, 0, 0}, Vector3::Zero()};
  };
  model.add_force(p, Timed<Wrench(const Model&, const State&)>(push, {.times = {begin, begin + width}}));
  EventDriven stepper;
  const Trajectory run = simulate(model, stepper, model.rest(), {.t_end = 30});
  const double v = strength * ((begin + width) - begin);
  CAPTURE(width);
  CHECK(std::abs(run.back().nu[0] - v) < 1e-9 * v);
}

TEST_CASE("Smooth pushes are seen from a hundredth of a second in half a minute on", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-2, 0.05, 0.3);
  const Scene s = pushed("exp(-((t - 17.3)/" + std::to_string(width) + ")^2)");
  const Trajectory run = run_to(s, 30);
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
}

TEST_CASE("A square wave jumps at each of its edges", "[event][loads]") {
  if (!has_sundials()) return;
  const Scene s = pushed("step(sin(10*t))");
  const Trajectory run = run_to(s, 2);
  CHECK(std::abs(run.back().nu[0] - (3 * std::numbers::pi / 10 + (2 - 6 * std::numbers::pi / 10))) < 1e-10);
}

}  // namespace perp
