// Studies of many scenes, methods and steps: interrupted and taken up again, shared out and put together.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "perp/study/convergence.hpp"

namespace perp {

/// What is to be run: every scene by every method (with every number of edges where it has a polygon) at every step.
struct StudyRequest {
  std::vector<std::string> scenes;   ///< built-in names or files
  std::vector<std::string> methods;  ///< names
  std::vector<std::string> steps =
      {};                        ///< each h in seconds, or T/N for N steps; empty: T/20, T/40, ..., T/2560
  double until = not_set;        ///< T [s]; each scene's own if not set
  SceneParameters set = {};      ///< parameters, in every scene
  std::vector<int> orders = {};  ///< of `extrapolated`, with `steps`; none: by `tolerances`
  std::vector<int> edges = {8};
  std::vector<double> tolerances = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};  ///< of methods that choose their steps
  int envelope = 1;
  VelocityMeasure velocity = VelocityMeasure::AtEnd;
  ReferenceChoice reference = ReferenceChoice::Automatic;
  bool over_run = false;            ///< error_path and error_p too
  SceneParameters set_method = {};  ///< settings of penalty (MethodOptions::set)
};

/// The measure called end, l1 or graph. Throws std::invalid_argument for another name.
[[nodiscard]] VelocityMeasure velocity_measure(std::string_view name);

struct StudyProgress {
  int done = 0, planned = 0;  ///< runs
  std::string next;           ///< scene, method and steps of the run that begins
};

struct StudyOptions {
  double budget = infinity;  ///< wall-clock seconds; a run that is not expected to end within it is not begun
  int jobs = 1;              ///< threads at most
  int shard = 1, shards = 1;  ///< takes the runs of part `shard` of `shards`
  TimingOptions timing = {};
  std::function<void(const StudyProgress&)> progress =
      {};  ///< called before every run, by one thread at a time
};

struct StudyOutcome {
  std::vector<ConvergenceTable> tables;        ///< one a scene, of the runs that are there; none of a shard
  int planned = 0;                             ///< runs of this shard
  int before = 0;                              ///< of these, found in the folder
  int made = 0;                                ///< of these, made now
  std::string no_pictures = {};                ///< why charts were not drawn, or empty
  int failed = 0;                              ///< of those there: runs in which a step failed
  std::vector<std::string> no_reference = {};  ///< scenes without one that asked for it, and why

  int threads = 1;  ///< that ran: fewer than jobs where there was less to do, or the system gave no more

  int left() const { return planned - before - made; }
};

/// Runs what `folder` does not have yet, coarse steps first, and writes there study.csv, orders.csv, for each scene the charts
/// SCENE-convergence and SCENE-work (.svg, .csv, .gnuplot), and the page study.html that holds all of it.
/// Every run is on the disk (runs.journal) before its thread begins another, so a study that was killed has lost the runs in
/// progress at most, and goes on where it stopped; its tables are then those of one that was left alone, but for seconds.
/// A shard writes its runs alone: merge_studies makes the tables.
/// Throws std::invalid_argument for what it cannot run; a step that fails is a row of the tables.
[[nodiscard]] StudyOutcome run_study(const StudyRequest& request, const std::filesystem::path& folder,
                                     const StudyOptions& options = {});

/// Puts the runs of several folders, shards of one study, together into `folder`, with the files of run_study.
/// Throws std::invalid_argument if a folder holds no study, or another one than the first.
[[nodiscard]] StudyOutcome merge_studies(const std::vector<std::filesystem::path>& folders,
                                         const std::filesystem::path& folder);

}  // namespace perp
