#include "perp/io/study_folder.hpp"

#include <algorithm>
#include <chrono>
#include <climits>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>

#include "core/files.hpp"
#include "io/machine.hpp"
#include "io/study_journal.hpp"
#include "io/study_page.hpp"
#include "io/study_plan.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/study_files.hpp"

namespace perp {
namespace {

constexpr const char* request_file = "study.request";

/// The run that the journal has for a planned one; null if it has none, or one of another model.
const StudyRun* found(const StudyPlan& plan, const StudyJournal::Contents& contents,
                      const PlannedRun& planned) {
  const auto known = contents.runs.find(planned.key);
  if (known == contents.runs.end()) return nullptr;
  const StudyRun& run = known->second;
  const Model& model = plan.scenes[planned.scene].scene().model;
  const bool fits = run.failed > 0 || (run.end.q.size() == model.nq() && run.end.nu.size() == model.nv());
  return fits ? &run : nullptr;
}

/// Computed references, before the first run is held against one.
void find_references(StudyPlan& plan, const StudyOptions& options) {
  for (ScenePlan& scene : plan.scenes) {
    if (options.progress && !scene.reference())
      options.progress({.done = 0,
                        .planned = static_cast<int>(plan.runs.size()),
                        .next = scene.scene().name + ": a reference, by event and by ncp2"});
    scene.find_reference();
  }
}

/// Hands out the runs that are still to be made, coarse steps first, and keeps what they came to.
class Workshop {
 public:
  Workshop(const StudyPlan& plan, const StudyOptions& options, StudyJournal& journal)
      : plan_(plan), options_(options), journal_(journal) {
    for (const PlannedRun& run : plan.runs) {
      if (run.shard != options.shard - 1) continue;
      ++planned_;
      const StudyRun* known = found(plan, journal.contents(), run);
      if (known == nullptr)
        waiting_.push_back(&run);
      else
        learn_cost(run, *known);
    }
    before_ = planned_ - static_cast<int>(waiting_.size());
    std::stable_sort(waiting_.begin(), waiting_.end(),
                     [](const PlannedRun* a, const PlannedRun* b) { return a->n < b->n; });
  }

  /// Works until nothing is left that fits the budget; rethrows what went wrong in any thread.
  void run() {
    std::vector<std::thread> others;
    const auto useful = static_cast<int>(std::min<std::size_t>(waiting_.size(), INT_MAX));
    try {
      while (threads_ < std::min(options_.jobs, useful)) {
        others.emplace_back([this] { work(); });
        ++threads_;
      }
    } catch (const std::system_error&) {  // the system gives no more: with those there are
    }
    work();
    for (std::thread& thread : others) thread.join();
    if (error_) std::rethrow_exception(error_);
  }

  int planned() const { return planned_; }
  int before() const { return before_; }
  int made() const { return made_; }
  int threads() const { return threads_; }

 private:
  void work() {
    while (const PlannedRun* next = take()) {
      try {
        const std::unique_ptr<Stepper> stepper =
            plan_.lines[next->line].stepper(plan_.scenes[next->scene].scene(), next->tolerance);
        const StudyRun run = plan_.scenes[next->scene].run(*stepper, next->level, next->n);
        journal_.add_run(next->key, run);
        const std::lock_guard lock(mutex_);
        ++made_;
        learn_cost(*next, run);
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!error_) error_ = std::current_exception();
      }
    }
  }

  const PlannedRun* take() {
    const std::lock_guard lock(mutex_);
    while (!error_ && next_ < waiting_.size()) {
      const PlannedRun* run = waiting_[next_++];
      if (elapsed() + expected_cost(*run) > options_.budget) continue;
      if (options_.progress) {
        const Scene& scene = plan_.scenes[run->scene].scene();
        options_.progress({.done = before_ + made_,
                           .planned = planned_,
                           .next = scene.name + " " + std::string(plan_.lines[run->line].method->name) + " " +
                                   (std::isnan(run->tolerance) ? std::to_string(run->n) + " steps"
                                                               : "rtol " + shortest(run->tolerance))});
      }
      return run;
    }
    return nullptr;
  }

  double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  using Line = std::pair<std::size_t, std::size_t>;
  void learn_cost(const PlannedRun& run, const StudyRun& made) {
    if (made.steps > 0) seconds_a_step_[Line(run.scene, run.line)] = made.seconds / made.steps;
  }
  /// Seconds that a run will take, from those made by its method on its scene; 0 for the first one.
  double expected_cost(const PlannedRun& run) const {
    const auto known = seconds_a_step_.find(Line(run.scene, run.line));
    return known == seconds_a_step_.end() ? 0 : known->second * run.n;
  }

