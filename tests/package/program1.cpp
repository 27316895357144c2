// An outside program: a model, a step, what it did. Built against an installed perp.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const Eigen::MatrixXd A = Eigen::Vector2d(2, 4).asDiagonal();
  const Eigen::VectorXd b = Eigen::Vector2d(-1, 1);

  perp::Model model;
  const perp::BodyId ball = model.add_body(perp::Inertia::solid_sphere(1.0, 1.0));  // kg, m
  model.add_contact(perp::ground, ball, perp::sphere_on_plane(1.0), {.mu = 0.2});
  perp::State x = model.rest();
  model.set_position(x, ball, {0, 0, 1});
  model.set_velocity(x, ball, {2, 0, 0});  // v; and optionally w, both in world axes
  perp::LcpStepper stepper({.edges = 8});
  const perp::StepReport report =
      stepper.step(model, x, 0.01);  // report.advanced(), .residuals.normal, .iterations
  const perp::Trajectory run = perp::simulate(model, stepper, x, {.t_end = 0.6, .h = 0.01});
  const double vx = model.velocity(run.back(), ball).x();
  const perp::Lcp lcp{A, b};
  const perp::LcpSolution z = perp::solve_lcp(lcp);  // or perp::lemke(lcp)

  std::printf("perp %s: v %.15f m/s, exact 10/7; z %g %g, exact 0.5 0\n", perp::version, vx, z.z(0), z.z(1));
  const bool right = report.advanced() && report.residuals.normal < 1e-12 && report.iterations > 0 &&
                     std::abs(vx - 10.0 / 7) < 1e-12 && z.solved() && std::abs(z.z(0) - 0.5) < 1e-15 &&
                     z.z(1) == 0;
  return right ? 0 : 1;
}
