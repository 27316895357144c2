// A table of a run read back: CSV, or a group of run.h5.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace perp {

/// Columns by their names, all as long as the table has rows; cells of a number NaN where "not set".
struct SavedTable {
  std::string place;  ///< what messages call it
  std::vector<std::string> header;
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, std::vector<std::string>> texts;
  std::size_t rows = 0;

  /// Throws std::invalid_argument naming table and column if there is none of numbers.
  const std::vector<double>& column(const std::string& name) const;
  const std::vector<std::string>& text_column(const std::string& name) const;
  /// Throws with the row (from 1), what stands there, and what was needed.
  [[noreturn]] void refuse_cell(const std::string& name, std::size_t row, const std::string& need) const;
};

/// The table `name` ("trajectory") of the run in `folder`, whichever format it has; `texts`: columns that are no numbers.
[[nodiscard]] SavedTable read_saved_table(const std::filesystem::path& folder, const std::string& name,
                                          const std::vector<std::string>& texts);
/// Whether it is there.
[[nodiscard]] bool has_saved_table(const std::filesystem::path& folder, const std::string& name);

}  // namespace perp
