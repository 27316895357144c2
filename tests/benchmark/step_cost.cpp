// What a step costs: microseconds a step beside a fixed kernel timed in the same run, since machines and their load differ.
//   step_cost            the sphere in both forms, and 1 to 1000 spheres that do not touch each other
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <perp/perp.hpp>

namespace {

/// Seconds of the best of some runs of `work`, each of which does it `count` times; per time.
template <class Work>
double best(int count, Work work) {
  double least = perp::infinity;
  for (int repeat = 0; repeat < 7; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    work(count);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    least = std::min(least, taken.count() / count);
  }
  return least;
}

/// The kernel: a dense 32 by 32 matrix product, 65536 operations.
double kernel() {
  const perp::Matrix A = perp::Matrix::Constant(32, 32, 1.0 / 32);
  perp::Matrix B = perp::Matrix::Identity(32, 32), C;
  return best(2000, [&](int count) {
    for (int i = 0; i < count; ++i) {
      C.noalias() = A * B;
      B.swap(C);
    }
  });
}

/// Spheres that slide on a plane, too far apart to meet, for the whole of the measurement.
double spheres(int number, perp::LcpStepper stepper, int steps) {
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
  std::printf("\n1000 spheres cost %.0f times one\n", many / one);
  return 0;
}
