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

long count(const Trajectory& run, EventKind kind) {
  return std::count_if(run.events.begin(), run.events.end(), [&](const Event& e) { return e.kind == kind; });
}

/// The largest residual of any row's own equations.
double residual(const Trajectory& run) {
  double worst = 0;
  for (std::size_t i = 0; i < run.steps(); ++i) {
    const Residuals& r = run.figures(i).residuals;
    for (const double part : {r.newton_euler, r.kinematic, r.joints, r.normal, r.friction})
      if (!std::isnan(part)) worst = std::max(worst, part);
  }
  return worst;
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
  REQUIRE(count(run, EventKind::Load) == 2);
  CHECK(run.events[0].contact == "p");
  CHECK(std::abs(run.events[0].t - begin) < 1e-14 * begin);
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

TEST_CASE(
    "A force of one's own that names nothing acts where it is looked at, and the run says how often that is",
    "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-3, 1e-2, 0.1, 1.0);
  Model model;
  model.set_gravity(Vector3::Zero());
  const BodyId p = model.add_particle(1);
  model.add_force(p, [width](const Model&, const State& x) {
    return Wrench{{x.t >= begin && x.t < begin + width ? strength : 0, 0, 0}, Vector3::Zero()};
  });
  const double look = 0.4 * width, v = strength * ((begin + width) - begin);
  EventDriven looks({.look = look}), plain;
  const Trajectory seen = simulate(model, looks, model.rest(), {.t_end = 30});
  CAPTURE(width, seen.back().nu[0] / v - 1);
  CHECK(std::abs(seen.back().nu[0] - v) < 1e-8 * v);
  CHECK(seen.unseen <= look);
  CHECK(seen.unseen > 0.5 * look);
  const Trajectory run = simulate(model, plain, model.rest(), {.t_end = 30});
  CHECK(run.unseen <= 30.0 / 4096);
  CHECK(run.unseen > 0.5 * 30.0 / 4096);
  // a force that is there and does not change with time cannot be told from one that does
  Model still;
  const BodyId ball = still.add_particle(1);
  CHECK(simulate(still, plain, still.rest(), {.t_end = 1}).unseen == 0);
  still.add_force(ball, [](const Model&, const State&) { return Wrench{{1, 0, 0}, Vector3::Zero()}; });
  CHECK(simulate(still, plain, still.rest(), {.t_end = 1}).unseen > 0);
}

TEST_CASE(
    "Smooth pushes are seen from a hundredth of a second in half a minute on, and with looks from a "
    "thousandth",
    "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-3, 1e-2, 0.05, 0.3, 1.0);
  const EventDrivenOptions options{.look = width < 1e-2 ? width : not_set};
  const std::string pulse = "exp(-((t - 17.3)/" + std::to_string(width) + ")^2)";
  const double v = width * std::sqrt(std::numbers::pi);
  CAPTURE(width);
  SECTION("of forces") {
    const Trajectory run = run_to(pushed(pulse), 30, options);
    CHECK(std::abs(run.back().nu[0] - v) < 1e-9);
    CHECK(run.unseen <= (width < 1e-2 ? width : 30.0 / 4096));
  }
  SECTION("of forces along the way of what moves") {
    const Trajectory run = run_to(pushed(pulse, "velocity = [-1, 0.5, 0]\n"), 30, options);
    CHECK(std::abs(run.back().nu[0] - (v - 1)) < 1e-9);
  }
  SECTION("of motors") {
    const Scene s = read_scene(
        "gravity = [0, 0, 0]\n[[body]]\nname = \"arm\"\nkind = \"planar\"\nmass = 1\ninertia = 0.1\n"
        "position = [0.5, 0]\n[[joint]]\nname = \"hinge\"\nkind = \"revolute\"\na = \"ground\"\nb = "
        "\"arm\"\n"
        "point = [0, 0, 0]\n[[motor]]\njoint = \"hinge\"\neffort = \"" +
            pulse + "\"\n",
        "arm.toml");
    const Trajectory run = run_to(s, 30, options);
    CHECK(std::abs(s.model.coordinate_rate(run.back(), s.model.find_joint("hinge")) - v / 0.35) < 1e-8);
  }
}

TEST_CASE("Smooth motions of a moment pull their springs, of bodies and of joints", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-3, 1e-2, 0.05, 0.3), omega = 2, t_end = 30, strong = 0.5;
  const std::string path = "0.5*exp(-((t - 17.3)/" + std::to_string(width) + ")^2)";
  const std::string hand =
      GENERATE(0, 1) == 0 ? "kind = \"prescribed\"\nmotion = { kind = \"function\", position = [\"" + path +
                                "\", 0, 0], rotation = [0, 0, 0] }\n"
                          : "kind = \"spatial\"\nmass = 3\ninertia = { moments = [1, 1, 1] }\n"
                            "[[joint]]\nname = \"rail\"\nkind = \"prismatic\"\na = \"ground\"\nb = \"hand\"\n"
                            "point = [0, 0, 0]\naxis = [1, 0, 0]\n"
                            "[[motor]]\njoint = \"rail\"\nmotion = \"" +
                                path + "\"\n";
  const Scene s = read_scene("gravity = [0, 0, 0]\n[[body]]\nname = \"hand\"\n" + hand +
                                 "[[body]]\nname = \"p\"\nkind = \"particle\"\nmass = 1\n"
                                 "[[spring]]\na = \"hand\"\nb = \"p\"\nstiffness = 4\n",
                             "hand.toml");
  const Trajectory run = run_to(s, t_end, {.look = width < 1e-2 ? width : not_set});
  // the integral of omega sin(omega (T - t)) p(t): a Gaussian's transform
  const double x = omega * strong * width * std::sqrt(std::numbers::pi) *
                   std::exp(-0.25 * omega * omega * width * width) * std::sin(omega * (t_end - 17.3));
  CAPTURE(width, hand, x);
  CHECK(std::abs(s.model.position(run.back(), s.model.find_body("p")).x() - x) < 2e-9);
}

