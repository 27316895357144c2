// Runs gnuplot on a script.
#pragma once

#include <filesystem>
#include <string>

namespace perp {

/// In the folder of the script. Returns why there is no picture ("gnuplot is not installed", ...), or an empty text.
[[nodiscard]] std::string run_gnuplot(const std::filesystem::path& folder, const std::string& script);

/// As a gnuplot string in double quotes, its special letters as they are.
[[nodiscard]] std::string in_gnuplot_quotes(const std::string& text);

}  // namespace perp
