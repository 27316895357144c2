// What a step costs: microseconds a step beside a fixed kernel timed in the same run, since machines and their load differ.
//   step_cost            a sphere, spheres that do not touch each other, a stack of boxes, a pile of spheres as it settles
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

#include "tests/benchmark/stopwatch.hpp"

namespace {

using perp::best, perp::kernel;

/// Spheres that slide on a plane, too far apart to meet, for the whole of the measurement.
double spheres(int number, perp::Stepper&& stepper, int steps) {
  perp::Model model;
  for (int i = 0; i < number; ++i) {
    const perp::BodyId ball = model.add_body(perp::Inertia::solid_sphere(1, 1));
    model.add_contact(perp::ground, ball, perp::sphere_on_plane(1), {.mu = 0.2});
  }
  perp::State start = model.rest();
  for (int i = 0; i < number; ++i) {
    model.set_position(start, {1 + i}, {0, 10.0 * i, 1});
    model.set_velocity(start, {1 + i}, {2, 0, 0});
  }
  return best(steps, [&](int count) {
    const perp::Trajectory run = perp::simulate(model, stepper, start, {.t_end = 0.2, .h = 0.2 / count});
    if (run.figures(run.steps() - 1).residuals.normal > 1e-12) std::printf("a residual above 1e-12\n");
  });
}

/// A built-in scene up to t_end: seconds a step, over all of its steps.
double scene_step(const char* name, const perp::SceneParameters& set, perp::Stepper&& stepper, double h,
                  double t_end) {
  const perp::Scene scene = perp::scene(name, set);
  double residual = 0;
  const int steps = static_cast<int>(std::lround(t_end / h));
  const auto start = std::chrono::steady_clock::now();
  perp::State x = scene.start;
  perp::StepReport report;
  for (int k = 0; k < steps; ++k) {
    stepper.step(scene.model, x, {.h = h}, report);
    if (!report.advanced()) {
      std::printf("%s stopped: %s\n", name, report.message.c_str());
      break;
    }
    residual = std::max({residual, report.residuals.normal, report.residuals.friction});
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  if (residual > 1e-10) std::printf("%s: residual %.1e m/s\n", name, residual);
  return taken.count() / steps;
}

}  // namespace

int main() {
  const double unit = kernel();
  std::printf("kernel (32 x 32 matrix product): %.2f us\n\n%-36s %10s %10s\n", unit * 1e6, "step", "us",
              "kernels");
  const auto line = [unit](const char* what, double seconds) {
    std::printf("%-36s %10.2f %10.2f\n", what, seconds * 1e6, seconds / unit);
  };
  const double one = spheres(1, perp::LcpStepper({.edges = 4}), 100000);
  line("1 sphere, 4 edges", one);
  line("1 sphere, 8 edges", spheres(1, perp::LcpStepper({.edges = 8}), 100000));
  line("1 sphere, 4 edges, mixed form",
       spheres(1, perp::LcpStepper({.edges = 4, .form = perp::LcpForm::Mixed}), 2000));
  const double many = spheres(1000, perp::LcpStepper({.edges = 4}), 100);
  line("1000 spheres apart, 4 edges", many);
  line("1 sphere, ncp", spheres(1, perp::NcpStepper(), 100000));
  line("1 sphere, ncp2", spheres(1, perp::Ncp2Stepper(), 100000));
  line("10 boxes, 40 contacts, ncp",
       scene_step("stack", {{"count", 10}, {"ratio", 1}}, perp::NcpStepper(), 0.01, 2));
  line("10 boxes, 40 contacts, ncp2",
       scene_step("stack", {{"count", 10}, {"ratio", 1}}, perp::Ncp2Stepper(), 0.01, 2));
  const double small = scene_step("pile", {{"count", 100}}, perp::NcpStepper(), 0.01, 0.4);
  line("100 spheres settling, ncp", small);
  const double large = scene_step("pile", {{"count", 1000}}, perp::NcpStepper(), 0.01, 0.4);
  line("1000 spheres settling, ncp", large);
  std::printf("\n1000 spheres apart cost %.0f times one; of the pile the cost grows as N^%.2f\n", many / one,
              std::log10(large / small));
  return 0;
}