TEST_CASE("Every integrator sees a push on what rests in the origin", "[event][loads]") {
  if (!has_sundials()) return;
  using enum Integrator;
  const Integrator integrator = GENERATE(Arkode, CvodeAdams, CvodeBdf, Ida);
  const double width = GENERATE(1e-3, 1e-2);
  const Scene s = pushed("exp(-((t - 17.3)/" + std::to_string(width) + ")^2)");
  const Trajectory run = run_to(s, 30, {.integrator = integrator, .look = width < 1e-2 ? width : not_set});
  CAPTURE(name_of(integrator), width);
  CHECK(std::abs(run.back().nu[0] - width * std::sqrt(std::numbers::pi)) < 2e-8);
  CHECK(count(run, EventKind::Zeno) == 0);
}

TEST_CASE("A plate that rises for a moment knocks a ball away", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-3, 1e-2, 0.1);
  const Scene s = read_scene(
      "gravity = [0, 0, 0]\n[[body]]\nname = \"plate\"\nkind = \"prescribed\"\nmotion = { kind = "
      "\"function\", position = [0, 0, "
      "\"0.02*exp(-((t - 17.3)/" +
          std::to_string(width) +
          ")^2)\"], rotation = [0, 0, 0] }\n"
          "[[body]]\nname = \"ball\"\nkind = \"particle\"\nmass = 1\nposition = [0, 0, 0.01]\n"
          "[[contact]]\na = \"plate\"\nb = \"ball\"\ngap = { kind = \"particle_on_plane\" }\ne = 1\n",
      "plate.toml");
  const Trajectory run = run_to(s, 30, {.look = width < 1e-2 ? width : not_set});
  // at the half height s = sqrt(ln 2) before the top the plate rises at .02 2 s exp(-s^2)/width; the ball leaves at twice that
  const double rise = 0.02 * 2 * std::sqrt(std::numbers::ln2) * 0.5 / width;
  CAPTURE(width);
  CHECK(std::abs(run.back().nu[2] - 2 * rise) < 1e-8 * rise);
}

