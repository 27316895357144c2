// A step or a tolerance for an accuracy that is asked for, and how far each row of the run is from the motion.
#pragma once

#include <string>
#include <string_view>

#include "perp/step/methods.hpp"
#include "perp/step/trajectory.hpp"

namespace perp {

struct AccuracyRequest {
  std::string_view method;
  MethodOptions options = {};  ///< tolerance and edges are where the search begins, or beyond
  double accuracy = 1e-6;      ///< > 0: of the configuration at every row, absolute [m, rad]
  double t_end = not_set;
  double most_steps = 1e6;  ///< of a trial
};

/// What a run needs to be as accurate as was asked, found by trials: of each a run and a finer one of the same kind, the reference (a
/// hundredth of the tolerance, a quarter of the step; of polygonal methods by `ncp`, since halving h is blind to the polygon), whose
/// distance is the error but for a few per cent.
struct AccuracyChoice {
  MethodOptions options;   ///< with the tolerance, or the edges
  double h = not_set;      ///< of methods of fixed steps [s]
  double error = not_set;  ///< the largest of the trial's rows [m, rad]
  bool reached = false;    ///< whether that is at most the accuracy
  std::string why;         ///< if not
  Trajectory reference;

  /// Largest difference of positions and angles between x and the reference at its time [m, rad].
  double estimate(const Model& model, const State& x) const;
};

/// Throws std::invalid_argument for a method that is none, an accuracy that is not positive, and what simulate() refuses.
[[nodiscard]] AccuracyChoice choose_for_accuracy(const Model& model, const State& start,
                                                 const AccuracyRequest& request);

}  // namespace perp
