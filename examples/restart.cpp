// A run in two pieces: its state is kept at a step, and the second piece goes on to the bits of the run made at once.
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  const perp::Scene scene = perp::scene("oblique-sphere");
  const perp::SimulateOptions whole{.t_end = 1, .h = 1e-3};
  struct Last : perp::RunSink {  // nothing is kept but what RunEnd says
    void step(const perp::State&, const perp::StepReport&) override {}
  } sink;
  const auto piece = [&](const perp::State& from, std::size_t taken, std::size_t most) {
    perp::SimulateOptions options = whole;
    options.t_start = scene.start.t;
    options.taken = taken;
    options.most = most;
    perp::Ncp2Stepper stepper;  // a new one each: implicit methods remember the last step's impulses
    return perp::simulate(scene.model, stepper, from, options, sink);
  };
  perp::State at_once = scene.start;
  for (std::size_t taken = 0; taken < 1000; taken += 250) at_once = piece(at_once, taken, 250).x;
  const perp::State kept =
      piece(piece(scene.start, 0, 250).x, 250, 250).x;  // a value: copy it, write it, send it
  const perp::State resumed = piece(piece(kept, 500, 250).x, 750, 250).x;
  const bool same = resumed.q == at_once.q && resumed.nu == at_once.nu;
  std::printf("t = %g s: the resumed run's bits are %s\n", resumed.t, same ? "the same" : "others");
  return same && resumed.t == 1 ? 0 : 1;
}
