// Events of one's own: a clock. Whenever its damped balance swings up through the middle it gets a kick, and the run ends at the
// sixtieth.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <perp/perp.hpp>

int main() {
  const double stiffness = 4, damping = 0.2, kick = 0.1;  // N/m, N s/m, m/s; 1 kg
  perp::Model model;
  model.set_gravity({0, 0, 0});
  const perp::BodyId balance = model.add_particle(1);
  model.add_force(balance, [=](const perp::Model& m, const perp::State& x) {
    const perp::Vector3 f = -stiffness * m.position(x, balance) - damping * m.velocity(x, balance);
    return perp::Wrench{f, perp::Vector3::Zero()};
  });
  perp::State x = model.rest();
  model.set_position(x, balance, {0.05, 0, 0});

  int kicks = 0;
  const perp::UserEvent middle{
      .name = "middle",
      .when = [=](const perp::Model& m, const perp::State& s) { return m.position(s, balance).x(); },
      .direction = 1,
      .then =
          [&kicks, kick](const perp::Model&, perp::State& s) {
            if (++kicks == 60) return perp::AfterEvent::Stop;
            s.nu[0] += kick;
            return perp::AfterEvent::GoOn;
          }};

  // between kicks the speed falls by exp(-damping T/2), so that in the long run v = (v + kick) exp(-damping T/2)
  const double period = 2 * std::numbers::pi / std::sqrt(stiffness - damping * damping / 4);
  const double decay = std::exp(-damping * period / 2), exact = kick * decay / (1 - decay);
  double worst = 0;
  const auto report = [&](const char* name, const perp::Trajectory& run) {
    const double v = run.back().nu[0], t = run.back().t;
    const double turn = run.at(t - period / 4).nu[0];  // near where it turns, between two rows
    std::printf("%s: kick %d at t = %.6f s with %.8f m/s, exact %.8f m/s; a quarter before %.4f m/s\n", name,
                kicks, t, v, exact, turn);
    worst = std::max(worst, std::abs(v - exact));
    kicks = 0;
  };
  perp::Ncp2Stepper fixed;
  report("ncp2", perp::simulate(model, fixed, x, {.t_end = 300, .h = 2e-3, .events = {middle}}));
  perp::EventDriven events({.rtol = 1e-11});
  if (perp::has_sundials())
    report("event", perp::simulate(model, events, x, {.t_end = 300, .events = {middle}}));
  return worst < 1e-6 ? 0 : 1;
}