  const StudyPlan& plan_;
  const StudyOptions& options_;
  StudyJournal& journal_;
  std::vector<const PlannedRun*> waiting_;
  std::size_t next_ = 0;
  int planned_ = 0, before_ = 0, made_ = 0, threads_ = 1;
  std::map<Line, double> seconds_a_step_;
  std::exception_ptr error_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Tables, charts and the page of the runs that are there.
void write_results(const StudyRequest& request, const StudyPlan& plan, const StudyJournal::Contents& contents,
                   const std::filesystem::path& folder, StudyOutcome& outcome) {
  std::vector<std::unique_ptr<Stepper>> steppers;
  std::vector<Stepper*> methods;
  for (const StudyLine& line : plan.lines) {
    steppers.push_back(line.stepper());
    methods.push_back(steppers.back().get());
  }
  for (std::size_t i = 0; i < plan.scenes.size(); ++i) {
    std::vector<StudyRun> runs;
    for (const PlannedRun& planned : plan.runs) {
      const StudyRun* known = planned.scene == i ? found(plan, contents, planned) : nullptr;
      if (known == nullptr) continue;
      runs.push_back(*known);
      runs.back().method = methods[planned.line]->name();
      runs.back().parameter = parameter_of(*methods[planned.line]);
      runs.back().level = planned.level;
      runs.back().rtol = planned.tolerance;
      outcome.failed += runs.back().failed > 0;
    }
    outcome.tables.push_back(plan.scenes[i].tabulate(std::move(runs), methods));
    if (!plan.scenes[i].reference())
      outcome.no_reference.push_back(plan.scenes[i].scene().name + ": " + plan.scenes[i].reference().words);
  }
  write_study_csv(folder / "study.csv", outcome.tables);
  write_orders_csv(folder / "orders.csv", outcome.tables);
  for (const ConvergenceTable& table : outcome.tables) {
    const std::string name = chart_name(table.scene);
    const std::string first = write_chart(convergence_chart(table), folder, name + "-convergence");
    const std::string second = write_chart(work_chart(table), folder, name + "-work");
    outcome.no_pictures = first.empty() ? second : first;
  }
  StudyPage page{.request = request, .outcome = outcome, .machines = contents.machines, .scenes = {}};
  for (const ScenePlan& scene : plan.scenes) page.scenes.push_back(&scene);
  replace_file(folder / "study.html", write_page(page, folder));
}

}  // namespace

StudyOutcome run_study(const StudyRequest& request, const std::filesystem::path& folder,
                       const StudyOptions& options) {
  if (options.jobs < 1)
    refuse("perp study", "--jobs", static_cast<double>(options.jobs), "needs to be 1 or more");
  if (options.shards < 1 || options.shard < 1 || options.shard > options.shards)
    refuse("perp study", "--shard", std::to_string(options.shard) + "/" + std::to_string(options.shards),
           "needs to be I/N, I from 1 to N");
  StudyPlan plan = plan_study(request, options.shards, options.timing);
  StudyOutcome outcome;
  {
    StudyJournal journal(folder);
    replace_file(folder / request_file, write_request(request));
    find_references(plan, options);
    Workshop workshop(plan, options, journal);
    if (workshop.before() < workshop.planned()) journal.add_machine(machine());
    workshop.run();
    outcome = {.tables = {},
               .planned = workshop.planned(),
               .before = workshop.before(),
               .made = workshop.made(),
               .threads = workshop.threads()};
  }
  const StudyJournal::Contents contents = StudyJournal::read(folder);
  if (options.shards == 1) {
    write_results(request, plan, contents, folder, outcome);
    return outcome;
  }
  for (const PlannedRun& run : plan.runs) {
    const StudyRun* known = run.shard == options.shard - 1 ? found(plan, contents, run) : nullptr;
    outcome.failed += known != nullptr && known->failed > 0;
  }
  return outcome;
}

StudyOutcome merge_studies(const std::vector<std::filesystem::path>& folders,
                           const std::filesystem::path& folder) {
  if (folders.empty()) refuse("perp study", "--merge", "nothing", "needs one folder or more");
  const StudyRequest request = read_request(folders.front() / request_file);
  StudyOutcome outcome;
  StudyPlan plan = plan_study(request);
  find_references(plan, {});
  {
    StudyJournal journal(folder);
    StudyJournal::Contents known = journal.contents();
    for (const std::filesystem::path& from : folders) {
      if (write_request(read_request(from / request_file)) != write_request(request))
        refuse("perp study", "--merge", from.string(),
               "needs to be a part of the study of " + folders.front().string());
      StudyJournal::Contents part = StudyJournal::read(from);
      for (const std::string& text : part.machines)
        if (known.machines.insert(text).second) journal.add_machine(text);
      for (const auto& [key, run] : part.runs)
        if (known.runs.emplace(key, run).second) journal.add_run(key, run);
    }
    replace_file(folder / request_file, write_request(request));
    outcome.planned = static_cast<int>(plan.runs.size());
    for (const PlannedRun& run : plan.runs) outcome.before += found(plan, known, run) != nullptr;
  }
  write_results(request, plan, StudyJournal::read(folder), folder, outcome);
  return outcome;
}

}  // namespace perp
