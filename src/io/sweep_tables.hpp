// A sweep's tables and picture.
#pragma once

#include "io/sweep_journal.hpp"
#include "perp/io/sweep.hpp"

namespace perp {

/// Of the runs that are there. Returns why there is no picture, or an empty text.
[[nodiscard]] std::string write_sweep(const SweepRequest& request, const SweepJournal::Contents& runs,
                                      const std::filesystem::path& folder);

}  // namespace perp
