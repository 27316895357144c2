// How far a computed motion is from another: at one time, and over time across impacts.
#pragma once

#include <functional>
#include <vector>

#include "perp/model/model.hpp"
#include "perp/step/trajectory.hpp"

namespace perp {

/// The largest difference of two configurations of one model: of coordinates of positions [m], of planar angles [rad] (whole
/// turns count), and the angle of the rotation from one orientation to the other [rad]. NaN where one has an entry that is
/// not finite; std::invalid_argument for sizes that are not the model's.
[[nodiscard]] double configuration_error(const Model& model, const State& a, const State& b);

/// The largest difference of the components of linear [m/s] and angular [rad/s] velocities, all in world axes.
[[nodiscard]] double velocity_error(const Model& model, const State& a, const State& b);

/// Velocities of all bodies in world axes: particle v; planar vx, vy, omega; spatial v, w.
[[nodiscard]] Vector world_velocity(const Model& model, const State& x);

/// Velocities over time: piecewise linear, each component for itself. Two points at one time are a jump, and the straight
/// line between them belongs to the graph (the completed graph of a function that jumps).
struct VelocityPath {
  std::vector<double> t;  ///< (n) [s], never falling
  Matrix v;               ///< (components, n) [m/s, rad/s]
};

/// A run, linear between its states.
[[nodiscard]] VelocityPath velocity_path(const Model& model, const Trajectory& run);

/// A motion known at every time, as on [t_begin, t_end]: intervals are halved, `first_intervals` of them at first, until the
/// line between their ends is within `tolerance` of the velocity half-way, relative to the largest velocity. A jump ends as
/// an interval of 1e-13 of the whole.
[[nodiscard]] VelocityPath velocity_path(const Model& model, const std::function<State(double t)>& motion,
                                         double t_begin, double t_end, double tolerance = 1e-8,
                                         int first_intervals = 256);

/// max over components of ∫ |a(t) - b(t)| dt [m, rad]. Of order h where a jump is at a time that is wrong by h. Exact for
/// piecewise linear functions. Throws std::invalid_argument for paths over different times or of different components.
[[nodiscard]] double l1_distance(const VelocityPath& a, const VelocityPath& b);

/// max over components of the Hausdorff distance between the completed graphs {(t, v)}, in the norm max(rate |dt|, |dv|)
/// [m/s, rad/s]: how far the graphs are apart at the most, seen from either, with `rate` [m/s^2] saying what a second
/// counts. To 1e-6 of itself. Throws like l1_distance, and unless rate > 0.
[[nodiscard]] double graph_distance(const VelocityPath& a, const VelocityPath& b, double rate);

}  // namespace perp
