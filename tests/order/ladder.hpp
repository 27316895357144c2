// Observed orders of convergence: errors over a ladder of steps, and the slope through them.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

namespace perp {

/// Step counts n = first 2^k of a ladder h = T/n, the same for all scenes: seven steps, a factor of 64.
inline std::vector<int> ladder(int first = 20, int levels = 7) {
  std::vector<int> counts;
  for (int k = 0; k < levels; ++k) counts.push_back(first << k);
  return counts;
}

/// The least-squares slope of log(error) over log(1/n), with its sign.
inline double order_of(const std::vector<int>& counts, const std::vector<double>& errors) {
  const auto size = static_cast<double>(counts.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double log_h = -std::log(counts[i]), log_error = std::log(errors[i]);
    x += log_h / size;
    y += log_error / size;
    xx += log_h * log_h / size;
    xy += log_h * log_error / size;
  }
  return (xy - x * y) / (xx - x * x);
}

/// The largest difference between two configurations: of positions and planar angles, and the angle between orientations.
inline double distance(const Model& model, const State& a, const State& b) {
  double largest = 0;
  for (int i = 0; i < static_cast<int>(model.bodies().size()); ++i) {
    const Body& body = model.body({i});
    if (body.nv == 0) continue;
    const int places = body.kind == BodyKind::Generalized ? body.nq : 3;
    largest = std::max(largest, (a.q - b.q).segment(body.q0, places).lpNorm<Eigen::Infinity>());
    if (body.kind == BodyKind::Spatial)
      largest =
          std::max(largest, rotation_vector(model.pose(a, {i}).q.conjugate() * model.pose(b, {i}).q).norm());
  }
  return largest;
}

/// The state at T after n steps.
inline State run(const Scene& scene, Stepper& stepper, double T, int n) {
  return simulate(scene.model, stepper, scene.start, {.t_end = T, .h = T / n}).back();
}

/// Errors against `reference` of the configuration at T, over a ladder.
inline std::vector<double> errors(const Scene& scene, Stepper& stepper, double T, const State& reference,
                                  const std::vector<int>& counts) {
  std::vector<double> list;
  for (const int n : counts) list.push_back(distance(scene.model, run(scene, stepper, T, n), reference));
  return list;
}

}  // namespace perp
