// Tables of other programs, read row by row: CSV with a header line, as CsvFile writes them.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace perp {

/// A CSV file read from its beginning to its end: `next` gives a row after the other. Cells in quotes may hold commas, quotes
/// (doubled) and line breaks; lines end in LF or CR LF. Nothing is kept but the row in hand, so a file may be larger than memory.
/// Throws std::invalid_argument with "FILE:LINE: ..." for a file that can't be opened or is empty, a name that stands twice in
/// the header, a row with more or fewer cells than the header has names, and quotes that are not closed.
class CsvReader {
 public:
  explicit CsvReader(const std::filesystem::path& path);

  const std::vector<std::string>& header() const { return header_; }
  /// The column of that name; -1 if there is none.
  int find(std::string_view name) const;
  /// The same; throws std::invalid_argument naming file and column if there is none.
  int need(std::string_view name) const;

  /// Goes to the next row; false at the end of the file.
  bool next();
  std::string_view text(int column) const { return cells_[static_cast<std::size_t>(column)]; }
  /// The cell as a number, the whole of it; NaN for an empty cell. Throws std::invalid_argument "FILE:LINE:COLUMN: ...".
  double number(int column) const;
  int line() const { return line_of_row_; }

  [[noreturn]] void refuse_cell(int column, std::string_view need) const;

 private:
  bool read_row();
  [[noreturn]] void refuse_row(const std::string& what) const;

  std::string name_;
  std::ifstream file_;
  std::vector<std::string> header_, cells_;
  std::vector<int> begins_;  // of each cell of the row, in its line
  std::size_t used_ = 0;     // cells of cells_ in this row
  int line_ = 0, line_of_row_ = 0;
  std::string text_;
};

}  // namespace perp
