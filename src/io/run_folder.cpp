#include "io/run_folder.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <sstream>

#include "io/fingerprint.hpp"
#include "io/machine.hpp"
#include "io/numbers_as_text.hpp"
#include "perp/core/errors.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

constexpr const char* restart_file = "run.restart";
constexpr const char* record_file = "run.json";

/// The lines of run.restart by their first word.
std::map<std::string, std::string> lines_of(const std::string& text) {
  std::map<std::string, std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const std::size_t blank = std::min(line.find(' '), line.size());
    lines[line.substr(0, blank)] = line.substr(std::min(blank + 1, line.size()));
  }
  return lines;
}

Vector sized(const std::string& text, Eigen::Index size) {
  Vector v = vector_in(text);
  if (v.size() != size) throw std::runtime_error("it is of another model");
  return v;
}

}  // namespace

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

void RunSummary::add(const StepFigures& step) {
  ++steps;
  residual = std::max({residual, step.residuals.normal, step.residuals.friction});
  gap_min = std::min(gap_min, step.gap_min);
  joint_error = std::max(joint_error, step.joint_error);
}

RunFolder::RunFolder(const std::filesystem::path& folder)
    : folder_(folder), lock_(folder / "run.lock", OutputFile::everything) {
  if (!lock_.lock())
    refuse("perp run", "--out", folder.string(), "another run is writing to it: wait, or choose another");
}

RunRecord RunFolder::record_in(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / record_file;
  return read_record(read_file(file, "needs to be the run.json of a run"), file.string());
}

RunRestart RunFolder::restart_in(const std::filesystem::path& folder, const RunRecord& record,
                                 const Model& model) {
  const auto changed = [&](const std::string& what, const std::string& need) {
    refuse("perp run", "--resume", folder.string(), what + ": " + need);
  };
  if (record.version != version || record.build != build())
    changed("made by perp " + record.version + " (" + record.build + ")",
            "needs the same, this is perp " + std::string(version) + " (" + build() + ")");
  const std::filesystem::path file = folder / restart_file;
  const std::string text = read_file(file, "needs to be as perp run wrote it");
  const std::size_t check = text.rfind("check ");
  if (check == std::string::npos ||
      text.substr(check) != "check " + fingerprint(text.substr(0, check)) + "\n")
    throw std::invalid_argument(file.string() + ":1:1: a damaged file, needs to be as perp run wrote it");
  try {
    const std::map<std::string, std::string> lines = lines_of(text);
    if (lines.at("scene") != scene_mark(record.recipe))
      changed("the scene in run.json was changed", "needs that of the run");
    if (lines.at("method") != method_mark(record.recipe))
      changed("the method in run.json, or an option of it, was changed", "needs that of the run");
    const Vector so_far = sized(lines.at("so_far"), 5);
    RunRestart restart;
    restart.so_far = {.steps = static_cast<std::size_t>(so_far[0]),
                      .events = static_cast<std::size_t>(so_far[1]),
                      .residual = so_far[2],
                      .gap_min = so_far[3],
                      .joint_error = so_far[4]};
    restart.x = {.t = number_in(lines.at("t")),
                 .q = sized(lines.at("q"), model.nq()),
                 .nu = sized(lines.at("nu"), model.nv()),
                 .winding = vector_in(lines.at("winding"))};
    std::istringstream positions(lines.at("positions"));
    for (std::string name, at; positions >> name >> at;)
      restart.positions[name] = static_cast<std::uintmax_t>(number_in(at));
    return restart;
  } catch (const std::invalid_argument&) {
    throw;
  } catch (const std::exception& error) {
    throw std::invalid_argument(file.string() + ":1:1: " + error.what() +
                                ", needs to be as perp run wrote it");
  }
}

void RunFolder::begin(const RunRecord& record, const Model& model, const State& start, const Stepper& stepper,
                      const std::optional<RunRestart>& restart, bool events,
                      const std::function<double(const State&)>& error_estimate) {
  record_ = record;
  if (record_.start.empty()) record_.start = utc_now();
  record_.end.clear();
  record_.exit_status = -1;
  record_.ended.clear();
  restarts_ = !takes_whole_runs(stepper);
  RunFilesOptions options{.every = record.recipe.every,
                          .hdf5 = record.recipe.format == "hdf5",
                          .halves = stepper.halves(),
                          .events = events || !restarts_,
                          .taken = 0,
                          .positions = {},
                          .error_estimate = error_estimate};
  if (restart) {
    summary_ = restart->so_far;
    options.taken = summary_.steps;
    options.positions = restart->positions;
  } else {  // nothing of an older run beside this one
    std::error_code none_there;
    for (const char* name : {"trajectory", "contacts", "joints", "report", "events"})
      std::filesystem::remove(folder_ / (std::string(name) + ".csv"), none_there);
    std::filesystem::remove(folder_ / "run.h5", none_there);
    std::filesystem::remove(folder_ / restart_file, none_there);
  }
  const State& from = restart ? restart->x : start;
  t_ = from.t;
  replace_file(folder_ / record_file, write_record(record_));
  files_.emplace(folder_, model, from, options);
  if (!restart) write_restart(start);
  written_ = std::chrono::steady_clock::now();
}

void RunFolder::write_restart(const State& x) {
  std::string text = "scene " + scene_mark(record_.recipe) + "\nmethod " + method_mark(record_.recipe);
  text += "\nso_far " + std::to_string(summary_.steps) + " " + std::to_string(summary_.events);
  for (const double value : {summary_.residual, summary_.gap_min, summary_.joint_error})
    text += " " + shortest(value);
  text += "\nt " + shortest(x.t) + "\nq " + as_text(x.q) + "\nnu " + as_text(x.nu) + "\nwinding " +
          as_text(x.winding) + "\npositions";
  if (summary_.steps > 0)
    for (const auto& [name, position] : files_->positions())
      text += " " + name + " " + std::to_string(position);
  text += "\n";
  replace_file(folder_ / restart_file, text + "check " + fingerprint(text) + "\n");
  written_ = std::chrono::steady_clock::now();
}

void RunFolder::step(const State& x, const StepReport& report) {
  files_->step(x, report);
  summary_.add(report);
  t_ = x.t;
  if (!restarts_ || summary_.steps % steps_a_stepper != 0) return;
  constexpr auto seldom = std::chrono::milliseconds(500);
  if (std::chrono::steady_clock::now() - written_ < seldom) return;
  files_->flush();
  write_restart(x);
}

void RunFolder::event(const Event& event) {
  files_->event(event);
  ++summary_.events;
}

void RunFolder::end(int exit_status, const std::string& how, const StepReport* failed, bool complete) {
  files_->finish(failed);
  record_.end = utc_now();
  record_.exit_status = exit_status;
  record_.ended = how;
  replace_file(folder_ / record_file, write_record(record_));
  std::error_code none_there;
  if (complete) std::filesystem::remove(folder_ / restart_file, none_there);
}

}  // namespace perp