TEST_CASE("What a table moves for a moment pulls its spring, however short that is", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-3, 1e-2, 0.1, 1.0), t_end = 30, omega = 2;
  const std::string from = std::to_string(17.3), top = std::to_string(17.3 + width),
                    to = std::to_string(17.3 + 2 * width);
  const Scene s = read_scene(
      "gravity = [0, 0, 0]\n[[body]]\nname = \"hand\"\nkind = \"prescribed\"\nmotion = { kind = \"table\", "
      "t = [0, 17, " +
          from + ", " + top + ", " + to +
          ", 29, 30], "
          "position = [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0.3, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]] }\n"
          "[[body]]\nname = \"p\"\nkind = \"particle\"\nmass = 1\n"
          "[[spring]]\na = \"hand\"\nb = \"p\"\nstiffness = 4\n",
      "hand.toml");
  // x(T) is the integral of omega sin(omega (T - t)) p(t), by Simpson's rule on the pieces of the table
  double x = 0;
  const double knots[] = {0, 17, std::stod(from), std::stod(top), std::stod(to), 29, 30};
  for (std::size_t k = 0; k + 1 < std::size(knots); ++k) {
    const int n = 20000;
    const double h = (knots[k + 1] - knots[k]) / n;
    for (int i = 0; i <= n; ++i) {
      const double t = knots[k] + i * h, weight = i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2;
      x += weight * h / 3 * omega * std::sin(omega * (t_end - t)) * s.model.bodies()[1].motion.pose(t).p.x();
    }
  }
  const Trajectory run = run_to(s, t_end);
  CAPTURE(width, x);
  CHECK(std::abs(x) > 1e-5);
  CHECK(std::abs(run.back().q[0] - x) < 1e-9 * std::max(1.0, std::abs(x)));
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
  CHECK(residual(run) < 1e-9);
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
  CHECK(residual(run) < 1e-8);
}

TEST_CASE("A force that jumps where the body is jumps there", "[event][loads]") {
  if (!has_sundials()) return;
  const Scene s = pushed("-100*step(x - 1)", "velocity = [1, 0, 0]\n");
  const Trajectory run = run_to(s, 3);
  // into the field at t = 1, back at 1.02 with the same speed
  CHECK(std::abs(run.back().q[0] + 0.98) < 1e-8);
  CHECK(count(run, EventKind::Load) == 2);
}

TEST_CASE("A field that is crossed within one step of the integrator acts", "[event][loads]") {
  if (!has_sundials()) return;
  const double width = GENERATE(1e-3, 1e-2, 0.1);
  const Scene s =
      pushed("-0.4*(step(x - 1) - step(x - 1 - " + std::to_string(width) + "))", "velocity = [1, 0, 0]\n");
  const Trajectory run = run_to(s, 3, {.look = 0.4 * width});
  CAPTURE(width);
  CHECK(std::abs(run.back().nu[0] - std::sqrt(1 - 0.8 * width)) < 1e-9);
  CHECK(residual(run) < 1e-9);
  CHECK(count(run, EventKind::Load) == 2);
}

TEST_CASE("A square wave jumps at each of its edges", "[event][loads]") {
  if (!has_sundials()) return;
  const Scene s = pushed("step(sin(10*t))");
  const Trajectory run = run_to(s, 2);
  CHECK(count(run, EventKind::Load) == 6);
  CHECK(std::abs(run.back().nu[0] - (3 * std::numbers::pi / 10 + (2 - 6 * std::numbers::pi / 10))) < 1e-10);
}

}  // namespace perp
