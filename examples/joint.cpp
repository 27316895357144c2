// A joint and its reaction: a rod on a hinge is let go level; where it passes below, the hinge carries 5/2 m g.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const double m = 3, L = 1, g = 9.81;  // kg, m, m/s^2
  perp::Model model;
  const perp::BodyId rod = model.add_body(perp::Inertia::principal(m, {1e-3, m * L * L / 12, m * L * L / 12}),
                                          {.pose = {{L / 2, 0, 0}}});
  model.add_joint(
      perp::revolute(perp::ground, rod, {.point = {0, 0, 0}, .axis = {0, 1, 0}, .name = "hinge"}));
  perp::Ncp2Stepper stepper;
  const perp::Trajectory run = perp::simulate(model, stepper, model.rest(), {.t_end = 1, .h = 1e-3});
  double largest = 0;
  for (std::size_t i = 0; i < run.steps(); ++i)
    largest = std::max(largest, run.report(i).joint("hinge").impulse.z() / run.figures(i).h);
  const double exact = 2.5 * m * g;
  std::printf("largest force on the hinge %.4f N, exact %.4f N\n", largest, exact);
  return std::abs(largest - exact) < 1e-4 * exact ? 0 : 1;
}
