// Sweeps: one scene over values of its parameters, on grids or drawn at random, and what comes out of each run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "perp/io/study_folder.hpp"

namespace perp {

/// A parameter and its values: n of them from low to high, equally spaced; or, of a drawn one, uniform in [low, high).
struct SweepAxis {
  std::string name;
  double low = 0, high = 0;
  int n = 1;           ///< of a grid
  bool drawn = false;  ///< else on the grid
};

/// All combinations of the grids' values, each `draws` times with what is drawn.
struct SweepRequest {
  std::string scene;                 ///< a built-in name or a file
  std::vector<std::string> methods;  ///< names
  std::string step = {};             ///< h in seconds, or T/N; of methods that need one
  double tolerance = 1e-8;           ///< of methods that choose their steps
  double until = not_set;            ///< T [s]; the scene's own if not set
  int edges = 8;                     ///< of methods with a friction polygon
  SceneParameters set = {};          ///< parameters that stay
  std::vector<SweepAxis> axes;
  int draws = 1;
  unsigned long long seed = 1;  ///< of what is drawn; a run's numbers depend on its place in the sweep alone
  std::vector<std::string> ask = {};  ///< expressions at the end of the run (BODY.x), or time:EVENT
  std::string pass = {};              ///< A > B or A < B, at the end of the run; empty: not asked
};

struct SweepOutcome {
  long planned = 0, before = 0, made = 0;  ///< runs of this shard: all, found in the folder, made now
  long failed = 0, passed = 0;             ///< of those there: a step failed; the answer to `pass` was yes
  std::string no_pictures = {};            ///< why there is no picture, or empty
  long left() const { return planned - before - made; }
};

/// A share with its 95 % interval [Wil27].
struct Share {
  double share = 0, low = 0, high = 1;
};
[[nodiscard]] Share wilson(long passed, long n);

/// Runs what `folder` does not have yet, and writes there
///   sweep.csv   method, a column a parameter, t (the end of the run), a column for each thing asked, pass, failed, message: a row a
///               run, in the order of the grids (the last the fastest), then of draws, then of methods
///   shares.csv  method, the parameters on grids, n, passed, share, low, high: how many of the runs that did not fail passed
///   sweep.svg   what is asked over the first parameter
/// Every run is on the disk (sweep.journal) before its thread begins another: a sweep that was killed goes on where it stopped, to
/// the same bytes. A shard writes its runs alone: merge_sweeps makes the tables. Options as of run_study.
/// Throws std::invalid_argument for what it cannot run; a step that fails is a row.
[[nodiscard]] SweepOutcome run_sweep(const SweepRequest& request, const std::filesystem::path& folder,
                                     const StudyOptions& options = {});

/// Puts shards of one sweep together into `folder`.
[[nodiscard]] SweepOutcome merge_sweeps(const std::vector<std::filesystem::path>& folders,
                                        const std::filesystem::path& folder);

/// Whether the folder is of a sweep, not of a study.
[[nodiscard]] bool is_sweep(const std::filesystem::path& folder);

}  // namespace perp
