// A run's state at any time, and what happens between two of its states.
#pragma once

#include <vector>

#include "perp/step/trajectory.hpp"

namespace perp {

/// The state at t between a and b: cubics through both configurations with their rates q' = G(q) nu, quaternions by their components and
/// then of unit length, velocities the rates of these. Where the motion is smooth the error is of order 4 in the time from a to b for
/// q and of order 3 for nu.
[[nodiscard]] State between_states(const Model& model, const State& a, const State& b, double t);

/// A user's event between two states.
struct FoundEvent {
  double t = 0;
  std::size_t index = 0;  ///< in the list of events
};

/// Where events between a and b have their zeros, in order of time: by looking at between_states eight times, then by halving.
[[nodiscard]] std::vector<FoundEvent> find_events(const Model& model, const std::vector<UserEvent>& events,
                                                  const State& a, const State& b);

}  // namespace perp
