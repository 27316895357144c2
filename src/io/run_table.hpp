// A table of a run that grows while the run goes on: rows of named columns, as CSV or HDF5.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/files.hpp"
#include "perp/io/csv_file.hpp"

namespace perp {

struct RunColumn {
  std::string name;
  bool text = false;  ///< else numbers
};

class RunTable {
 public:
  virtual ~RunTable() = default;
  RunTable() = default;
  RunTable(const RunTable&) = delete;
  RunTable& operator=(const RunTable&) = delete;

  virtual RunTable& cell(double value) = 0;
  virtual RunTable& cell(int value) = 0;
  virtual RunTable& cell(std::string_view text) = 0;
  virtual void end_row() = 0;

  virtual void flush() = 0;  ///< the rows so far are in the file, each whole
  virtual std::uintmax_t position()
      const = 0;  ///< of the next row, after flush(): what a table is taken up from
  virtual void close() = 0;
};

/// Rows as CSV.
class CsvTable final : public RunTable {
 public:
  /// A new table; or one taken up at `position`, what is past it given up.
  CsvTable(const std::filesystem::path& path, const std::vector<RunColumn>& header, std::uintmax_t position);

  RunTable& cell(double value) override { return text_.cell(value), *this; }
  RunTable& cell(int value) override { return text_.cell(value), *this; }
  RunTable& cell(std::string_view text) override { return text_.cell(text), *this; }
  void end_row() override;
  void flush() override;
  std::uintmax_t position() const override { return file_.size(); }
  void close() override;

 private:
  OutputFile file_;
  CsvText text_;  // rows that the file does not have yet
};

}  // namespace perp
