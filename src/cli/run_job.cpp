#include "cli/run_job.hpp"

#include <unistd.h>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "cli/commands.hpp"
#include "cli/start_faults.hpp"
#include "cli/view_page.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/reduced_system.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/study/accuracy.hpp"

namespace perp {
namespace {

using Clock = std::chrono::steady_clock;

volatile std::sig_atomic_t caught = 0;

/// SIGINT, SIGTERM, SIGHUP and SIGXCPU end the run after the step in hand; the second one ends the program.
class Signals {
 public:
  Signals() {
    caught = 0;
    struct sigaction action {};
    action.sa_handler = [](int signal) { caught = signal; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU}) sigaction(signal, &action, nullptr);
  }
  static std::string name() {
    const char* const abbreviation = sigabbrev_np(caught);
    return abbreviation == nullptr ? std::to_string(caught) : std::string("SIG") + abbreviation;
  }
};

/// Rows into the folder; on a terminal a line that is written over; with --verbose a line a step.
class Show final : public RunSink {
 public:
  Show(RunFolder& folder, double t_end, const RunManner& manner)
      : folder_(folder),
        t_begin_(folder.t()),
        t_end_(t_end),
        verbose_(manner.verbose),
        line_(!manner.quiet && !manner.verbose && isatty(STDERR_FILENO) != 0) {}
  ~Show() override {
    if (shown_) std::fputs("\r\033[K", stderr);
  }

  void step(const State& x, const StepReport& report) override {
    folder_.step(x, report);
    if (verbose_)
      std::printf("t = %s, h = %s: %s by %s, %d iterations, residual %.1e m/s, gap %.1e m, %zu contacts\n",
                  shortest(x.t).c_str(), shortest(report.h).c_str(),
                  std::string(name_of(report.status)).c_str(), std::string(report.solver).c_str(),
                  report.iterations, std::max(report.residuals.normal, report.residuals.friction),
                  report.gap_min, report.contacts.size());
    if (line_) show(x.t);
  }
  void event(const Event& event) override {
    folder_.event(event);
    if (event.ambiguous && (ambiguous.empty() || ambiguous.back() != event.t)) ambiguous.push_back(event.t);
    if (verbose_)
      std::printf("t = %s: %s %s\n", shortest(event.t).c_str(), std::string(name_of(event.kind)).c_str(),
                  event.contact.c_str());
  }

  std::vector<double> ambiguous;  ///< times of impacts in sequence that another order would end otherwise

 private:
  void show(double t) {
    const auto now = Clock::now();
    constexpr auto seldom = std::chrono::milliseconds(200);
    if (now - last_ < seldom) return;
    last_ = now;
    const double seconds = std::chrono::duration<double>(now - begin_).count();
    const double left = seconds * (t_end_ - t) / std::max(t - t_begin_, 1e-300);
    std::fprintf(stderr, "\r\033[Kt = %.6g of %.6g s, %zu steps, %.0f s left", t, t_end_,
                 folder_.summary().steps, left);
    std::fflush(stderr);
    shown_ = true;
  }

