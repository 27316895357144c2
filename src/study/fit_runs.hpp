// The scene run under given unknowns and compared with what was measured, cell by cell.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "perp/step/trajectory.hpp"
#include "study/fit_unknowns.hpp"

namespace perp {

/// One measured number.
struct MeasuredCell {
  int row = 0;     ///< of the motion
  int place = 0;   ///< in motion_row of the model
  int column = 0;  ///< among FitRuns::columns()
  double value = 0;
};

/// Residuals of one motion, in the columns' units: model - measured, in the order of its cells.
struct Residual {
  Vector raw;
  bool failed = false;  ///< a penalty stands where the run did not come to
};

/// The state as the data's frame has it, in the order of motion_columns.
void recorded_row(const Model& model, const Recording& recording, const State& x, std::vector<double>& row);

class FitRuns {
 public:
  /// Throws std::invalid_argument for a column that the scene's model does not have.
  FitRuns(const FitProblem& problem, const std::vector<MeasuredMotion>& motions, const Scene& scene);

  int motions() const { return static_cast<int>(motions_.size()); }
  const MeasuredMotion& motion(int i) const { return motions_[static_cast<std::size_t>(i)]; }
  const std::vector<MeasuredCell>& cells(int motion) const {
    return cells_[static_cast<std::size_t>(motion)];
  }
  const std::vector<std::string>& columns() const { return columns_; }
  double spread(int column) const { return spread_[static_cast<std::size_t>(column)]; }
  double h() const { return h_; }

  /// Cells of the motion's first rows count alone: as many.
  void limit(int motion, int rows) { rows_[static_cast<std::size_t>(motion)] = rows; }
  int limit(int motion) const { return rows_[static_cast<std::size_t>(motion)]; }

  /// The scene of some unknowns; nothing where it refuses them.
  std::optional<Scene> scene(const Unknowns& unknowns, const Vector& theta) const;
  Residual residual(const Unknowns& unknowns, const Vector& theta, const std::optional<Scene>& scene,
                    int motion);
  /// d(residual)/d(unknown), a column for each of `which`, of a motion whose residual is r: from one run's sensitivities. Nothing where these are not to be
  /// had, or are no guide: under steps of fixed size an impact is late by a part of a step, and slopes are those of a tooth.
  std::optional<Matrix> slopes(const Unknowns& unknowns, const Vector& theta, const std::vector<int>& which,
                               int motion, const Vector& r);
  /// Rows before the model's own motion first closes a contact; 0 if one is closed from the start, all if none ever is.
  int rows_before_contact(const Unknowns& unknowns, const Vector& theta, const Scene& scene, int motion);

  long runs() const { return runs_; }
  long failed() const { return failed_; }

  /// Calls work(0) ... work(n - 1) in the problem's threads.
  void each(int n, const std::function<void(int)>& work) const;

 private:
  /// The run as far as it came; empty if it could not begin.
  std::optional<Trajectory> run(const Scene& scene, const State& start, double t_end);
  void penalise(Residual& residual, int motion, std::size_t from) const;

  const FitProblem& problem_;
  const std::vector<MeasuredMotion>& motions_;
  std::vector<std::vector<MeasuredCell>> cells_;
  std::vector<int> rows_;
  std::vector<char> rough_;  // motions of which slopes() has found that it is no use
  std::vector<std::string> columns_;
  std::vector<double> spread_;
  double h_ = not_set;
  std::atomic<long> runs_ = 0, failed_ = 0;
};

}  // namespace perp
