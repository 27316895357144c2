// Accuracy against cost: which method reaches which error in which CPU time.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "perp/study/convergence.hpp"

namespace perp {

/// One method's errors over what they cost, in the order of the study's steps. A level of several runs (an envelope) is one
/// point: their largest error, their mean CPU time. Levels with a run that failed are left out.
struct WorkLine {
  std::string method, parameter;
  std::vector<double> seconds;  ///< CPU time of one run [s]
  std::vector<double> error;    ///< in configuration at T, against the study's reference

  std::string label() const { return parameter.empty() ? method : method + ", " + parameter; }
  /// The least error reached in at most `budget` CPU seconds; infinity if no run is as quick.
  double error_within(double budget) const;
};

/// The lines of all methods of a study.
[[nodiscard]] std::vector<WorkLine> work_lines(const ConvergenceTable& table);

/// A convergence study whose CPU times are measured: the best of repeated runs.
struct WorkPrecision {
  ConvergenceStudy study;
  TimingOptions timing = {};

  [[nodiscard]] std::vector<WorkLine> run(const std::vector<Stepper*>& methods) const;
};

}  // namespace perp