  RunFolder& folder_;
  double t_begin_, t_end_;
  bool verbose_, line_, shown_ = false;
  Clock::time_point begin_ = Clock::now(), last_ = begin_;
};

/// Whether an inconsistent start may be run: says once what is wrong with it, refuses it where that is large.
void judge_start(const Scene& scene, const RunRecipe& recipe, const State& start) {
  Instant now;
  evaluate(scene.model, start, now);
  if (!now.fault.empty()) refuse("perp run", "the start", now.fault, "needs to be finite");
  if (recipe.assemble) return;
  constexpr double small = 1e-3;  // of the scene's extent: what a drawing or a typed number may be off by
  const StartJudge judge(scene, now);
  double worst = 0;
  std::string text;
  int more = -3;
  for (const StartFault& fault : judge.all()) {
    if (fault.length == 0) continue;  // velocities change in the first step, as in any impact
    worst = std::max(worst, fault.length);
    if (++more <= 0) text += (text.empty() ? "" : "; ") + fault.what;
  }
  if (text.empty()) return;
  if (more > 0) text += "; and " + std::to_string(more) + " more";
  const bool meant = recipe.allow_overlap || !is_scene_file(recipe.scene);
  if (worst > small * judge.length() && !meant)
    throw std::invalid_argument(
        recipe.scene + ": the start is not consistent (" + text +
        "), needs to be, or --assemble, which moves it to the nearest one that is, or "
        "--allow-overlap, which runs it as it is");
  std::fprintf(stderr, "perp: %s: the start is not consistent: %s\n", recipe.scene.c_str(), text.c_str());
}

State start_of(const Scene& scene, const RunRecipe& recipe, const RunManner& manner) {
  State start = scene.start;
  if (!recipe.assemble) return start;
  const Projection found = project_onto_constraints(scene.model, start);
  if (!found.reached)
    refuse("perp run", "--assemble", "not possible", "no consistent start is near (perp check says more)");
  if (!manner.quiet)
    std::printf("assembly moved the start by %.6g m or rad and %.6g m/s or rad/s\n", found.moved,
                found.moved_velocity);
  return start;
}

void summarise(const Scene& scene, const RunRecipe& recipe, const RunFolder& run, const RunEnd& end,
               const std::filesystem::path& folder) {
  const RunSummary& s = run.summary();
  if (!end.stopped_by.empty())
    std::printf("event '%s' ended the run at t = %s s\n", end.stopped_by.c_str(), shortest(end.x.t).c_str());
  std::printf("%s by %s: %zu steps to t = %s s\n", scene.name.c_str(), recipe.method.c_str(), s.steps,
              shortest(run.t()).c_str());
  std::printf("largest contact residual %.1e m/s, smallest gap %.1e m, largest joint error %.1e\n",
              s.residual, s.gap_min, s.joint_error);
  const bool adaptive = method(recipe.method).adaptive, events = adaptive || !scene.events.empty();
  if (adaptive)
    std::printf("%zu events, %ld evaluations of the right-hand side\n", s.events, end.evaluations);
  else if (events)
    std::printf("%zu events\n", s.events);
  if (end.unseen > 0)
    std::printf("loads that change with time were looked at every %.2g s or more often (--look)\n",
                end.unseen);
  if (!scene.model.joints().empty()) {
    Instant start;
    evaluate(scene.model, scene.start, start);
    std::printf("%zu joint equations of rank %d\n", start.joint_rows.size(), joint_rank(scene.model, start));
  }
  if (!scene.unused.empty())
    std::printf("%zu things of the file are not used: perp check lists them\n", scene.unused.size());
  if (recipe.format == "hdf5")
    std::printf("wrote trajectory, contacts, joints%s and report to %s\n", events ? ", events" : "",
                (folder / "run.h5").c_str());
  else
    std::printf("wrote trajectory.csv, contacts.csv, joints.csv%s and report.csv to %s\n",
                events ? ", events.csv" : "", folder.c_str());
}

/// Impacts in sequence whose order rigid bodies leave open.
void say_ambiguous(const std::vector<double>& times) {
  if (times.empty()) return;
  std::printf("the order of impacts matters and is not unique at t = %s s", shortest(times.front()).c_str());
  if (times.size() > 1) std::printf(" and at %zu times more", times.size() - 1);
  std::printf(": pairs of bodies that approach alike were struck together\n");
}

/// What --accuracy asks for: the recipe gets its step or tolerance. The same for the same run, so that one can be taken up again.
std::optional<AccuracyChoice> choose(const Scene& scene, const State& start, const RunManner& manner,
                                     RunRecipe& recipe) {
  if (std::isnan(recipe.accuracy)) return std::nullopt;
  if (!scene.events.empty())
    refuse("perp run", "--accuracy", recipe.accuracy, "needs a scene without events of its own");
  AccuracyChoice choice = choose_for_accuracy(scene.model, start,
                                              {.method = recipe.method,
                                               .options = recipe.options,
                                               .accuracy = recipe.accuracy,
                                               .t_end = recipe.until});
  recipe.options = choice.options;
  recipe.step = choice.h;
  if (manner.quiet) return choice;
  if (std::isnan(choice.h))
    std::printf("tolerance %s", shortest(choice.options.tolerance).c_str());
  else
    std::printf("step %s", shortest(choice.h).c_str());
  if (method(recipe.method).polygonal) std::printf(", %d edges", choice.options.edges);
  std::printf(": error %.1e m or rad by trial\n", choice.error);
  return choice;
}

}  // namespace

