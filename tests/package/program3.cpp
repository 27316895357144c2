// An outside program: a brick on a floor, known by their shapes alone.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  perp::Model model;
  const perp::BodyId brick = model.add_body(perp::Shape::box({0.2, 0.1, 0.02}),
                                            {.density = 2400, .material = "clay", .name = "brick"});
  model.add_shape(perp::ground, perp::Shape::half_space(), {.material = "floor"});
  model.set_friction("floor", "clay", {.mu = 0.4, .e = 0.2});

  perp::State x = model.rest();
  model.set_position(x, brick, {0, 0, 0.01});
  model.set_velocity(x, brick, {1, 0, 0});
  perp::Ncp2Stepper ncp2;
  const perp::Trajectory run = perp::simulate(model, ncp2, x, {.t_end = 0.5, .h = 0.01});
  const double slid = model.position(run.back(), brick).x(), exact = 1 / (2 * 0.4 * 9.81);
  std::printf("brick of %.2f kg slid %.9f m, exact %.9f\n", model.body(brick).mass, slid, exact);

  perp::Model apart = model;  // and one that falls through
  apart.no_contact(perp::ground, brick);
  const perp::Trajectory fall = perp::simulate(apart, ncp2, x, {.t_end = 0.5, .h = 0.01});
  const double z = apart.position(fall.back(), brick).z();
  const bool right = std::abs(model.body(brick).mass - 0.96) < 1e-15 && std::abs(slid - exact) < 1e-4 &&
                     std::abs(z - (0.01 - 9.81 / 8)) < 1e-12;
  return right ? 0 : 1;
}
