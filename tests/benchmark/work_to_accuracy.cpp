// CPU time to an error of 1e-6, 1e-8, 1e-10 and 1e-12 of the configuration at T, by ncp2, event and extrapolated in one run: the cheapest of a
// ladder of steps or tolerances that is as accurate. The nine smooth scenes of the ladder, and eight on which `event` is weak.
//   work_to_accuracy [NAME...]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <perp/perp.hpp>

namespace perp {
namespace {

double cpu_now() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Case {
  std::string name;
  Model model;
  State x;
  double T = 1;
  State end;  ///< the reference
};

constexpr double targets[] = {1e-6, 1e-8, 1e-10, 1e-12};
constexpr double most_seconds = 4;  // a run that takes longer is the last of its ladder

/// Seconds and error of one run; the best of three where it is short.
struct Made {
  double seconds = infinity, error = infinity;
};

Made make(const Case& c, Stepper& stepper, double h) {
  Made made;
  for (int repeat = 0; repeat < 3 && (repeat == 0 || made.seconds < 0.3); ++repeat) {
    const double start = cpu_now();
    try {
      const Trajectory run = simulate(c.model, stepper, c.x, {.t_end = c.T, .h = h});
      made.seconds = std::min(made.seconds, cpu_now() - start);
      made.error = configuration_error(c.model, run.back(), c.end);
    } catch (const StepFailure&) {
      return {cpu_now() - start, infinity};
    }
  }
  return made;
}

std::vector<Made> ladder(const Case& c, const char* method) {
  std::vector<Made> all;
  if (std::strcmp(method, "ncp2") == 0) {
    for (double n = 20; all.empty() || all.back().seconds < most_seconds; n *= 2) {
      Ncp2Stepper stepper;
      all.push_back(make(c, stepper, c.T / n));
      if (all.back().error < 1e-8) break;
    }
    return all;
  }
  for (double digits = 4; digits <= 14; digits += 0.5) {
    const std::unique_ptr<Stepper> stepper = make_stepper(method, {.tolerance = std::pow(10, -digits)});
    all.push_back(make(c, *stepper, not_set));
    if (all.back().seconds > most_seconds || all.back().error < targets[3]) break;
  }
  return all;
}

void measure(Case c, bool exact) {
  if (!exact) {
    Extrapolated fine({.rtol = 1e-14});
    EventDriven event({.rtol = 1e-13});
    c.end = simulate(c.model, fine, c.x, {.t_end = c.T}).back();
    std::string apart = "-";
    try {
      char text[20];
      const State end = simulate(c.model, event, c.x, {.t_end = c.T}).back();
      std::snprintf(text, sizeof text, "%.1e", configuration_error(c.model, end, c.end));
      apart = text;
    } catch (const StepFailure& failure) {
      apart = failure.what();
    }
    std::printf("| %s: event at 1e-13 from extrapolated at 1e-14 | %s |\n", c.name.c_str(), apart.c_str());
  }
  for (const char* method : {"ncp2", "event", "extrapolated"}) {
    const std::vector<Made> all = ladder(c, method);
    std::printf("| %s | %s |", c.name.c_str(), method);
    for (const double target : targets) {
      double least = infinity;
      for (const Made& made : all)
        if (made.error <= target) least = std::min(least, made.seconds);
      if (std::isfinite(least))
        std::printf(" %.3g |", 1e3 * least);
      else
        std::printf(" - |");
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}

Case of_scene(const char* name, double T, const SceneParameters& set = {}) {
  Scene s = scene(name, set);
  Case c{.name = name, .model = s.model, .x = s.start, .T = T, .end = {}};
  if (s.exact) c.end = s.exact(T);
  return c;
}

/// A box of 0.2 x 0.2 x 0.1 m on its four lower corners, sliding and turning.
Case turning_box() {
  Case c{.name = "box that slides and turns", .model = {}, .x = {}, .T = 0.4, .end = {}};
  const BodyId box = c.model.add_body(Inertia::solid_box(1, {0.2, 0.2, 0.1}));
  c.model.add_contact(ground, box, box_on_plane({0.2, 0.2, 0.1}), {.mu = 0.3});
  c.x = c.model.rest();
  c.model.set_position(c.x, box, {0, 0, 0.05});
  c.model.set_velocity(c.x, box, {2, 0, 0}, {0, 0, 5});
  return c;
}

/// A table on four feet that is given a push.
Case pushed_table() {
  Case c = of_scene("table", 0.3);
  c.name = "pushed table";
  c.model.set_velocity(c.x, {1}, {1, 0.5, 0}, {0, 0, 0});
  return c;
}

/// Five cubes on each other; the lowest is pushed by a force that moves them all.
Case pushed_stack() {
  Case c = of_scene("stack", 0.3, {{"count", 5}, {"ratio", 1}});
  c.name = "pushed stack of five";
  for (int i = 1; i <= 5; ++i) c.model.set_velocity(c.x, {i}, {1, 0, 0});
  return c;
}

/// A rod that carries two spheres rolls and slides in a cylinder.
Case rod_in_cylinder() {
  Case c{.name = "rod with two spheres in a cylinder", .model = {}, .x = {}, .T = 0.5, .end = {}};
  const double r = 0.1, R = 1, half = 0.3;
  const BodyId rod = c.model.add_body(Inertia::solid_box(1, {0.1, 0.8, 0.1}));
  for (const double y : {-half, half})
    c.model.add_contact(ground, rod, placed(sphere_in_cylinder(R, r, Vector3::UnitY()), {}, {.p = {0, y, 0}}),
                        {.mu = 0.3});
  c.x = c.model.rest();
  const double angle = 0.5;
  c.model.set_position(c.x, rod, (R - r) * Vector3(std::sin(angle), 0, -std::cos(angle)));
  return c;
}

/// Twenty balls that do not meet roll in a bowl.
Case balls_in_bowl() {
  Case c{.name = "20 balls in a bowl", .model = {}, .x = {}, .T = 0.5, .end = {}};
  const double r = 0.05, R = 1;
  std::vector<BodyId> balls;
  for (int i = 0; i < 20; ++i) {
    balls.push_back(c.model.add_body(Inertia::solid_sphere(0.1, r)));
    c.model.add_contact(ground, balls.back(), sphere_in_sphere(R, r), {.mu = 0.5});
  }
  c.x = c.model.rest();
  for (int i = 0; i < 20; ++i) {
    const double a = 0.2 + 0.02 * i, b = 0.3 * i;
    c.model.set_position(
        c.x, balls[static_cast<std::size_t>(i)],
        (R - r) * Vector3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), -std::cos(a)));
  }
  return c;
}

/// Twenty links hang level from a hinge and are let go.
Case chain() {
  Case c{.name = "chain of 20 links", .model = {}, .x = {}, .T = 0.5, .end = {}};
  BodyId last = ground;
  for (int i = 0; i < 20; ++i) {
    const BodyId link =
        c.model.add_body(Inertia::solid_box(1, {0.1, 0.02, 0.02}), {.pose = {{0.1 * i + 0.05, 0, 0}}});
    c.model.add_joint(revolute(last, link, {.point = Vector3(0.1 * i, 0, 0), .axis = Vector3::UnitY()}));
    last = link;
  }
  c.x = c.model.rest();
  return c;
}

}  // namespace
}  // namespace perp

int main(int count, char** names) {
  using namespace perp;
  const auto wanted = [&](const std::string& name) {
    return count < 2 ||
           std::any_of(names + 1, names + count, [&](const char* n) { return name.find(n) == 0; });
  };
  std::printf("| scene | method | ms to 1e-6 | to 1e-8 | to 1e-10 | to 1e-12 |\n|---|---|---|---|---|---|\n");
  for (const auto& [name, T] :
       {std::pair("rolling-ellipse", 0.5), std::pair("bead-in-ring", 1.0), std::pair("bowl", 1.0),
        std::pair("roller-in-cylinder", 1.0), std::pair("double-pendulum", 1.0),
        std::pair("dzhanibekov", 1.0), std::pair("heavy-top", 0.3), std::pair("turntable", 1.0),
        std::pair("cross-incline", 0.4)})
    if (wanted(name)) measure(of_scene(name, T), true);
  for (const auto& make : {turning_box, pushed_stack, pushed_table, rod_in_cylinder, balls_in_bowl, chain})
    if (const Case c = make(); wanted(c.name)) measure(c, false);
  if (wanted("four-bar")) measure(of_scene("four-bar", 1), true);
  if (wanted("parallelogram")) measure(of_scene("parallelogram", 1), false);
  return 0;
}
