#include "perp/io/sweep.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "core/files.hpp"
#include "io/fingerprint.hpp"
#include "io/observables.hpp"
#include "io/sweep_journal.hpp"
#include "io/sweep_plan.hpp"
#include "io/sweep_tables.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

constexpr const char* request_name = "sweep.request";
constexpr std::string_view time_of = "time:";

/// What all runs of a journal have in common: runs of another scene, method or version are not taken for them.
std::string mark_of(const SweepRequest& request) {
  std::string identity = std::string(version) + "\n" + write_sweep_request(request);
  if (is_scene_file(request.scene)) identity += scene_text(request.scene);
  return fingerprint(identity);
}

double step_of(const std::string& text, double length) {
  constexpr const char* need = "needs to be one step in seconds, or T/N for N steps";
  const bool parts = text.starts_with("T/");
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + (parts ? 2 : 0), end, value);
  if (read.ec != std::errc() || read.ptr != end || !(value > 0)) refuse("perp study", "--steps", text, need);
  return parts ? length / std::max(1.0, std::round(value)) : value;
}

/// An expression in what a run of the scene has; says which argument it is of.
std::function<double(const Model&, const State&)> quantity(const char* argument, const std::string& text,
                                                           const Scene& scene) {
  const std::vector<Observable> all = observables_of(scene.model);
  std::vector<std::string> names;
  for (const Observable& o : all) names.push_back(o.name);
  SceneParameters constants;
  for (const SceneParameter& p : scene.parameters) constants[p.name] = p.value;
  try {
    return observed(Expression(text, constants, names), all);
  } catch (const ExpressionError& error) {
    refuse("perp study", argument, text, std::string("needs to be an expression: ") + error.what());
  }
}

/// A > B or A < B as a function that is positive where it holds.
std::function<double(const Model&, const State&)> passing(const std::string& text, const Scene& scene) {
  const std::size_t at = text.find_first_of("<>");
  if (at == std::string::npos || text.find_first_of("<>", at + 1) != std::string::npos)
    refuse("perp study", "--pass", text, "needs to be A > B or A < B");
  const auto left = quantity("--pass", text.substr(0, at), scene);
  const auto right = quantity("--pass", text.substr(at + 1), scene);
  const double sign = text[at] == '>' ? 1 : -1;
  return [=](const Model& m, const State& x) { return sign * (left(m, x) - right(m, x)); };
}

/// Keeps the first time of each event that is asked for.
class EventTimes final : public RunSink {
 public:
  explicit EventTimes(const std::vector<std::string>& ask) : times(ask.size(), not_set), ask_(ask) {}
  void step(const State& /*x*/, const StepReport& /*report*/) override {}
  void event(const Event& event) override {
    for (std::size_t i = 0; i < ask_.size(); ++i) {
      if (!ask_[i].starts_with(time_of) || !std::isnan(times[i])) continue;
      const std::string_view name = std::string_view(ask_[i]).substr(time_of.size());
      if (event.contact == name || name_of(event.kind) == name) times[i] = event.t;
    }
  }
  std::vector<double> times;

 private:
  const std::vector<std::string>& ask_;
};

SweepAnswer answer(const SweepRequest& request, const SweepRun& run) {
  SweepAnswer result;
  result.answers.assign(request.ask.size(), not_set);
  SceneParameters set = request.set;
  for (std::size_t i = 0; i < run.values.size(); ++i) set[request.axes[i].name] = run.values[i];
  try {
    const Scene scene = load_scene(request.scene, set);
    const Method& chosen = method(request.methods[run.method]);
    const std::unique_ptr<Stepper> stepper =
        make_stepper(chosen.name, {.edges = request.edges, .tolerance = request.tolerance});
    const double until = std::isnan(request.until) ? scene.t_end : request.until;
    EventTimes sink(request.ask);
    SimulateOptions options{.t_end = until};
    if (!chosen.adaptive) options.h = step_of(request.step, until - scene.start.t);
    options.events = scene.events;
    const RunEnd end = simulate(scene.model, *stepper, scene.start, options, sink);
    result.t = end.x.t;
    for (std::size_t i = 0; i < request.ask.size(); ++i)
      result.answers[i] = request.ask[i].starts_with(time_of)
                              ? sink.times[i]
                              : quantity("--ask", request.ask[i], scene)(scene.model, end.x);
    if (!request.pass.empty()) result.passed = passing(request.pass, scene)(scene.model, end.x) > 0;
  } catch (const StepFailure& failure) {
    result.failed = true;
    result.t = failure.trajectory.size() > 0 ? failure.trajectory.back().t : not_set;
    result.message = failure.what();
  } catch (const std::invalid_argument& refused) {  // values that the scene cannot take
    result.failed = true;
    result.message = refused.what();
  }
  return result;
}

