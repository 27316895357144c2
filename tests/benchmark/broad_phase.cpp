// What the broad phase costs: spheres heaped in a box, from a hundred to ten thousand, and all pairs beside it.
//   broad_phase
#include <cmath>
#include <cstdio>

#include "perp/model/shapes_in_reach.hpp"
#include "perp/study/scene.hpp"
#include "tests/benchmark/stopwatch.hpp"

namespace {

struct Cost {
  std::size_t candidates = 0;
  double seconds = 0, bytes = 0;
};

Cost found(const perp::Scene& s, const std::vector<perp::Pose>& X) {
  perp::ShapesInReach near;
  Cost cost;
  const auto find = [&] { cost.candidates = near.find(s.model, X, 0.1).size(); };
  cost.seconds = perp::best(1, [&](int) { find(); });
  cost.bytes = static_cast<double>(near.bytes()) / static_cast<double>(s.model.shapes().size());
  return cost;
}

/// Every pair's distance, as without a broad phase.
double all_pairs(const perp::Scene& s, const std::vector<perp::Pose>& X) {
  double least = perp::infinity;
  return perp::best(1, [&](int) {
    s.model.each_contact([&](int number) {
      const perp::ContactView c = s.model.contact(number);
      perp::ContactPoint point;
      c.gap(X[static_cast<std::size_t>(c.a.index)], X[static_cast<std::size_t>(c.b.index)], 0, {&point, 1});
      least = std::min(least, point.gap);
    });
  });
}

}  // namespace

int main() {
  std::printf("%8s %12s %12s %12s %14s\n", "spheres", "candidates", "seconds", "bytes each", "all pairs [s]");
  std::vector<double> logs_n, logs_candidates, logs_seconds;
  for (const int n : {100, 200, 500, 1000, 2000, 5000, 10000}) {
    const perp::Scene s = perp::scene("pile", {{"count", n}});
    std::vector<perp::Pose> X;
    for (int i = 0; i <= n; ++i) X.push_back(s.model.pose(s.start, {i}));
    const Cost cost = found(s, X);
    std::printf("%8d %12zu %12.3e %12.0f", n, cost.candidates, cost.seconds, cost.bytes);
    if (n <= 1000) std::printf(" %14.3e", all_pairs(s, X));
    std::printf("\n");
    logs_n.push_back(std::log(n));
    logs_candidates.push_back(std::log(static_cast<double>(cost.candidates)));
    logs_seconds.push_back(std::log(cost.seconds));
  }
  const auto slope = [&](const std::vector<double>& y) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < y.size(); ++i)
      n += 1, sx += logs_n[i], sy += y[i], sxx += logs_n[i] * logs_n[i], sxy += logs_n[i] * y[i];
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
  };
  std::printf("candidates grow as N^%.3f, time as N^%.3f\n", slope(logs_candidates), slope(logs_seconds));
}
