// The page of a run, as `perp view` writes it: for commands that have just made one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace perp {

/// Writes the page that shows the runs in `folders` (the second as a ghost) as `html`, and says so unless quiet. Throws as
/// read_recorded_run and write_whole do.
void write_view(const std::vector<std::string>& folders, const std::filesystem::path& html, bool quiet);

}  // namespace perp
