#include "io/journal_file.hpp"

#include <exception>

#include "io/fingerprint.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == '\t')
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

/// Calls `take` with each line that an end of line ends; returns the bytes up to the last of these.
std::size_t for_lines(const std::filesystem::path& path,
                      const std::function<void(const std::string& line)>& take) {
  if (std::error_code none; !std::filesystem::exists(path, none)) return 0;
  const std::string text = read_file(path, "needs to be a journal of finished runs");
  std::size_t whole = 0;
  for (std::size_t end; (end = text.find('\n', whole)) != std::string::npos; whole = end + 1)
    take(text.substr(whole, end - whole));
  return whole;
}

}  // namespace

std::string journal_cell(std::string text) {
  for (char& c : text)
    if (c == '\t' || c == '\n' || c == '\r') c = ' ';
  return text;
}

JournalFile::JournalFile(const std::filesystem::path& path, const std::string& owner,
                         const std::string& argument)
    : file_(path, OutputFile::everything) {
  if (!file_.lock())
    refuse(owner, argument, path.parent_path().string(),
           "another " + owner + " is writing to it: wait, or choose another");
  file_.cut(for_lines(path, [](const std::string&) {}));
}

void JournalFile::read(const std::filesystem::path& path,
                       const std::function<void(const std::vector<std::string>& cells)>& take) {
  for_lines(path, [&](const std::string& line) {
    std::vector<std::string> cells = split(line);
    if (cells.size() < 2 || cells[0] != fingerprint(std::string_view(line).substr(cells[0].size() + 1)))
      return;
    cells.erase(cells.begin());
    try {
      take(cells);
    } catch (const std::exception&) {  // of another perp: its run is made again
    }
  });
}

void JournalFile::append(const std::string& cells) {
  const std::lock_guard lock(one_at_a_time_);
  file_.append(fingerprint(cells) + "\t" + cells + "\n");
  file_.sync();
}

}  // namespace perp
