// Measured motions made by a run: sampled at a rate, by a clock of its own, with noise.
#pragma once

#include <random>

#include "model/motion_columns.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/fit.hpp"

namespace perp {

struct Camera {
  double rate = 148;    ///< rows a second
  double offset = 0;    ///< model time of the first row, which the camera calls 0 [s]
  double noise = 0.01;  ///< standard deviation, of each column's range
  unsigned seed = 1;
};

/// The scene's motion from `start` to t_end by `event`, as a camera would have it: the columns that end in one of `parts`.
inline MeasuredMotion measured(const Scene& scene, const State& start, double t_end, const Camera& camera,
                               const std::vector<std::string>& parts) {
  EventDriven event({.rtol = 1e-9});
  const Trajectory run = simulate(scene.model, event, start, {.t_end = t_end, .events = scene.events});
  const std::vector<std::string> names = motion_columns(scene.model);
  MeasuredMotion motion{.name = "made-" + std::to_string(camera.seed)};
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const std::string& part : parts)
      if (names[i].ends_with("." + part)) places.push_back(i), motion.columns.push_back(names[i]);
  const int rows = static_cast<int>((t_end - start.t - camera.offset) * camera.rate) + 1;
  motion.values.resize(rows, static_cast<Eigen::Index>(places.size()));
  std::vector<double> row;
  for (int k = 0; k < rows; ++k) {
    motion.t.push_back(k / camera.rate);
    motion_row(scene.model, run.at(start.t + camera.offset + k / camera.rate), row);
    for (std::size_t c = 0; c < places.size(); ++c)
      motion.values(k, static_cast<Eigen::Index>(c)) = row[places[c]];
  }
  std::mt19937 random(camera.seed);
  std::normal_distribution<double> normal;
  const Vector range = (motion.values.colwise().maxCoeff() - motion.values.colwise().minCoeff()).transpose();
  for (Eigen::Index k = 0; k < rows; ++k)
    for (Eigen::Index c = 0; c < range.size(); ++c)
      motion.values(k, c) += camera.noise * range[c] * normal(random);
  return motion;
}

inline const FittedValue& value_of(const FitResult& result, const std::string& name) {
  for (const FittedValue& v : result.values)
    if (v.name == name) return v;
  throw std::invalid_argument("no value " + name);
}

}  // namespace perp
