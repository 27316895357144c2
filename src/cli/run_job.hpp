// One run into its folder, begun or taken up again: what is shown while it goes on, what ends it, what is said at the end.
#pragma once

#include <filesystem>

#include "io/run_folder.hpp"

namespace perp {

struct RunManner {
  double budget = infinity;  ///< wall-clock seconds, after which it ends
  bool quiet = false;        ///< nothing but errors
  bool verbose = false;      ///< a line a step: what the solver did
  bool view = false;         ///< the page of the run when it ends, however: OUT/view.html
};

/// Begins the run of `record` in `folder`, or takes it up at `restart`; `scene` is the recipe's. Returns the exit status; throws as the
/// library does, what was written then being whole rows.
[[nodiscard]] int run_into(const std::filesystem::path& folder, const RunRecord& record, const Scene& scene,
                           const RunManner& manner, bool resume);

}  // namespace perp
