#include "io/study_journal.hpp"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "io/numbers_as_text.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr const char* file_name = "runs.journal";

int count(const std::string& text) {
  const double value = number_in(text);
  if (!(value >= 0 && value <= 2e9) || value != std::floor(value))
    throw std::runtime_error("not a count: " + text);
  return static_cast<int>(value);
}

std::string cells_of(const std::string& key, const StudyRun& run) {
  std::string text = "R\t" + journal_cell(key) + "\t" + std::to_string(run.n);
  for (const double x : {run.h, run.error_q, run.error_v, run.seconds, double(run.steps), run.iterations,
                         double(run.failed), double(run.switches), run.error_path, run.error_p, run.end.t})
    text += "\t" + shortest(x);
  return text + "\t" + as_text(run.end.q) + "\t" + as_text(run.end.nu) + "\t" + journal_cell(run.message);
}

StudyRun run_of(const std::vector<std::string>& cells) {
  StudyRun run;
  if (cells.size() != 17) throw std::runtime_error("not the cells of a run");
  run.n = count(cells[2]);
  run.h = number_in(cells[3]);
  run.error_q = number_in(cells[4]);
  run.error_v = number_in(cells[5]);
  run.seconds = number_in(cells[6]);
  run.steps = count(cells[7]);
  run.iterations = number_in(cells[8]);
  run.failed = count(cells[9]);
  run.switches = count(cells[10]);
  run.error_path = number_in(cells[11]);
  run.error_p = number_in(cells[12]);
  run.end = {.t = number_in(cells[13]), .q = vector_in(cells[14]), .nu = vector_in(cells[15])};
  run.message = cells[16];
  return run;
}

}  // namespace

StudyJournal::Contents StudyJournal::read(const std::filesystem::path& folder) {
  Contents contents;
  JournalFile::read(folder / file_name, [&](const std::vector<std::string>& cells) {
    if (cells[0] == "M") contents.machines.insert(cells.at(1));
    if (cells[0] == "R") contents.runs[cells.at(1)] = run_of(cells);
  });
  return contents;
}

StudyJournal::StudyJournal(const std::filesystem::path& folder)
    : file_(folder / file_name, "study", "folder"), contents_(read(folder)) {}

void StudyJournal::add_machine(const std::string& text) { file_.append("M\t" + journal_cell(text)); }
void StudyJournal::add_run(const std::string& key, const StudyRun& run) { file_.append(cells_of(key, run)); }

}  // namespace perp
