#include "io/sweep_journal.hpp"

#include <stdexcept>
#include <utility>

#include "io/numbers_as_text.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr const char* journal_file = "sweep.journal";

SweepAnswer answer_in(const std::vector<std::string>& cells) {
  if (cells.size() != 7) throw std::runtime_error("not the cells of a run");
  const Vector answers = vector_in(cells[5]);
  return {.t = number_in(cells[2]),
          .answers = {answers.begin(), answers.end()},
          .passed = cells[3] == "1",
          .failed = cells[4] == "1",
          .message = cells[6]};
}

}  // namespace

SweepJournal::Contents SweepJournal::read(const std::filesystem::path& folder, const std::string& mark) {
  Contents contents;
  JournalFile::read(folder / journal_file, [&](const std::vector<std::string>& cells) {
    if (cells[0] == mark) contents[static_cast<long>(number_in(cells.at(1)))] = answer_in(cells);
  });
  return contents;
}

SweepJournal::SweepJournal(const std::filesystem::path& folder, std::string mark)
    : file_(folder / journal_file, "sweep", "--out"),
      mark_(std::move(mark)),
      contents_(read(folder, mark_)) {}

void SweepJournal::add(long number, const SweepAnswer& answer) {
  std::string answers;
  for (const double x : answer.answers) answers += (answers.empty() ? "" : " ") + shortest(x);
  const std::string cells = mark_ + "\t" + std::to_string(number) + "\t" + shortest(answer.t) + "\t" +
                            (answer.passed ? "1" : "0") + "\t" + (answer.failed ? "1" : "0") + "\t" +
                            answers + "\t" + journal_cell(answer.message);
  file_.append(cells);
  const std::lock_guard lock(one_at_a_time_);
  contents_[number] = answer;
}

}  // namespace perp