/// Makes the runs of a shard that the journal does not have, in threads.
class SweepWorkers {
 public:
  SweepWorkers(const SweepRequest& request, const StudyOptions& options, SweepJournal& journal)
      : request_(request), options_(options), journal_(journal) {
    const long n = sweep_size(request);
    for (long i = options.shard - 1; i < n; i += options.shards) {
      ++planned;
      (journal.contents().contains(i) ? before : left_) += 1;
      if (!journal.contents().contains(i)) waiting_.push_back(i);
    }
  }

  void work() {
    std::vector<std::thread> others;
    const auto useful = static_cast<int>(std::min<std::size_t>(waiting_.size(), 1024));
    try {
      for (int k = 1; k < std::min(options_.jobs, useful); ++k) others.emplace_back([this] { loop(); });
    } catch (const std::system_error&) {  // the system gives no more: with those there are
    }
    loop();
    for (std::thread& thread : others) thread.join();
    if (error_) std::rethrow_exception(error_);
  }

  long planned = 0, before = 0, made = 0;

 private:
  void loop() {
    for (long number; (number = take()) >= 0;) {
      try {
        journal_.add(number, answer(request_, sweep_run(request_, number)));
        const std::lock_guard lock(mutex_);
        ++made;
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!error_) error_ = std::current_exception();
      }
    }
  }

  long take() {
    const std::lock_guard lock(mutex_);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    if (error_ || next_ == waiting_.size() || seconds > options_.budget) return -1;
    const long number = waiting_[next_++];
    if (options_.progress)
      options_.progress({.done = static_cast<int>(before + made),
                         .planned = static_cast<int>(planned),
                         .next = "run " + std::to_string(number + 1)});
    return number;
  }

  const SweepRequest& request_;
  const StudyOptions& options_;
  SweepJournal& journal_;
  std::vector<long> waiting_;
  std::size_t next_ = 0;
  long left_ = 0;
  std::exception_ptr error_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

void count(const SweepJournal::Contents& contents, SweepOutcome& outcome) {
  for (const auto& [number, a] : contents) outcome.failed += a.failed, outcome.passed += a.passed;
}

}  // namespace

Share wilson(long passed, long n) {
  if (n == 0) return {.share = not_set};
  constexpr double z = 1.959963984540054;
  const double N = double(n), p = double(passed) / N, d = 1 + z * z / N;
  const double middle = (p + z * z / (2 * N)) / d,
               half = z * std::sqrt(p * (1 - p) / N + z * z / (4 * N * N)) / d;
  return {p, passed == 0 ? 0 : middle - half, passed == n ? 1 : middle + half};
}

bool is_sweep(const std::filesystem::path& folder) { return std::filesystem::exists(folder / request_name); }

SweepOutcome run_sweep(const SweepRequest& request, const std::filesystem::path& folder,
                       const StudyOptions& options) {
  check_sweep(request);
  if (options.jobs < 1) refuse("perp study", "--jobs", double(options.jobs), "needs to be 1 or more");
  if (options.shards < 1 || options.shard < 1 || options.shard > options.shards)
    refuse("perp study", "--shard", std::to_string(options.shard) + "/" + std::to_string(options.shards),
           "needs to be I/N, I from 1 to N");
  const Scene scene = load_scene(request.scene, request.set);
  for (const std::string& ask : request.ask)  // refused now, not in every run
    if (!ask.starts_with(time_of)) (void)quantity("--ask", ask, scene);
  if (!request.pass.empty()) (void)passing(request.pass, scene);
  if (!request.step.empty()) (void)step_of(request.step, scene.t_end);
  const std::string mark = mark_of(request);
  SweepJournal journal(folder, mark);
  replace_file(folder / request_name, write_sweep_request(request));
  SweepWorkers workers(request, options, journal);
  workers.work();
  SweepOutcome outcome{.planned = workers.planned, .before = workers.before, .made = workers.made};
  count(journal.contents(), outcome);
  if (options.shards == 1) outcome.no_pictures = write_sweep(request, journal.contents(), folder);
  return outcome;
}

SweepOutcome merge_sweeps(const std::vector<std::filesystem::path>& folders,
                          const std::filesystem::path& folder) {
  if (folders.empty()) refuse("perp study", "--merge", "nothing", "needs one folder or more");
  const SweepRequest request = read_sweep_request(folders.front() / request_name);
  const std::string mark = mark_of(request), text = write_sweep_request(request);
  SweepJournal journal(folder, mark);
  for (const std::filesystem::path& from : folders) {
    if (!is_sweep(from) || write_sweep_request(read_sweep_request(from / request_name)) != text)
      refuse("perp study", "--merge", from.string(),
             "needs to be a part of the sweep of " + folders.front().string());
    for (const auto& [number, a] : SweepJournal::read(from, mark))
      if (!journal.contents().contains(number)) journal.add(number, a);
  }
  replace_file(folder / request_name, text);
  SweepOutcome outcome{.planned = sweep_size(request),
                       .before = static_cast<long>(journal.contents().size())};
  count(journal.contents(), outcome);
  outcome.no_pictures = write_sweep(request, journal.contents(), folder);
  return outcome;
}

}  // namespace perp
