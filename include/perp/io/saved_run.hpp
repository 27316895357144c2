// A run that is in a folder, read back: its rows, and the states between them.
#pragma once

#include <filesystem>
#include <string>

#include "perp/step/trajectory.hpp"
#include "perp/study/scene.hpp"

namespace perp {

struct SavedRun {
  Scene scene;         ///< of run.json
  std::string method;  ///< as in `perp methods`
  bool complete = false;
  std::string ended;  ///< why it ended, as run.json says it
  /// States of trajectory.csv (q to the bit, angular velocities of spatial bodies to rounding), the figures of report.csv, events of
  /// events.csv; no rows of contacts and joints. at() is that of the run itself; where --every left rows out, the cubics
  /// of fixed steps reach over what is between those that there are.
  Trajectory run;
};

/// Reads what `perp run` left in `folder`, of either format. Throws std::invalid_argument naming file, line and column for what is no
/// such folder, for a table that is not that of the scene, rows whose time goes back, and numbers that are none.
[[nodiscard]] SavedRun read_saved_run(const std::filesystem::path& folder);

}  // namespace perp
