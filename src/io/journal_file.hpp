// A file to which finished work is added line by line, and from which whole lines are read after any end.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace perp {

/// The text as one cell: no tab, no end of line.
[[nodiscard]] std::string journal_cell(std::string text);

/// Lines of cells that tabs part, each after the fingerprint of the rest: a line that was cut, or of another's making, is no line.
class JournalFile {
 public:
  JournalFile() = default;
  /// Opens or makes it, keeps others from writing to it, and cuts it after the last whole line. `owner` ("study") and `argument` ("--out")
  /// are for the errors: throws std::invalid_argument if it cannot be written or another is writing to it now.
  JournalFile(const std::filesystem::path& path, const std::string& owner, const std::string& argument);

  /// Calls `take` with the cells of each whole line, without the fingerprint; nothing if there is no such file. Where `take` throws the line is
  /// of another perp: it is passed over.
  static void read(const std::filesystem::path& path,
                   const std::function<void(const std::vector<std::string>& cells)>& take);

  void append(const std::string& cells);  ///< on disk when it returns; threads may call it at once

 private:
  OutputFile file_;
  std::mutex one_at_a_time_;
};

}  // namespace perp
