// Orders of convergence where friction twists and rolls, two-sided, on motions that are known.
#include <catch2/catch.hpp>

#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "tests/order/ladder.hpp"

namespace perp {
namespace {

/// Order at T of the largest error of sixteen runs a level whose steps spread over [n, 1.25 n]: a switch falls at every
/// fraction of a step.
double observed(Stepper& stepper, const Scene& s, double T, int spread = 16) {
  const State exact = s.exact(T);
  const std::vector<int> counts = ladder(80, 5);
  std::vector<double> list;
  for (const int n : counts) {
    double largest = 0;
    for (int i = 0; i < spread; ++i) {
      const int steps = n + (spread > 1 ? static_cast<int>(std::lround(0.25 * n * i / (spread - 1))) : 0);
      largest = std::max(largest, distance(s.model, run(s, stepper, T, steps), exact));
    }
    list.push_back(largest);
  }
  return order_of(counts, list);
}

auto order(double p) { return Approx(p).margin(0.15); }

/// A disc without height that slides along x and spins, gamma² = mu² J/m: v and w keep their ratio, and friction its direction, so
/// that both fall linearly.
Scene sliding_disc() {
  const double mu = 0.3, J = 0.005, gamma = mu * std::sqrt(J), v0 = 1, w0 = 12;
  Scene s;
  const BodyId disc = s.model.add_body(Inertia::principal(1, {J / 2, J / 2, J}), {.name = "disc"});
  s.model.add_contact(ground, disc, point_on_plane(Vector3::Zero()), {.mu = mu, .torsion = gamma});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, disc, {v0, 0, 0}, {0, 0, w0});
  const double size = std::hypot(mu * v0, gamma * w0), rate = 9.81 * mu * mu / size;  // v' = -rate v0
  s.exact = [=](double t) {
    State x = s.model.rest();
    const double end = std::min(t, 1 / rate), way = end - rate * end * end / 2;
    x.t = t;
    s.model.set_position(x, disc, {v0 * way, 0, 0});
    s.model.set_orientation(x, disc, rotation({0, 0, w0 * way}));
    s.model.set_velocity(x, disc, {v0 * (1 - rate * end), 0, 0}, {0, 0, w0 * (1 - rate * end)});
    return x;
  };
  return s;
}

}  // namespace

TEST_CASE("the second-order step has order 2 where friction twists, rolls and brings to rest",
          "[order][moments]") {
  Ncp2Stepper ncp2;
  CHECK(observed(ncp2, scene("spun-sphere"), 0.8) == order(2));
  CHECK(observed(ncp2, scene("coasting-wheel", {{"rolling", 0.02}}), 2) == order(2));
  CHECK(observed(ncp2, scene("coasting-wheel", {{"slope", 0.04}, {"rolling", 0.02}}), 4) == order(2));
  CHECK(observed(ncp2, sliding_disc(), 1) == order(2));
}

TEST_CASE("the fully implicit step has order 1 where friction twists, rolls and brings to rest",
          "[order][moments]") {
  NcpStepper ncp;
  CHECK(observed(ncp, scene("spun-sphere"), 0.8) == order(1));
  CHECK(observed(ncp, scene("spun-sphere"), 0.5, 1) == order(1));
  CHECK(observed(ncp, scene("coasting-wheel", {{"rolling", 0.02}}), 2) == order(1));
  CHECK(observed(ncp, scene("coasting-wheel", {{"slope", 0.1}, {"v0", -1}}), 2) == order(1));
  CHECK(observed(ncp, sliding_disc(), 1) == order(1));
}

TEST_CASE("the LCP step has order 1 where friction twists alone or rolls along a vertex of its polygon",
          "[order][moments]") {
  LcpStepper lcp;
  CHECK(observed(lcp, scene("spun-sphere"), 0.8) == order(1));
  CHECK(observed(lcp, scene("spun-sphere"), 0.5, 1) == order(1));
  CHECK(observed(lcp, scene("coasting-wheel", {{"rolling", 0.02}}), 2) == order(1));
  CHECK(observed(lcp, scene("coasting-wheel", {{"slope", 0.1}, {"v0", -1}}), 2) == order(1));
}

}  // namespace perp
