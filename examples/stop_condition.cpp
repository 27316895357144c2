// A run that ends where something happens: a ball is dropped, and the run stops in the step in which it first rises again.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const double height = 1.25, e = 0.8, g = 9.81;  // m of fall, -, m/s^2
  perp::Model model;
  const perp::BodyId ball = model.add_body(perp::Inertia::solid_sphere(1, 0.1));
  model.add_contact(perp::ground, ball, perp::sphere_on_plane(0.1), {.e = e, .name = "floor"});
  perp::State x = model.rest();
  model.set_position(x, ball, {0, 0, 0.1 + height});

  // a sink sees every state; progress, called after it, ends the run by returning false
  struct Watch : perp::RunSink {
    const perp::Model& model;
    perp::BodyId ball;
    double speed = 0;
    Watch(const perp::Model& m, perp::BodyId b) : model(m), ball(b) {}
    void step(const perp::State& now, const perp::StepReport&) override {
      speed = model.velocity(now, ball).z();
    }
  } watch(model, ball);
  perp::NcpStepper stepper;
  const double h = 1e-4;
  const perp::RunEnd end = perp::simulate(
      model, stepper, x, {.t_end = 5, .h = h, .progress = [&](double) { return watch.speed <= 0; }}, watch);
  const double exact = std::sqrt(2 * height / g);
  std::printf("it rises from t = %.4f s, exact %.4f s, at %.4f m/s, exact %.4f m/s\n", end.x.t, exact,
              watch.speed, e * g * exact);
  return std::abs(end.x.t - exact) <= 2 * h && std::abs(watch.speed - e * g * exact) < 20 * h ? 0 : 1;
}