int run_into(const std::filesystem::path& folder, const RunRecord& record, const Scene& scene,
             const RunManner& manner, bool resume) {
  RunRecipe recipe = record.recipe;
  const std::unique_ptr<Stepper> first =
      make_stepper(recipe.method, recipe.options);  // refuses wrong options
  const bool adaptive = method(recipe.method).adaptive;
  const State start = start_of(scene, recipe, manner);
  if (!resume) judge_start(scene, recipe, start);
  const std::optional<AccuracyChoice> choice = choose(scene, start, manner, recipe);
  std::function<double(const State&)> error_estimate;
  if (choice) error_estimate = [&](const State& x) { return choice->estimate(scene.model, x); };

  const Signals signals;  // before there is a folder that they could leave half begun
  RunFolder files(folder);
  std::optional<RunRestart> restart;
  if (resume) restart = RunFolder::restart_in(folder, record, scene.model);
  if (restart && restart->positions.empty()) restart.reset();
  files.begin(record, scene.model, start, *first, restart, !scene.events.empty(), error_estimate);

  const auto begin = Clock::now();
  std::string stopped;
  SimulateOptions options{.t_end = recipe.until, .h = recipe.step};
  options.events = scene.events;
  options.progress = [&](double) {
    if (caught != 0) stopped = "stopped by " + Signals::name();
    if (std::chrono::duration<double>(Clock::now() - begin).count() > manner.budget)
      stopped = "stopped by --budget " + shortest(manner.budget);
    return stopped.empty();
  };
  options.t_start = start.t;
  options.first_overlap = overlap(scene.model, start);
  if (restart) options.taken = restart->so_far.steps;
  if (!adaptive) options.most = steps_a_stepper - options.taken % steps_a_stepper;
  const auto goes_on = "perp run --resume " + folder.string() + " goes on from there";
  const auto at = [&] { return " at t = " + shortest(files.t()) + " s"; };
  const auto say = [&](const std::string& what) {
    std::fprintf(stderr, "perp: %s: %s\n", scene.name.c_str(), what.c_str());
  };
  int status = Done;
  RunEnd end{.x = start, .stopped_by = {}};
  std::vector<double> ambiguous;
  try {
    end = [&] {
      Show show(files, recipe.until, manner);
      RunEnd piece{.x = restart ? restart->x : start, .stopped_by = {}};
      do {
        const std::unique_ptr<Stepper> stepper = make_stepper(recipe.method, recipe.options);
        piece = simulate(scene.model, *stepper, State(piece.x), options, show);
        options.taken += piece.steps;
        options.most = adaptive ? 0 : steps_a_stepper;
      } while (!piece.reached && piece.stopped_by.empty() && stopped.empty());
      ambiguous = show.ambiguous;
      return piece;
    }();
    const bool done = end.reached || !end.stopped_by.empty(), accurate = !choice || choice->reached;
    if (!end.stopped_by.empty())
      stopped = "ended by event '" + end.stopped_by + "'" + at();
    else
      stopped = end.reached ? "reached T" : stopped + at();
    status = done && accurate ? Done : ToleranceNotReached;
    if (!accurate)
      say("--accuracy " + shortest(recipe.accuracy) + " was not reached by " + recipe.method + ": " +
          choice->why);
    files.end(status, stopped, nullptr, done);
    if (!done) say(stopped + "; " + goes_on);
  } catch (const StepFailure& failure) {
    status = ToleranceNotReached;
    files.end(status, failure.what(), &failure.report, false);
    say(failure.what());
  } catch (const std::runtime_error& error) {  // the disk
    throw std::runtime_error(sentence_of(error) + "; the run had come to t = " + shortest(files.t()) +
                             " s, and rows are whole; " + goes_on);
  }
  if (!manner.quiet) {
    summarise(scene, recipe, files, end, folder);
    say_ambiguous(ambiguous);
  }
  if (manner.view) write_view({folder.string()}, folder / "view.html", manner.quiet);
  return status;
}

}  // namespace perp
