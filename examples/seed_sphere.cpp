// The seed's example [T03, Sec. 4]: a sphere thrown along a plane slides until its spin has caught up, then
// rolls. Prints each step beside the exact motion and writes the data of the paper's Figures 8 and 9 into a folder
// (`out`, or the one named); examples/seed_sphere.gnuplot draws them.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <perp/perp.hpp>

namespace {

const double m = 1, R = 1, mu = 0.2, g = 9.81, v0 = 2;      // kg, m, -, m/s^2, m/s
const double t_roll = 2 * v0 / (7 * mu * g);                // s, the sliding ends (50)
const double t_end = 0.6;                                   // s
const double x_end = 5 * v0 / 7 * t_end + v0 * t_roll / 7;  // m, exact x(t_end)

double exact_vx(double t) { return t < t_roll ? v0 - mu * g * t : 5 * v0 / 7; }
double exact_wy(double t) { return t < t_roll ? 5 * mu * g * t / (2 * R) : 5 * v0 / (7 * R); }

struct Sphere {
  perp::Model model;
  perp::BodyId ball = model.add_body(perp::Inertia::solid_sphere(m, R));
  perp::State x;

  Sphere() {
    model.add_contact(perp::ground, ball, perp::sphere_on_plane(R), {.mu = mu, .name = "floor"});
    x = model.rest();
    model.set_position(x, ball, {0, 0, R});
    model.set_velocity(x, ball, {v0, 0, 0});
  }
};

/// Five steps of h = .12: velocities at their ends for Figure 8, the force during each for Figure 9.
void figures(const std::filesystem::path& folder) {
  const double h = 0.12;
  const perp::Vector3 t = perp::Vector3(1, 1, 0).normalized(), o = perp::Vector3(-1, 1, 0).normalized();
  Sphere sphere;
  perp::State x = sphere.x;
  perp::LcpStepper stepper({.edges = 4});  // friction along +x, +y, -x, -y: exact here, as it slides along x
  perp::CsvFile velocities(folder / "figure8.csv", {"t", "vx", "vy", "vz", "wx", "wy", "wz"});
  perp::CsvFile forces(folder / "figure9.csv", {"t", "ct", "co", "cn"});
  const auto write_velocity = [&](double time) {
    const perp::Vector3 v = sphere.model.velocity(x, sphere.ball),
                        w = sphere.model.angular_velocity(x, sphere.ball);
    velocities.cell(time);
    for (const double value : {v.x(), v.y(), v.z(), w.x(), w.y(), w.z()}) velocities.cell(value);
    velocities.end_row();
  };

  std::printf("h = %g s  %18s %10s %18s %10s %9s %9s %6s\n", h, "v_x [m/s]", "exact", "w_y [rad/s]", "exact",
              "c_t [N]", "c_o [N]", "c_n [N]");
  write_velocity(0);
  for (int k = 1; k <= 5; ++k) {
    const perp::StepReport report = stepper.step(sphere.model, x, h);
    if (!report.advanced()) throw std::runtime_error(report.message);
    const perp::Vector3 c = report.contact("floor").impulse / h;  // force on the sphere over the step [N]
    const double time = k * h, vx = sphere.model.velocity(x, sphere.ball).x();
    const double wy = sphere.model.angular_velocity(x, sphere.ball).y();
    std::printf("t = %.2f s %18.15f %10.6f %18.15f %10.6f %9.5f %9.5f %6.3f\n", time, vx, exact_vx(time), wy,
                exact_wy(time), c.dot(t), c.dot(o), c.z());
    write_velocity(time);
    for (const double end : {time - h, time}) {
      forces.cell(end).cell(c.dot(t)).cell(c.dot(o)).cell(c.z()).end_row();
    }
  }
  velocities.finish();
  forces.finish();
}

/// The exact motion beside them, at its corners.
void exact_figures(const std::filesystem::path& folder) {
  perp::CsvFile velocities(folder / "figure8_exact.csv", {"t", "vx", "vy", "vz", "wx", "wy", "wz"});
  for (const double t : {0.0, t_roll, t_end}) {
    velocities.cell(t).cell(exact_vx(t)).cell(0).cell(0).cell(0).cell(exact_wy(t)).cell(0).end_row();
  }
  velocities.finish();
  perp::CsvFile forces(folder / "figure9_exact.csv", {"t", "ct", "co", "cn"});
  const double c = mu * m * g / std::sqrt(2.0);
  forces.cell(0).cell(-c).cell(c).cell(m * g).end_row();
  forces.cell(t_roll).cell(-c).cell(c).cell(m * g).end_row();
  forces.cell(t_roll).cell(0).cell(0).cell(m * g).end_row();
  forces.cell(t_end).cell(0).cell(0).cell(m * g).end_row();
  forces.finish();
}

/// Velocities match the exact ones; positions converge to order 1.
void convergence() {
  std::printf("\nx(%.1f), exact %.15f m\n%10s %20s %12s\n", t_end, x_end, "h [s]", "x [m]", "error [m]");
  for (const double h : {0.12, 0.06, 0.03, 0.01, 0.001}) {
    const Sphere sphere;
    perp::LcpStepper stepper({.edges = 4});
    const perp::Trajectory run = perp::simulate(sphere.model, stepper, sphere.x, {.t_end = t_end, .h = h});
    const double x = sphere.model.position(run.back(), sphere.ball).x();
    std::printf("%10g %20.15f %12.2e\n", h, x, x - x_end);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const std::filesystem::path folder = argc > 1 ? argv[1] : "out";
  figures(folder);
  exact_figures(folder);
  convergence();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "seed_sphere: %s\n", error.what());
  return 1;
}
