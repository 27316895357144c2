// A sweep in threads: one const model each, a stepper each. A box slides to rest, for eight friction coefficients.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>
#include <thread>
#include <vector>

int main() {
  const double v0 = 2, g = 9.81;  // m/s, m/s^2
  std::vector<double> error(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < error.size(); ++i)
    threads.emplace_back([&, i] {
      const double mu = 0.1 * static_cast<double>(i + 1), exact = v0 * v0 / (2 * mu * g);
      perp::Model model;
      const perp::BodyId box = model.add_particle(1);
      model.add_contact(perp::ground, box, perp::particle_on_plane(), {.mu = mu});
      perp::State x = model.rest();
      model.set_velocity(x, box, {v0, 0, 0});
      perp::Ncp2Stepper stepper;
      const perp::Trajectory run =
          perp::simulate(model, stepper, x, {.t_end = 1.2 * v0 / (mu * g), .h = 1e-3});
      error[i] = std::abs(model.position(run.back(), box).x() - exact);
    });
  for (std::thread& thread : threads) thread.join();
  double worst = 0;
  for (const double e : error) worst = std::max(worst, e);
  std::printf("largest error of eight stopping distances %.1e m\n", worst);
  return worst < 1e-5 ? 0 : 1;
}
