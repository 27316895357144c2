// An outside program: a gap of one's own, a marble in a bowl of radius R centred at the first body's origin.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const double R = 1.0, r = 0.1;  // m
  perp::Model model;
  const perp::BodyId marble = model.add_body(perp::Inertia::solid_sphere(0.2, r));  // kg, m

  const perp::Gap marble_in_bowl = [=](const perp::Pose& bowl, const perp::Pose& marble, double /*t*/) {
    const perp::Vector3 d = bowl.p - marble.p, n = d.normalized();
    return perp::ContactPoint{.gap = R - r - d.norm(), .normal = n, .point = marble.p - r * n};
  };
  model.add_contact(perp::ground, marble, marble_in_bowl);

  // Without friction the marble slides as a pendulum of length R - r: its energy stays, to the step's order.
  perp::State x = model.rest();
  model.set_position(x, marble, {R - r, 0, 0});
  perp::LcpStepper stepper;
  const perp::Trajectory run = perp::simulate(model, stepper, x, {.t_end = 0.3, .h = 1e-4});
  const perp::Vector3 p = model.position(run.back(), marble), v = model.velocity(run.back(), marble);
  const double speed = std::sqrt(-2 * 9.81 * p.z());
  std::printf("marble %.6f m from the centre, exact %g; %.6f m/s, exact %.6f\n", p.norm(), R - r, v.norm(),
              speed);
  return std::abs(p.norm() - (R - r)) < 1e-3 && std::abs(v.norm() - speed) < 1e-3 * speed ? 0 : 1;
}
