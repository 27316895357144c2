#include "io/study_journal.hpp"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "io/fingerprint.hpp"
#include "io/numbers_as_text.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr const char* file_name = "runs.journal";

/// The text as one cell: no tab, no end of line.
std::string cell(std::string text) {
  for (char& c : text)
    if (c == '\t' || c == '\n' || c == '\r') c = ' ';
  return text;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == '\t')
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

int count(const std::string& text) {
  const double value = number_in(text);
  if (!(value >= 0 && value <= 2e9) || value != std::floor(value))
    throw std::runtime_error("not a count: " + text);
  return static_cast<int>(value);
}

std::string cells_of(const std::string& key, const StudyRun& run) {
  std::string text = "R\t" + cell(key) + "\t" + std::to_string(run.n);
  for (const double x : {run.h, run.error_q, run.error_v, run.seconds, double(run.steps), run.iterations,
                         double(run.failed), double(run.switches), run.error_path, run.error_p, run.end.t})
    text += "\t" + shortest(x);
  return text + "\t" + as_text(run.end.q) + "\t" + as_text(run.end.nu) + "\t" + cell(run.message);
}

StudyRun run_of(const std::vector<std::string>& cells) {
  StudyRun run;
  if (cells.size() != 18) throw std::runtime_error("not the cells of a run");
  run.n = count(cells[3]);
  run.h = number_in(cells[4]);
  run.error_q = number_in(cells[5]);
  run.error_v = number_in(cells[6]);
  run.seconds = number_in(cells[7]);
  run.steps = count(cells[8]);
  run.iterations = number_in(cells[9]);
  run.failed = count(cells[10]);
  run.switches = count(cells[11]);
  run.error_path = number_in(cells[12]);
  run.error_p = number_in(cells[13]);
  run.end = {.t = number_in(cells[14]), .q = vector_in(cells[15]), .nu = vector_in(cells[16])};
  run.message = cells[17];
  return run;
}

}  // namespace

StudyJournal::Contents StudyJournal::read(const std::filesystem::path& folder) {
  Contents contents;
  if (std::error_code none; !std::filesystem::exists(folder / file_name, none)) return contents;
  const std::string text = read_file(folder / file_name, "needs to be a study's journal");
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    contents.whole = end + 1;
    const std::string line = text.substr(begin, end - begin);
    const std::vector<std::string> cells = split(line);
    if (cells.size() < 3 || cells[0] != fingerprint(std::string_view(line).substr(cells[0].size() + 1)))
      continue;
    if (cells[1] == "M") contents.machines.insert(cells[2]);
    try {
      if (cells[1] == "R") contents.runs[cells[2]] = run_of(cells);
    } catch (const std::exception&) {  // of another perp: its run is made again
    }
  }
  return contents;
}

StudyJournal::StudyJournal(const std::filesystem::path& folder) {
  file_ = OutputFile(folder / file_name, OutputFile::everything);
  if (!file_.lock())
    refuse("study", "folder", folder.string(), "another study is writing to it: wait, or choose another");
  contents_ = read(folder);
  file_.cut(contents_.whole);
}

void StudyJournal::add_machine(const std::string& text) { append("M\t" + cell(text)); }
void StudyJournal::add_run(const std::string& key, const StudyRun& run) { append(cells_of(key, run)); }

void StudyJournal::append(const std::string& cells) {
  const std::lock_guard lock(one_at_a_time_);
  file_.append(fingerprint(cells) + "\t" + cells + "\n");
  file_.sync();
}

}  // namespace perp
