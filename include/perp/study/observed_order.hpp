// Orders of convergence from errors over a ladder of steps.
#pragma once

#include <string>
#include <vector>

#include "perp/model/model.hpp"

namespace perp {

/// h, h/2, h/4, ...: `count` steps.
[[nodiscard]] std::vector<double> halvings(double h, int count);

/// length/n for n = first, 2 first, 4 first, ...: the ladder that is the same for scenes of different length.
[[nodiscard]] std::vector<double> ladder(double length, int first = 20, int count = 8);

/// What errors over steps say. Where they say nothing `order` is NaN and `note` says why.
struct ObservedOrder {
  double order =
      not_set;     ///< slope of log error over log h, with its sign: a diverging method has a negative one
  int points = 0;  ///< errors that the slope was fitted to
  std::vector<double> local = {};  ///< slopes between neighbours of these, the largest steps first
  double h_least = not_set, h_most = not_set;  ///< the range that was fitted [s]
  double floor = not_set;                      ///< where the errors stall, if they do; same unit as they
  std::string note =
      {};  ///< "stalls at 0.06", "exact to round-off", "2 of 8 without an answer"; empty if there is nothing to say

  bool known() const { return order == order; }
};

struct OrderOptions {
  int least_points = 3;       ///< fewer fit anything
  double least_span = 4;      ///< largest step over smallest, of the points fitted and of a stall
  double stall_range = 1.25;  ///< errors within this factor of each other have stalled
  double bar = 0;             ///< of the reference: errors up to it are not known, and no points
};

/// The least-squares slope of log error over log h over the points above round-off, at any spacing. A point with an error
/// that is NaN (a run that failed) or at most its round_off is left out and the note says so. If the errors of the smallest
/// steps, at least `least_points` that span `least_span`, stay within `stall_range`, the method has stalled: no order.
/// Throws std::invalid_argument for sizes that differ, a step that is not positive, an error that is negative.
[[nodiscard]] ObservedOrder observed_order(const std::vector<double>& h, const std::vector<double>& error,
                                           const std::vector<double>& round_off,
                                           const OrderOptions& options = {});

/// Where a method of order p tends to, from its answers with steps `ratio` h and h (Richardson): the answer at h plus
/// 1/(ratio^p - 1) of the way from the first to the second; orientations go that way about one axis, angular velocities in
/// world axes.
[[nodiscard]] State extrapolated(const Model& model, const State& coarse, const State& fine, double ratio,
                                 double p);

}  // namespace perp
