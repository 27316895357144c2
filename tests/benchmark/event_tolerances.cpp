// The event-driven method's tolerance against its true error and what it costs, for each integrator; and what one run of the seed's
// sphere costs beside a fixed kernel.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <perp/perp.hpp>

namespace {

double cpu_now() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// CPU seconds of the best of some runs of `work`.
template <class Work>
double best(int repeats, Work work) {
  double least = perp::infinity;
  for (int i = 0; i < repeats; ++i) {
    const double start = cpu_now();
    work();
    least = std::min(least, cpu_now() - start);
  }
  return least;
}

/// The kernel: a dense 32 by 32 matrix product, 65536 operations.
double kernel() {
  const perp::Matrix A = perp::Matrix::Constant(32, 32, 1.0 / 32);
  perp::Matrix B = perp::Matrix::Identity(32, 32), C;
  constexpr int count = 2000;
  return best(7,
              [&] {
                for (int i = 0; i < count; ++i) {
                  C.noalias() = A * B;
                  B.swap(C);
                }
              }) /
         count;
}

struct Case {
  const char* scene;
  perp::SceneParameters set;
  double until;
};

}  // namespace

int main() {
  const double unit = kernel();
  const Case cases[] = {{"seed-sphere", {}, 0.6},
                        {"cross-incline", {{"k", 1.5}}, 0.6},
                        {"ball-on-sphere", {}, 1.5},
                        {"dzhanibekov", {}, 5},
                        {"rolling-ellipse", {}, 0.5}};
  for (const Case& c : cases) {
    const perp::Scene scene = perp::scene(c.scene, c.set);
    const perp::State exact = scene.exact(c.until);
    std::printf("\n%s to t = %g s: error [m, rad] / evaluations / CPU [us]\n%8s", c.scene, c.until, "rtol");
    const perp::Integrator integrators[] = {perp::Integrator::Arkode, perp::Integrator::CvodeAdams,
                                            perp::Integrator::CvodeBdf, perp::Integrator::Ida};
    for (const perp::Integrator i : integrators) std::printf("  %-24s", std::string(name_of(i)).c_str());
    for (double tolerance = 1e-4; tolerance > 0.5e-12; tolerance *= 0.01) {
      std::printf("\n%8.0e", tolerance);
      for (const perp::Integrator i : integrators) {
        perp::EventDriven stepper({.rtol = tolerance, .integrator = i});
        perp::Trajectory run;
        const double seconds =
            best(5, [&] { run = perp::simulate(scene.model, stepper, scene.start, {.t_end = c.until}); });
        std::printf("  %7.1e %6ld %8.0f ", perp::configuration_error(scene.model, run.back(), exact),
                    run.evaluations, seconds * 1e6);
      }
    }
    std::printf("\n");
  }
  const perp::Scene sphere = perp::scene("seed-sphere");
  perp::EventDriven stepper({.rtol = 1e-12});
  perp::Trajectory run;
  const double seconds =
      best(50, [&] { run = perp::simulate(sphere.model, stepper, sphere.start, {.t_end = 0.6}); });
  std::printf(
      "\nseed-sphere at 1e-12: %ld evaluations, %.0f us of CPU, %.0f kernels (32 x 32 matrix products) of "
      "%.2f us\n",
      run.evaluations, seconds * 1e6, seconds / unit, unit * 1e6);
  return 0;
}
