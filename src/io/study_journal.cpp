#include "io/study_journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <vector>

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

double number(const std::string& text) {
  double value = not_set;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size())
    throw std::runtime_error("not a number: " + text);
  return value;
}

std::string numbers(const Vector& v) {
  std::string text;
  for (const double x : v) text += (text.empty() ? "" : " ") + shortest(x);
  return text;
}

Vector vector(const std::string& text) {
  std::vector<double> values;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    values.push_back(number(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::string cells_of(const std::string& key, const StudyRun& run) {
  std::string text = "R\t" + cell(key) + "\t" + std::to_string(run.n);
  for (const double x : {run.h, run.error_q, run.error_v, run.seconds, double(run.steps), run.iterations,
                         double(run.failed), run.end.t})
    text += "\t" + shortest(x);
  return text + "\t" + numbers(run.end.q) + "\t" + numbers(run.end.nu) + "\t" + cell(run.message);
}

StudyRun run_of(const std::vector<std::string>& cells) {
  StudyRun run;
  run.n = static_cast<int>(number(cells.at(3)));
  run.h = number(cells.at(4));
  run.error_q = number(cells.at(5));
  run.error_v = number(cells.at(6));
  run.seconds = number(cells.at(7));
  run.steps = static_cast<int>(number(cells.at(8)));
  run.iterations = number(cells.at(9));
  run.failed = static_cast<int>(number(cells.at(10)));
  run.end = {.t = number(cells.at(11)), .q = vector(cells.at(12)), .nu = vector(cells.at(13))};
  run.message = cells.at(14);
  return run;
}

}  // namespace

std::string fingerprint(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
  return digits;
}

StudyJournal::Contents StudyJournal::read(const std::filesystem::path& folder) {
  std::ifstream in(folder / file_name, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  Contents contents;
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    contents.whole = end + 1;
    const std::string line = text.substr(begin, end - begin);
    const std::vector<std::string> cells = split(line);
    if (cells.size() < 3 || cells[0] != fingerprint(std::string_view(line).substr(cells[0].size() + 1)))
      continue;
    if (cells[1] == "M") contents.machines.insert(cells[2]);
    if (cells[1] == "R") contents.runs[cells[2]] = run_of(cells);
  }
  return contents;
}

StudyJournal::StudyJournal(const std::filesystem::path& folder) : path_(folder / file_name) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  file_ = open(path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0)
    refuse("study", "folder", folder.string(),
           std::string("needs to be a folder that can be written: ") + std::strerror(errno));
  if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
    close(file_);
    refuse("study", "folder", folder.string(), "another study is writing to it: wait, or choose another");
  }
  contents_ = read(folder);
  if (ftruncate(file_, static_cast<off_t>(contents_.whole)) != 0) {
    close(file_);
    refuse("study", "folder", folder.string(), std::string("cannot be written: ") + std::strerror(errno));
  }
}

StudyJournal::~StudyJournal() { close(file_); }

void StudyJournal::add_machine(const std::string& text) { append("M\t" + cell(text)); }
void StudyJournal::add_run(const std::string& key, const StudyRun& run) { append(cells_of(key, run)); }

void StudyJournal::append(const std::string& cells) {
  const std::lock_guard lock(one_at_a_time_);
  const std::string line = fingerprint(cells) + "\t" + cells + "\n";
  const bool written = write(file_, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  if (!written || fdatasync(file_) != 0)
    throw std::runtime_error("writing " + path_.string() + ": " + std::strerror(errno));
}

}  // namespace perp
