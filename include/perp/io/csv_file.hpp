// Tables for other programs: CSV with a header line, commas, and numbers that read back to the same double.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace perp {

/// Rows of CSV as text. Numbers are the shortest decimals that read back to the same double, '.' whatever the locale;
/// NaN, "not set" in perp, is an empty cell. Text with a comma, quote or line break is quoted.
class CsvText {
 public:
  CsvText& cell(double value);
  CsvText& cell(int value);
  CsvText& cell(std::string_view text);
  CsvText& end_row();

  const std::string& rows() const { return rows_; }  ///< those ended, and what is there of the next
  void clear() { rows_.clear(); }

 private:
  CsvText& next();
  std::string rows_;
  bool first_ = true;
};

/// A CSV file that is written row by row and appears under its name whole or not at all: rows go to PATH.part,
/// which `finish` renames.
/// Throws std::invalid_argument if the file cannot be made, std::runtime_error if the disk refuses what is
/// written.
class CsvFile {
 public:
  CsvFile(std::filesystem::path path, const std::vector<std::string>& header);
  ~CsvFile();  ///< unfinished: removes what was written
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  CsvFile& cell(double value);
  CsvFile& cell(int value);
  CsvFile& cell(std::string_view text);
  void end_row();
  void finish();

 private:
  struct Part;
  std::filesystem::path path_;
  CsvText text_;  ///< rows not yet given to the file
  std::unique_ptr<Part> part_;
};

}  // namespace perp
