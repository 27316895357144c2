// The memory of a sweep: every finished run on a line of its own, on the disk before the next one begins.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "io/journal_file.hpp"
#include "perp/core/types.hpp"

namespace perp {

/// What came out of a run of a sweep.
struct SweepAnswer {
  double t = not_set;           ///< where it ended [s]
  std::vector<double> answers;  ///< to what was asked; NaN: it did not happen
  bool passed = false, failed = false;
  std::string message;
};

/// A file FOLDER/sweep.journal: a checksum, the sweep's mark, the run's number, cells, with tabs between them. Lines that were cut off,
/// or are of another sweep, are dropped: their runs are made again.
class SweepJournal {
 public:
  /// Throws std::invalid_argument if it cannot be written, or another sweep is writing to it now.
  SweepJournal(const std::filesystem::path& folder, std::string mark);

  using Contents = std::map<long, SweepAnswer>;
  [[nodiscard]] static Contents read(const std::filesystem::path& folder, const std::string& mark);
  const Contents& contents() const { return contents_; }
  void add(long number, const SweepAnswer& answer);  ///< threads may call it at once

 private:
  JournalFile file_;
  std::string mark_;
  Contents contents_;
  std::mutex one_at_a_time_;
};

}  // namespace perp
