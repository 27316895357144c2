// One case of tests/benchmark/against: what it costs, and how exactly it is answered. Prints
//   SECONDS WORST RESIDUAL NOTE
// CPU seconds a step (of `file` and `family` a problem, of `event` an evaluation), those of the longest, the largest residual met
// (normal and friction [m/s]; relative of a contact problem; |psi_b| of `event` [m]), and the mean iterations or what went wrong.
// It is compiled in the tree of another revision as well: it calls what all of them have.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <map>
#include <perp/perp.hpp>
#include <string>
#include <vector>

#include "perp/solve/friction_io.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/study/friction_families.hpp"

namespace {

using namespace perp;
using Words = std::vector<std::string>;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Cost {
  double seconds = 0, worst = 0, residual = 0;
  long count = 0, iterations = 0;
  std::string failure;

  void add(double time) {
    seconds += time;
    worst = std::max(worst, time);
    ++count;
  }
};

/// `steps` steps of h.
Cost run(const Model& model, State x, const std::string& method, double h, long steps) {
  const std::unique_ptr<Stepper> stepper = make_stepper(method);
  Cost cost;
  for (long k = 0; k < steps && cost.failure.empty(); ++k) {
    const double begin = cpu_seconds();
    const StepReport report = stepper->step(model, x, h);
    cost.add(cpu_seconds() - begin);
    cost.iterations += report.iterations;
    for (const double e : {report.residuals.normal, report.residuals.friction})
      if (e > cost.residual) cost.residual = e;
    if (!report.advanced()) cost.failure = "step " + std::to_string(k + 1) + ": " + report.message;
  }
  return cost;
}

/// A method that chooses its steps, up to t_end.
Cost run_adaptive(const Model& model, const State& x, double tolerance, double t_end) {
  EventDriven method({.rtol = tolerance, .atol = tolerance});
  Cost cost;
  const double begin = cpu_seconds();
  const Trajectory run = simulate(model, method, x, {.t_end = t_end});
  cost.add(cpu_seconds() - begin);
  cost.iterations = std::max(run.evaluations, 1L);
  for (std::size_t k = 0; k < run.steps(); ++k)
    cost.residual = std::max(cost.residual, run.figures(k).joint_error);
  cost.seconds /= static_cast<double>(cost.iterations);
  return cost;
}

/// METHOD: a sphere on a plane, or N apart, slide for .2 s.
Cost spheres(const std::string& method, int number, long steps) {
  Model model;
  for (int i = 0; i < number; ++i)
    model.add_contact(ground, model.add_body(Inertia::solid_sphere(1, 1)), sphere_on_plane(1), {.mu = 0.2});
  State start = model.rest();
  for (int i = 0; i < number; ++i) {
    model.set_position(start, {1 + i}, {0, 10.0 * i, 1});
    model.set_velocity(start, {1 + i}, {2, 0, 0});
  }
  return run(model, start, method, 0.2 / static_cast<double>(steps), steps);
}

/// METHOD: a box slides on its four corners for .2 s.
Cost box(const std::string& method) {
  Model model;
  const Vector3 size(1, 1, 1);
  const BodyId b = model.add_body(Inertia::solid_box(1, size), {.pose = {.p = {0, 0, 0.5}}});
  model.add_contact(ground, b, box_on_plane(size), {.mu = 0.3});
  State start = model.rest();
  model.set_velocity(start, b, {2, 1, 0});
  constexpr long steps = 4000;
  return run(model, start, method, 0.2 / steps, steps);
}

Cost scene_steps(const std::string& name, const SceneParameters& set, const std::string& method, double h,
                 double t_end) {
  const Scene s = scene(name, set);
  return run(s.model, s.start, method, h, std::lround(t_end / h));
}

/// N links on revolute joints, falling from the horizontal.
Cost chain(const std::string& method, int links) {
  Model model;
  BodyId last = ground;
  for (int i = 0; i < links; ++i) {
    const BodyId link =
        model.add_body(Inertia::solid_box(1, {1, 0.1, 0.1}), {.pose = {.p = {i + 0.5, 0, 0}}});
    model.add_joint(revolute(last, link, {.point = Vector3(i, 0, 0), .axis = Vector3::UnitY()}));
    last = link;
  }
  if (method == "event") return run_adaptive(model, model.rest(), 1e-8, 0.04);
  return run(model, model.rest(), method, 1e-3, 40);
}

void solve(const FrictionProblem& problem, Cost& cost) {
  double least = infinity, spent = 0;
  FrictionSolution s;
  for (int repeat = 0; repeat < 5 && spent < 0.1; ++repeat) {
    const double begin = cpu_seconds();
    s = solve_friction(problem);
    const double time = cpu_seconds() - begin;
    least = std::min(least, time), spent += time;
  }
  cost.add(least);
  cost.iterations += s.iterations;
  if (!s.solved())
    cost.failure += (cost.failure.empty() ? "" : ", ") + std::to_string(cost.count) + " not solved";
  cost.residual = std::max(cost.residual, s.residual);
}

Cost files(const Words& paths) {
  Cost cost;
  for (const std::string& path : paths) solve(read_friction_problem(path), cost);
  return cost;
}

Cost family(const std::string& name, std::uint64_t seed, int count) {
  Cost cost;
  for (int i = 0; i < count; ++i) solve(friction_family(name, seed, i), cost);
  return cost;
}

Cost measure(const std::string& kind, const Words& w) {
  const auto number = [&](std::size_t i) { return std::stod(w.at(i)); };
  const auto whole = [&](std::size_t i) { return std::stoi(w.at(i)); };
  if (kind == "sphere") return spheres(w.at(0), 1, 20000);
  if (kind == "apart") return spheres(w.at(0), whole(1), 100);
  if (kind == "box") return box(w.at(0));
  if (kind == "stack")
    return scene_steps("stack", {{"count", number(1)}, {"ratio", number(2)}}, w.at(0), number(3), number(4));
  if (kind == "pile") return scene_steps("pile", {{"count", number(1)}}, w.at(0), 0.01, number(2));
  if (kind == "scene") return scene_steps(w.at(1), {}, w.at(0), number(2), number(3));
  if (kind == "chain") return chain(w.at(0), whole(1));
  if (kind == "event") {
    const Scene s = scene(w.at(0));
    return run_adaptive(s.model, s.start, number(1), w.size() > 2 ? number(2) : s.t_end);
  }
  if (kind == "file") return files(w);
  if (kind == "family") return family(w.at(0), std::stoull(w.at(1)), whole(2));
  throw std::invalid_argument("no case of this kind: " + kind);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Words words(argv + std::min(argc, 2), argv + argc);
    const Cost cost = measure(argc > 1 ? argv[1] : "", words);
    const auto count = static_cast<double>(std::max(cost.count, 1L));
    std::printf("%.6g %.6g %.2e ", cost.seconds / count, cost.worst, cost.residual);
    if (cost.failure.empty())
      std::printf("%.4g it\n", static_cast<double>(cost.iterations) / count);
    else
      std::printf("%s\n", cost.failure.c_str());
    return 0;
  } catch (const std::exception& error) {
    std::printf("nan nan nan %s\n", error.what());
    return 1;
  }
}
