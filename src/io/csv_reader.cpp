#include "perp/io/csv_reader.hpp"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <set>
#include <stdexcept>

#include "perp/core/errors.hpp"

namespace perp {

CsvReader::CsvReader(const std::filesystem::path& path) : name_(path.string()) {
  errno = 0;
  if (std::filesystem::is_directory(path)) refuse("reading", name_, "a folder", "needs to be a CSV file");
  file_.open(path, std::ios::binary);
  if (!file_) refuse("reading", name_, std::strerror(errno), "needs to be a file that can be read");
  if (!read_row()) throw std::invalid_argument(name_ + ":1: the file is empty, a header line is needed");
  header_.assign(cells_.begin(), cells_.begin() + static_cast<std::ptrdiff_t>(used_));
  std::set<std::string_view> names;
  for (const std::string& column : header_)
    if (!names.insert(column).second) refuse_row("the column '" + column + "' stands twice in the header");
}

int CsvReader::find(std::string_view name) const {
  for (std::size_t i = 0; i < header_.size(); ++i)
    if (header_[i] == name) return static_cast<int>(i);
  return -1;
}

int CsvReader::need(std::string_view name) const {
  const int column = find(name);
  if (column < 0) throw std::invalid_argument(name_ + ":1: there is no column '" + std::string(name) + "'");
  return column;
}

bool CsvReader::next() {
  do {
    if (!read_row()) return false;
  } while (used_ == 1 && cells_[0].empty() && header_.size() > 1);  // an empty line
  if (used_ != header_.size())
    refuse_row("the row has " + std::to_string(used_) + " cells, the header " +
               std::to_string(header_.size()) + " names");
  return true;
}

bool CsvReader::read_row() {
  used_ = 0;
  line_of_row_ = line_ + 1;
  const auto open_cell = [&]() -> std::string& {
    if (used_ == cells_.size()) cells_.emplace_back();
    cells_[used_].clear();
    begins_.resize(used_);
    begins_.push_back(0);
    return cells_[used_++];
  };
  if (!std::getline(file_, text_)) return false;
  ++line_;
  std::string* cell = &open_cell();
  bool quoted = false;
  for (std::size_t i = 0;; ++i) {
    if (i == text_.size()) {
      if (!quoted) break;
      if (!std::getline(file_, text_)) refuse_row("a quoted cell has no end");
      ++line_;
      *cell += '\n';
      i = static_cast<std::size_t>(-1);
      continue;
    }
    const char c = text_[i];
    if (quoted) {
      if (c != '"') {
        *cell += c;
      } else if (i + 1 < text_.size() && text_[i + 1] == '"') {
        *cell += '"';
        ++i;
      } else {
        quoted = false;
      }
    } else if (c == '"' && cell->empty()) {
      quoted = true;
    } else if (c == ',') {
      cell = &open_cell();
      begins_.back() = static_cast<int>(i) + 1;
    } else if (!(c == '\r' && i + 1 == text_.size())) {
      *cell += c;
    }
  }
  return true;
}

double CsvReader::number(int column) const {
  const std::string_view cell = text(column);
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0;
  const char* end = cell.data() + cell.size();
  const auto [stopped, error] = std::from_chars(cell.data() + (cell[0] == '+' ? 1 : 0), end, value);
  if (error != std::errc() || stopped != end) refuse_cell(column, "a number is needed");
  return value;
}

void CsvReader::refuse_cell(int column, std::string_view need) const {
  const auto at = static_cast<std::size_t>(column);
  throw std::invalid_argument(name_ + ":" + std::to_string(line_of_row_) + ":" +
                              std::to_string(begins_[at] + 1) + ": column '" + header_[at] + "' is '" +
                              std::string(text(column)) + "', " + std::string(need));
}

void CsvReader::refuse_row(const std::string& what) const {
  throw std::invalid_argument(name_ + ":" + std::to_string(line_of_row_) + ": " + what);
}

}  // namespace perp
