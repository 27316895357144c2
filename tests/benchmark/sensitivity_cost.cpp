// What derivatives cost: a run with five columns of sensitivities, in runs, both timed in turn. Machines and their load differ: the least of
// many is taken. To count instead, under `valgrind --tool=callgrind`, SCENE METHOD run|sensitivity does one of them once.
//   sensitivity_cost [SCENE METHOD run|sensitivity]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <perp/perp.hpp>
#include <string>

namespace {

using perp::Vector;

/// A built-in scene, each parameter times some of five factors.
perp::ParametricModel by_factors(const std::string& name) {
  return [name, scene = perp::scene(name)](const Vector& factor) {
    perp::SceneParameters set;
    for (const perp::SceneParameter& p : scene.parameters) set[p.name] = p.value;
    for (Eigen::Index i = 0; i < factor.size(); ++i)
      set[scene.parameters[static_cast<std::size_t>(i) % scene.parameters.size()].name] *= factor[i];
    perp::Scene made = perp::scene(name, set);
    return perp::ModelAtStart{std::move(made.model), std::move(made.start)};
  };
}

/// Takes rows and keeps none.
struct NoRows final : perp::RunSink {
  void step(const perp::State&, const perp::StepReport&) override {}
};

struct Work {
  std::function<void()> run, sensitivity;
};

Work work_of(const std::string& name, const std::string& method) {
  const auto model = by_factors(name);
  const double t_end = perp::scene(name).t_end, h = method == "event" ? perp::not_set : t_end / 300;
  const Vector factors = Vector::Ones(5);
  return {[=] {
            const auto stepper = perp::make_stepper(method, {});
            const perp::ModelAtStart at = model(factors);
            NoRows rows;
            (void)perp::simulate(at.model, *stepper, at.start, {.t_end = t_end, .h = h}, rows);
          },
          [=] {
            const auto stepper = perp::make_stepper(method, {});
            (void)perp::sensitivity(model, factors, *stepper, {.t_end = t_end, .h = h});
          }};
}

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4) {
    const Work work = work_of(argv[1], argv[2]);
    (std::string(argv[3]) == "run" ? work.run : work.sensitivity)();
    return 0;
  }
  std::printf("five columns, in runs of the same scene (the run among them)\n");
  for (const char* method : {"ncp", "ncp2", "event"}) {
    if (std::string(method) == "event" && !perp::has_sundials()) continue;
    for (const char* scene : {"seed-sphere", "spring-block", "bouncing-ball", "bead-in-ring", "heavy-top",
                              "friction-pendulum", "slider-crank", "four-bar"}) {
      const Work work = work_of(scene, method);
      double run = perp::infinity, both = perp::infinity;
      for (int repeat = 0; repeat < 15; ++repeat) {
        run = std::min(run, seconds(work.run));
        both = std::min(both, seconds(work.sensitivity));
      }
      std::printf("%-6s %-18s %5.1f\n", method, scene, both / run);
    }
  }
}
