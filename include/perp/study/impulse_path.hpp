// Impulses accumulated over a run: what a method says of forces, fairly across impacts.
#pragma once

#include <vector>

#include "perp/model/model.hpp"
#include "perp/step/trajectory.hpp"

namespace perp {

/// P(t) = the sum of all impulses from the start to t: of each contact the force and its moment about the world's origin, summed over the points
/// of a patch (which of several reactions a method reports does not show in them); of each joint the same of its equations, and its
/// dry friction along the freedom. World axes, on b.
struct ImpulsePath {
  std::vector<double> t;  ///< (n) [s], rising; P(t[0]) = 0
  Matrix forces;          ///< (3 contacts + 3 joints, n) [N s]
  Matrix moments;         ///< (3 contacts + 4 joints, n) [N m s]; a joint's last is its friction
};

/// That of a run, at its rows; of two rows at one time (an event) the last.
[[nodiscard]] ImpulsePath impulse_path(const Model& model, const Trajectory& run);

/// The largest difference of any component at any time of `run`, moments over `length` [N s]; `reference` is linear between its times.
/// Throws std::invalid_argument for paths of different contacts or joints.
[[nodiscard]] double impulse_error(const ImpulsePath& run, const ImpulsePath& reference, double length);

}  // namespace perp
