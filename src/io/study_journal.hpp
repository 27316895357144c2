// The memory of a study: every finished run on a line of its own, on the disk before the next one begins.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "io/journal_file.hpp"
#include "perp/study/convergence.hpp"

namespace perp {

/// Appends to a file FOLDER/runs.journal and reads back what stands there. A line is a checksum, a letter (R a run, M the
/// machine on which the runs below were made) and cells, with tabs between them. One that was cut off by a crash, does
/// not have its checksum, or is no run, is dropped: its run is made again.
class StudyJournal {
 public:
  /// Opens or makes the journal and keeps others from writing to it. Throws std::invalid_argument if it cannot be written,
  /// or if another study is writing to it now.
  explicit StudyJournal(const std::filesystem::path& folder);

  /// What a journal holds, without touching it; nothing if there is none.
  struct Contents {
    std::map<std::string, StudyRun> runs;  ///< by key, without level and method
    std::set<std::string> machines;
  };
  [[nodiscard]] static Contents read(const std::filesystem::path& folder);

  const Contents& contents() const { return contents_; }
  void add_machine(const std::string& text);
  void add_run(const std::string& key, const StudyRun& run);  ///< threads may call it at once

 private:
  JournalFile file_;
  Contents contents_;
};

}  // namespace perp
