// Contact forces over time: the normal force on a ball that rolls through a valley, at the bottom m g + m v^2/(R - r).
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const double m = 1, R = 1, r = 0.1, g = 9.81;  // kg, m, m, m/s^2
  perp::Model model;
  model.set_gravity({0, -g, 0});
  const perp::BodyId disc = model.add_planar_body(m, 0.5 * m * r * r);
  model.add_contact(perp::ground, disc, perp::disc_in_circle(R, r), {.mu = 1, .name = "valley"});
  perp::State x = model.rest();
  const double a = 0.5;  // rad from the bottom
  model.set_position(x, disc, {(R - r) * std::sin(a), -(R - r) * std::cos(a), 0});
  perp::Ncp2Stepper stepper;
  const perp::Trajectory run = perp::simulate(model, stepper, x, {.t_end = 2, .h = 1e-3});
  double largest = 0;
  for (std::size_t i = 0; i < run.steps(); ++i) {
    const perp::ContactRow row = run.report(i).contact("valley");  // impulse over the step, on b, world axes
    largest = std::max(largest, row.p_n / run.figures(i).h);
  }
  // rolling, 3/4 m v^2 = m g (R - r) (1 - cos a)
  const double exact = m * g * (1 + 4.0 / 3 * (1 - std::cos(a)));
  std::printf("largest normal force %.5f N, exact %.5f N\n", largest, exact);
  return std::abs(largest - exact) < 1e-4 * exact ? 0 : 1;
}
