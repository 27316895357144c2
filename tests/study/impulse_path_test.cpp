// Errors over a whole run: of configurations, and of accumulated impulses.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/step/lcp_stepper.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/convergence.hpp"

namespace perp {

TEST_CASE("accumulated impulses of the seed's sphere are its weight and its friction over time",
          "[impulses]") {
  if (!has_sundials()) return;
  const Scene s = scene("seed-sphere");
  const std::optional<ImpulsePath> found = reference_impulses(s, 0.6, 0.01);
  REQUIRE(found);
  const double t_star = 2 * 2 / (7 * 0.2 * 9.81);
  for (std::size_t i = 0; i < found->t.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double t = found->t[i], friction = -0.2 * 9.81 * std::min(t, t_star);
    CHECK(found->forces(2, k) == Approx(9.81 * t).margin(1e-9));
    CHECK(found->forces(0, k) == Approx(friction).margin(2e-3));
    CHECK(std::abs(found->forces(1, k)) < 1e-12);
  }
  LcpStepper lcp;
  const double h = 0.6 / 7;
  const ImpulsePath run = impulse_path(s.model, simulate(s.model, lcp, s.start, {.t_end = 0.6, .h = h}));
  double largest = 0;  // of friction, in the step in which rolling begins; the weight is exact
  for (std::size_t i = 0; i < run.t.size(); ++i)
    largest = std::max(largest, std::abs(run.forces(0, static_cast<Eigen::Index>(i)) +
                                         0.2 * 9.81 * std::min(run.t[i], t_star)));
  CHECK(impulse_error(run, *found, 1e6) == Approx(largest).margin(2e-3));
}

TEST_CASE("errors of impulses and of paths fall at the methods' orders", "[impulses]") {
  if (!has_sundials()) return;
  const auto lcp = make_stepper("lcp"), ncp = make_stepper("ncp"), ncp2 = make_stepper("ncp2");
  const ConvergenceStudy study{
      .scene = scene("double-pendulum"), .steps = ladder(1, 40, 6), .over_run = true};
  const ConvergenceTable table = study.run({lcp.get(), ncp2.get(), ncp.get()});
  REQUIRE(table.orders.size() == 3);
  CHECK(table.orders[0].path.order == Approx(1).margin(0.15));
  CHECK(table.orders[1].path.order == Approx(2).margin(0.15));
  CHECK(table.orders[0].p.order == Approx(2).margin(0.15));  // as its velocities: they are half a step ahead
  CHECK(table.orders[2].p.order == Approx(1).margin(0.15));
  CHECK(table.orders[2].path.order == Approx(1).margin(0.15));
  CHECK(table.orders[1].p.order == Approx(2).margin(0.15));
  for (const StudyRun& run : table.runs) {
    CHECK(run.error_path >= run.error_q);
    CHECK(run.error_p > 0);
  }
}

}  // namespace perp
