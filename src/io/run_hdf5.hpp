// The tables of a run as one HDF5 file: a group a table, a dataset a column.
#pragma once

#include <filesystem>
#include <memory>

#include "io/run_table.hpp"

namespace perp {

/// FOLDER/run.h5, with groups /trajectory, /contacts, ... and in each its columns by their names in the CSV files: one-dimensional, as long
/// as the table has rows; numbers as double, NaN for "not set"; text as strings of UTF-8. Chunked, so that it grows while the run goes on.
class Hdf5Tables {
 public:
  /// A new file, or one that is taken up again. Throws std::invalid_argument if it cannot be made, or where perp was built
  /// without HDF5.
  Hdf5Tables(const std::filesystem::path& folder, bool again);
  ~Hdf5Tables();

  /// A new table, or one taken up at `rows`, what is past them given up.
  std::unique_ptr<RunTable> table(const std::string& name, const std::vector<RunColumn>& header,
                                  std::uintmax_t rows);

  struct File;

 private:
  std::shared_ptr<File> file_;
};

}  // namespace perp
