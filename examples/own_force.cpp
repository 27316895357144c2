// A force of one's own: linear drag on a falling ball, which comes to the speed m g/c.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const double m = 2, c = 4, g = 9.81;  // kg, N s/m, m/s^2
  perp::Model model;
  const perp::BodyId ball = model.add_body(perp::Inertia::solid_sphere(m, 0.1));
  model.add_force(ball, [=](const perp::Model& own, const perp::State& x) {
    return perp::Wrench{.force = -c * own.velocity(x, ball)};  // world axes, at the centre of mass
  });
  perp::Ncp2Stepper stepper;
  const perp::Trajectory run = perp::simulate(model, stepper, model.rest(), {.t_end = 1, .h = 1e-3});
  const double v = model.velocity(run.back(), ball).z(), exact = -m * g / c * (1 - std::exp(-c / m));
  std::printf("speed after 1 s %.7f m/s, exact %.7f m/s\n", v, exact);
  return std::abs(v - exact) < 1e-6 ? 0 : 1;
}
