// The states between two rows of a run.
#pragma once

#include <functional>

#include "perp/step/trajectory.hpp"

namespace perp {

/// The state at t between a and b: cubics through both configurations with their rates q' = G(q) nu, quaternions by their components and
/// then of unit length; velocities are the rates of these. Through states of one smooth motion the error is of order 4 in the
/// time from a to b for q, and of order 3 for nu.
[[nodiscard]] State between_states(const Model& model, const State& a, const State& b, double t);

/// Trajectory::between of rows that these cubics go through.
[[nodiscard]] std::function<State(const Trajectory&, std::size_t, double)> cubics(const Model& model);

}  // namespace perp
