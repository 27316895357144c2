// What modelling less saves: one slider-crank of planar bodies, of spatial bodies with redundant joints, and in one coordinate. Sizes,
// cost of a step beside a fixed kernel, and how far the crank's angle is from the exact one after 0.3 s.
#include <cmath>
#include <cstdio>
#include <memory>

#include "perp/instant/reduced_system.hpp"
#include "tests/benchmark/stopwatch.hpp"
#include "tests/step/generalized_scenes.hpp"

namespace {

using namespace perp;

struct Way {
  const char* name;
  Scene scene;
  double (*crank)(const Model&, const State&);
};

double crank_of_body(const Model& model, const State& x) {
  return model.coordinate(x, model.find_joint("bearing"));
}
double crank_itself(const Model&, const State& x) { return x.q[0]; }

}  // namespace

int main() {
  const Way ways[] = {{"planar bodies", scene("slider-crank"), crank_of_body},
                      {"spatial bodies", spatial_slider_crank(), crank_of_body},
                      {"one coordinate", slider_crank_of_one_angle(), crank_itself}};
  constexpr double t_end = 0.3, h = 1e-3;
  const double exact = crank_of_body(ways[0].scene.model, ways[0].scene.exact(t_end));
  const double unit = kernel();
  std::printf("kernel (32 x 32 matrix product): %.2f us; h = %g s, t = %g s\n\n", unit * 1e6, h, t_end);
  std::printf("%-16s %10s %5s %5s %9s  %-6s %9s %9s %11s\n", "", "velocities", "rows", "rank", "frictions",
              "method", "us", "kernels", "error [rad]");
  for (const Way& way : ways) {
    const Model& model = way.scene.model;
    Instant now;
    evaluate(model, way.scene.start, now);
    for (const char* method : {"lcp", "ncp", "ncp2", "event"}) {
      const std::unique_ptr<Stepper> stepper = make_stepper(method, {});
      const SimulateOptions options{.t_end = t_end, .h = chooses_steps(*stepper) ? not_set : h};
      const Trajectory run = simulate(model, *stepper, way.scene.start, options);
      const int steps = static_cast<int>(run.steps());
      const double seconds =
          best(1, [&](int) { (void)simulate(model, *stepper, way.scene.start, options); }) / steps;
      std::printf("%-16s %10d %5zu %5d %9zu  %-6s %9.2f %9.2f %11.2e\n", way.name, model.nv(),
                  now.joint_rows.size(), joint_rank(model, now), now.joint_frictions.size(), method,
                  seconds * 1e6, seconds / unit, way.crank(model, run.back()) - exact);
    }
  }
  return 0;
}
