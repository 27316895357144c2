// What a second-order contact step in given modes costs, and how far it is off, by three ways of making it: which one is worth extrapolating.
//   ncp2          the step itself, its modes found by complementarity
//   implicit      the same two stages in given modes: joints and gaps closed at the end of the step by a simplified Newton method
//   half-explicit the midpoint rule whose impulses obey the velocity equations at the end of the substep, one linear solve
//   accelerations the explicit midpoint rule on the right-hand side that `event` integrates
// Microseconds a step, evaluations of the contacts a step, and the error of the configuration at T after N steps.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

#include "instant/scales.hpp"
#include "step/events/mode_dynamics.hpp"
#include "tests/benchmark/stopwatch.hpp"

namespace perp {
namespace {

struct Case {
  const char* name;
  Model model;
  State x;
  double T;
};

Case of_scene(const char* name, double T) {
  Scene s = scene(name);
  return {name, std::move(s.model), s.start, T};
}

/// A box of 0.2 x 0.2 x 0.1 m that slides on its four lower corners.
Case sliding_box() {
  Model model;
  const BodyId box = model.add_body(Inertia::solid_box(1, {0.2, 0.2, 0.1}));
  model.add_contact(ground, box, box_on_plane({0.2, 0.2, 0.1}), {.mu = 0.3});
  State x = model.rest();
  model.set_position(x, box, {0, 0, 0.05});
  model.set_velocity(x, box, {2, 0, 0});
  return {"box on four corners", std::move(model), x, 0.5};
}

struct Count {
  long contacts = 0;
};

Modes modes_at(const Case& c) {
  Instant instant;
  evaluate(c.model, c.x, instant);
  return modes_by_velocity(c.model, c.x, instant, scales_of(c.model, c.x, instant));
}

/// M (nu_½ - nu) = h/2 k + L z_1, psi(q ⊕ h nu_½) = 0; M (nu+ - nu_½) = h/2 k+ + L+ z_2, Rᵀ nu+ = 0.
bool implicit_step(const Model& model, ModeDynamics& d, State& x, double h, Count& count) {
  ModeKick kick;
  Vector z;
  if (!d.rows(x)) return false;
  d.kick(kick);
  State half = x, end = x;
  half.nu += 0.5 * h * kick.free;
  Eigen::PartialPivLU<Matrix> lu;
  for (int iteration = 0; iteration < 30; ++iteration) {
    end = x;
    end.t += h;
    end.nu = half.nu;
    move(model, half.nu, h, end.q);
    ++count.contacts;
    if (!d.rows(end)) return false;
    if (d.row_count() == 0) break;
    if (iteration == 0)
      lu.compute(d.R().transpose() * kick.response + 1e-12 * Matrix::Identity(d.row_count(), d.row_count()));
    Vector off = d.velocity();
    for (const int i : d.position_rows()) off[i] = d.gap()[i] / h;
    if (off.lpNorm<Eigen::Infinity>() < 1e-12) break;
    half.nu -= kick.response * lu.solve(off);
  }
  d.kick(kick);
  end.nu += 0.5 * h * kick.free;
  if (!d.rows(end) || !d.meet(kick, end, z)) return false;
  x = end;
  return true;
}

/// Two substeps of h/2, from q to q+.
bool half_explicit_step(const Model& model, ModeDynamics& d, State& x, double h, Count& count) {
  ModeKick kick;
  Vector z;
  if (!d.rows(x)) return false;
  d.kick(kick);
  State middle = x, end = x;
  middle.t += h / 2;
  move(model, x.nu, h / 2, middle.q);
  middle.nu += h / 2 * kick.free;
  if (!d.rows(middle) || !d.meet(kick, middle, z)) return false;
  d.turn(middle);
  d.kick(kick);
  end.t += h;
  move(model, middle.nu, h, end.q);
  end.nu += h * kick.free;
  if (!d.rows(end) || !d.meet(kick, end, z)) return false;
  count.contacts += 2;
  x = end;
  return true;
}

bool acceleration_step(const Model& model, ModeDynamics& d, State& x, double h, Count& count) {
  if (!d.evaluate(x)) return false;
  State middle = x, end = x;
  middle.t += h / 2;
  move(model, x.nu, h / 2, middle.q);
  middle.nu += h / 2 * d.nu_dot;
  if (!d.evaluate(middle)) return false;
  end.t += h;
  move(model, middle.nu, h, end.q);
  end.nu += h * d.nu_dot;
  count.contacts += 2;
  x = end;
  return true;
}

template <class Step>
void measure(const Case& c, const char* name, const State& exact, Step step) {
  constexpr int N = 40;
  State x = c.x;
  Count count;
  bool fine = true;
  const auto run = [&] {
    x = c.x;
    for (int i = 0; i < N && fine; ++i) fine = step(x, c.T / N, count);
  };
  run();
  const double evaluations = static_cast<double>(count.contacts) / N;
  const double seconds = best(20,
                              [&](int times) {
                                for (int i = 0; i < times; ++i) run();
                              }) /
                         N;
  std::printf("  %-15s %9.2f us %6.1f evaluations   error %9.2e%s\n", name, 1e6 * seconds, evaluations,
              configuration_error(c.model, x, exact), fine ? "" : "  failed");
}

void measure_all(const Case& c) {
  std::printf("%s, T = %g s, 40 steps\n", c.name, c.T);
  EventDriven event({.rtol = 1e-12});
  const State exact = simulate(c.model, event, c.x, {.t_end = c.T}).back();
  Ncp2Stepper ncp2;
  StepReport report;
  measure(c, "ncp2", exact, [&](State& x, double h, Count&) {
    ncp2.step(c.model, x, {.h = h, .keep_energy = false}, report);
    return report.advanced();
  });
  ModeDynamics d(c.model);
  const Modes modes = modes_at(c);
  (void)d.begin(c.x, modes, 1e-9);
  measure(c, "implicit", exact,
          [&](State& x, double h, Count& n) { return implicit_step(c.model, d, x, h, n); });
  measure(c, "half-explicit", exact,
          [&](State& x, double h, Count& n) { return half_explicit_step(c.model, d, x, h, n); });
  measure(c, "accelerations", exact,
          [&](State& x, double h, Count& n) { return acceleration_step(c.model, d, x, h, n); });
}

}  // namespace
}  // namespace perp

int main() {
  for (const perp::Case& c :
       {perp::of_scene("rolling-ellipse", 0.5), perp::of_scene("bowl", 1),
        perp::of_scene("double-pendulum", 1), perp::of_scene("dzhanibekov", 1), perp::sliding_box()})
    perp::measure_all(c);
  return 0;
}
