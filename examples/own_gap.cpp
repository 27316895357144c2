// A gap of one's own with exact derivatives: a particle on the paraboloid z = (x^2 + y^2)/2, written once over a scalar type.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  perp::Model model;
  const perp::BodyId bead = model.add_particle(1);  // kg
  // gap = (z - r^2/2)/|gradient|: to first order the distance, with the surface's own normal
  const perp::Gap bowl = perp::differentiable([](const auto&, const auto& X_WB, auto) {
    using S = std::decay_t<decltype(X_WB.p[0])>;
    using std::sqrt;
    const S x = X_WB.p[0], y = X_WB.p[1], z = X_WB.p[2], length = sqrt(S(1) + x * x + y * y);
    perp::ContactPointOf<S> c;
    c.gap = (z - S(0.5) * (x * x + y * y)) / length;
    c.normal << S(-x / length), S(-y / length), S(S(1) / length);
    c.point = X_WB.p;
    return c;
  });
  model.add_contact(perp::ground, bead, bowl, {.name = "bowl"});

  // on a circle of radius 1 m it stays where its speed is sqrt(g)
  perp::State x = model.rest();
  model.set_position(x, bead, {1, 0, 0.5});
  model.set_velocity(x, bead, {0, std::sqrt(9.81), 0});
  perp::Ncp2Stepper stepper;
  const perp::Trajectory run = perp::simulate(model, stepper, x, {.t_end = 2, .h = 1e-3});
  const perp::Vector3 p = model.position(run.back(), bead);
  const double angle = std::sqrt(9.81) * 2,
               error = std::hypot(p.x() - std::cos(angle), p.y() - std::sin(angle));
  std::printf("after %.3f turns it is %.1e m from where it should be\n", angle / 6.283185307179586, error);
  return error < 1e-4 ? 0 : 1;
}
