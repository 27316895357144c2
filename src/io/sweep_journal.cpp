#include "io/sweep_journal.hpp"

#include <utility>

#include "io/fingerprint.hpp"
#include "io/numbers_as_text.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr const char* journal_file = "sweep.journal";

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\t' || c == '\n' || c == '\r') c = ' ';
  return text;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == '\t')
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

}  // namespace

SweepJournal::Contents SweepJournal::read(const std::filesystem::path& folder, const std::string& mark,
                                          std::size_t* whole) {
  Contents contents;
  if (std::error_code none; !std::filesystem::exists(folder / journal_file, none)) return contents;
  const std::string text = read_file(folder / journal_file, "needs to be a sweep's journal");
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    if (whole != nullptr) *whole = end + 1;
    const std::string line = text.substr(begin, end - begin);
    const std::vector<std::string> cells = cells_of(line);
    constexpr std::size_t count = 8;
    if (cells.size() != count ||
        cells[0] != fingerprint(std::string_view(line).substr(cells[0].size() + 1)) || cells[1] != mark)
      continue;
    try {
      const Vector answers = vector_in(cells[6]);
      contents[static_cast<long>(number_in(cells[2]))] = {.t = number_in(cells[3]),
                                                          .answers = {answers.begin(), answers.end()},
                                                          .passed = cells[4] == "1",
                                                          .failed = cells[5] == "1",
                                                          .message = cells[7]};
    } catch (const std::exception&) {  // of another perp: its run is made again
    }
  }
  return contents;
}

SweepJournal::SweepJournal(const std::filesystem::path& folder, std::string mark) : mark_(std::move(mark)) {
  file_ = OutputFile(folder / journal_file, OutputFile::everything);
  if (!file_.lock())
    refuse("perp study", "--out", folder.string(), "another sweep is writing to it: wait, or choose another");
  std::size_t whole = 0;
  contents_ = read(folder, mark_, &whole);
  file_.cut(whole);
}

void SweepJournal::add(long number, const SweepAnswer& answer) {
  std::string answers;
  for (const double x : answer.answers) answers += (answers.empty() ? "" : " ") + shortest(x);
  const std::string cells = mark_ + "\t" + std::to_string(number) + "\t" + shortest(answer.t) + "\t" +
                            (answer.passed ? "1" : "0") + "\t" + (answer.failed ? "1" : "0") + "\t" +
                            answers + "\t" + one_line(answer.message);
  const std::lock_guard lock(one_at_a_time_);
  file_.append(fingerprint(cells) + "\t" + cells + "\n");
  file_.sync();
  contents_[number] = answer;
}

}  // namespace perp
