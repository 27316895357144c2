// A run as one HTML page that shows the motion.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "perp/view/recorded_run.hpp"

namespace perp {

struct PageOptions {
  /// Where three.js and its OrbitControls come from; a page written without it shows plots and values alone, and says so.
  std::filesystem::path three = "/usr/share/javascript/three/build/three.min.js";
};

/// What a page holds, in numbers.
struct PageFacts {
  std::size_t bytes = 0, rows = 0, keys = 0;
  double position_error = 0;  ///< of poses between and at the rows, against the rows [m]
  double turning_error = 0;   ///< [rad]
  bool has_three = false;
};

/// The page: no network, no other file. The second run, if there is one, is drawn as a ghost over the first. Motions are thinned to
/// keys with cubic Hermite polynomials between them, so that 60 s of ten bodies stay below 10 MB; the page says how far poses are
/// from the rows at most. Throws std::invalid_argument for no run or more than two.
[[nodiscard]] std::string page_of(const std::vector<RecordedRun>& runs, PageFacts& facts,
                                  const PageOptions& options = {});

}  // namespace perp
