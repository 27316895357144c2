// The folder of a run: one run at a time, rows as they come, and what it takes to go on after an interruption.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>

#include "core/files.hpp"
#include "io/run_recipe.hpp"
#include "perp/io/run_files.hpp"

namespace perp {

/// What the user looks at first: how far a run came, how well its steps' equations hold.
struct RunSummary {
  std::size_t steps = 0, events = 0;
  double residual = 0;        ///< largest of contacts [m/s]
  double gap_min = infinity;  ///< [m]
  double joint_error = 0;     ///< [m, rad]

  void add(const StepFigures& step);
};

/// Steps that one stepper takes: implicit methods remember the last step's impulses, so a run depends on its state alone only where a
/// new stepper begins. A cold start costs an iteration or two.
inline constexpr std::size_t steps_a_stepper = 256;

/// Where a run can go on: a state that alone decides what follows, and where the rows up to it end.
struct RunRestart {
  RunSummary so_far;  ///< steps counted from the start
  State x;
  RunPositions positions;  ///< empty: from the start
};

/// Besides the tables of RunFiles it has run.json, which says what is run and how it ended; run.restart, which says where it can go on;
/// and run.lock, which keeps a second run out.
///
/// run.restart is written anew at multiples of steps_a_stepper, where a run goes on with a new stepper, at most twice a second: from
/// there a run goes on to the bytes of the run that was left alone.
class RunFolder final : public RunSink {
 public:
  /// Makes the folder where there is none, and keeps others out. Throws std::invalid_argument if it cannot be written, or if a run
  /// is writing to it.
  explicit RunFolder(const std::filesystem::path& folder);

  /// The run that the folder holds. Throws std::invalid_argument if it holds none.
  [[nodiscard]] static RunRecord record_in(const std::filesystem::path& folder);
  /// Where it can go on. Throws std::invalid_argument if what it was made of is no longer the same.
  [[nodiscard]] static RunRestart restart_in(const std::filesystem::path& folder, const RunRecord& record,
                                             const Model& model);

  /// Rows of a run from `start`, or of one that is taken up again, by a method as `stepper`; `events`: the scene has some.
  void begin(const RunRecord& record, const Model& model, const State& start, const Stepper& stepper,
             const std::optional<RunRestart>& restart, bool events = false,
             const std::function<double(const State&)>& error_estimate = {});
  void step(const State& x, const StepReport& report) override;
  void event(const Event& event) override;
  /// The rows are whole, and run.json says how it ended; `complete`: nothing is left to be done.
  void end(int exit_status, const std::string& how, const StepReport* failed, bool complete);

  const RunSummary& summary() const { return summary_; }
  double t() const { return t_; }  ///< of the last row [s]

 private:
  void write_restart(const State& x);

  std::filesystem::path folder_;
  OutputFile lock_;
  RunRecord record_;
  std::optional<RunFiles> files_;
  RunSummary summary_;
  double t_ = 0;
  bool restarts_ = true;  ///< whether the method can go on from a state alone
  std::chrono::steady_clock::time_point written_;
};

/// Now, as 2026-01-31T12:00:00Z.
[[nodiscard]] std::string utc_now();

}  // namespace perp
