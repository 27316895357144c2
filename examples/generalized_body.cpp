// A body in coordinates of its own: a bead on a wire bent to the parabola y = x^2/2, in its x alone, against a stop at
// x = 1 m. The wire needs no joint, no contact and no second coordinate: it is in the mass and in the force.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const double m = 1, g = 9.81, e = 0.5, start = -1.5, stop = 1;  // kg, m/s^2, -, m, m
  perp::Model model;
  const auto mass = [=](const perp::Vector& q) -> perp::Matrix {  // 1/2 M x'^2, v^2 = (1 + x^2) x'^2
    return perp::Matrix::Constant(1, 1, m * (1 + q[0] * q[0]));
  };
  const auto force = [=](const perp::Vector& q, const perp::Vector& nu, double) -> perp::Vector {
    return perp::Vector::Constant(1, -m * q[0] * nu[0] * nu[0] - m * g * q[0]);  // M' brings the first
  };
  const auto potential = [=](const perp::Vector& q) { return m * g * q[0] * q[0] / 2; };
  const perp::BodyId bead =
      model.add_generalized(1, {.mass = mass, .force = force, .potential = potential}, "bead");
  const perp::GeneralizedGap gap = [=](const perp::Vector& q, double) {
    return perp::GeneralizedPoint{.gap = stop - q[0], .normal = perp::Vector::Constant(1, -1)};
  };
  model.add_contact(bead, gap, {.e = e, .name = "stop"});
  perp::State x = model.rest();
  model.set_coordinates(x, bead, perp::Vector::Constant(1, start), perp::Vector::Zero(1));

  // the stop takes 1 - e^2 of the kinetic energy that the bead has there
  const double exact = m * g / 2 * (stop * stop + e * e * (start * start - stop * stop));
  bool fine = true;
  for (const char* name : {"lcp", "ncp", "ncp2", "event"}) {
    const auto stepper = perp::make_stepper(name, {.tolerance = 1e-11});
    if (name == std::string("event") && !perp::has_sundials()) continue;
    const perp::Trajectory run = perp::simulate(model, *stepper, x, {.t_end = 1.5, .h = 1e-4});
    const double energy = model.energy(run.back());
    std::printf("%-5s energy after the stop %.9f J, exact %.9f J\n", name, energy, exact);
    fine = fine && std::abs(energy - exact) < (name == std::string("event") ? 1e-9 : 1e-2);
  }
  return fine ? 0 : 1;
}
