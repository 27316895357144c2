// perp study: scenes by methods over a ladder of steps, with orders, charts and a page.
#include <unistd.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "cli/run_job.hpp"
#include "cli/study_map.hpp"
#include "cli/sweep_arguments.hpp"
#include "io/machine.hpp"
#include "io/study_motion.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/study_files.hpp"
#include "perp/io/study_folder.hpp"
#include "perp/io/sweep.hpp"
#include "perp/step/methods.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

struct StudyArguments {
  StudyRequest request;
  StudyOptions options;
  SweepArguments sweep;
  std::vector<std::string> set, set_method, merge, maps;
  std::vector<double> tolerances;
  std::string folder, shard, velocity = "end", reference;
  bool view = false;
};

/// I/N.
void read_shard(const std::string& text, StudyOptions& options) {
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, options.shard);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == '/') {
    const auto second = std::from_chars(first.ptr + 1, end, options.shards);
    if (second.ec == std::errc() && second.ptr == end) return;
  }
  refuse("perp study", "--shard", text, "needs to be I/N, I from 1 to N");
}

/// One line that is written over, on a terminal alone.
void show_on_terminal(const StudyProgress& progress) {
  std::fprintf(stderr, "\r\033[K[%d/%d] %s", progress.done, progress.planned, progress.next.c_str());
  std::fflush(stderr);
}

std::string shown(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", x);
  return x == x ? text : "-";
}

void print_orders(const StudyOutcome& outcome) {
  std::printf("%-20s %-12s %-10s %-9s %7s %8s %7s  %s\n", "scene", "method", "", "reference", "order",
              "expected", "points", "note");
  for (const ConvergenceTable& table : outcome.tables)
    for (const OrderRow& row : table.orders)
      std::printf("%-20s %-12s %-10s %-9s %7s %8s %7d  %s\n", table.scene.c_str(), row.method.c_str(),
                  row.parameter.c_str(), std::string(name_of(row.reference)).c_str(),
                  shown(row.q.order).c_str(),
                  row.expected == row.expected ? shortest(row.expected).c_str() : "-", row.q.points,
                  note_of(row).c_str());
}

void print_references(const StudyOutcome& outcome) {
  for (const ConvergenceTable& table : outcome.tables) {
    if (table.reference == OrderReference::None || table.reference == OrderReference::Exact) continue;
    std::printf("%s: %s\n", table.scene.c_str(), table.words.c_str());
  }
  for (const ConvergenceTable& table : outcome.tables)
    for (const OrderRow& row : table.orders)
      if (!row.why.empty())
        std::printf("%s, %s%s%s: %s\n", table.scene.c_str(), row.method.c_str(),
                    row.parameter.empty() ? "" : " ", row.parameter.c_str(), row.why.c_str());
}

int report(const StudyOutcome& outcome, const StudyArguments& arguments) {
  const bool merge = !arguments.merge.empty();
  if (!outcome.tables.empty()) print_orders(outcome), print_references(outcome);
  std::printf("%d runs: %d made now, %d found there, %d failed\n", outcome.planned, outcome.made,
              outcome.before, outcome.failed);
  if (outcome.tables.empty())
    std::printf("wrote the runs of shard %s to %s: perp study --merge makes the tables\n",
                arguments.shard.c_str(), arguments.folder.c_str());
  else
    std::printf("wrote study.csv, orders.csv, charts and study.html to %s\n", arguments.folder.c_str());
  if (outcome.threads < arguments.options.jobs && outcome.threads < outcome.made)
    std::fprintf(stderr, "perp: the system gave %d threads of the %d of --jobs\n", outcome.threads,
                 arguments.options.jobs);
  if (!outcome.no_pictures.empty())
    std::fprintf(stderr, "perp: no pictures: %s; their data and scripts are there\n",
                 outcome.no_pictures.c_str());
  if (outcome.failed > 0)
    std::fprintf(stderr, "perp: %d runs ended at a step that did not reach its tolerance\n", outcome.failed);
  if (outcome.left() > 0)
    std::fprintf(stderr, "perp: %d runs are left: %s\n", outcome.left(),
                 merge ? "a shard is missing or did not end" : "the same command goes on with them");
  for (const std::string& scene : outcome.no_reference)
    std::fprintf(stderr, "perp: %s; --reference own-limit holds each method against its own\n",
                 scene.c_str());
  const bool whole = outcome.failed == 0 && outcome.left() == 0 && outcome.no_reference.empty();
  return whole ? Done : ToleranceNotReached;
}

/// Options that none of the methods uses would be taken for used.
void need_uses(const CLI::App& command, const StudyRequest& request) {
  const auto any = [&](auto fits) {
    return std::any_of(request.methods.begin(), request.methods.end(),
                       [&](const std::string& name) { return fits(method(name)); });
  };
  const auto given = [&](const char* option) { return command.count(option) > 0; };
  if (given("--edges") && !any([](const Method& m) { return m.polygonal; }))
    refuse("perp study", "--edges", std::to_string(request.edges.front()),
           "needs a method with a friction polygon among --methods");
  if (given("--set-method") && !any([](const Method& m) { return m.name == "penalty"; }))
    refuse("perp study", "--set-method", "given", "needs the method penalty among --methods");
  const bool ordered = any([](const Method& m) { return m.name == "extrapolated"; }) && given("--order");
  if (given("--order") && (!ordered || std::count(request.orders.begin(), request.orders.end(), 0) > 0))
    refuse("perp study", "--order", std::to_string(request.orders.front()),
           "needs to be 2, 4, 6, 8 or more, and extrapolated among --methods");
  if (given("--steps") && !ordered && !any([](const Method& m) { return m.order > 0; }))
    refuse("perp study", "--steps", request.steps.front(),
           "needs a method of steps of fixed size among --methods");
}

/// --map, twice: one scene, and at most one step.
int map_of(const CLI::App& command, const StudyArguments& arguments) {
  const StudyRequest& request = arguments.request;
  if (arguments.maps.size() != 2)
    refuse("perp study", "--map", arguments.maps.front(), "needs to be there twice, once for each axis");
  if (request.scenes.size() != 1 || request.methods.empty())
    refuse("perp study", "--map", arguments.maps.front(), "needs one scene, and --methods");
  for (const char* option : {"--tolerances", "--edges", "--envelope", "--velocity", "--reference", "--shard",
                             "--jobs", "--budget", "--sweep", "--view"})
    if (command.count(option) > 0) refuse("perp study", option, "given beside --map", "needs to be left out");
  AtlasRequest map{.scene = request.scenes.front(),
                   .methods = request.methods,
                   .a = read_axis(arguments.maps[0], "--map"),
                   .b = read_axis(arguments.maps[1], "--map")};
  for (const auto& [key, value] : read_parameters("perp study", arguments.set)) map.set[key] = value;
  for (const auto& [key, value] : read_parameters("perp study", arguments.set_method, "--set-method"))
    map.set_method[key] = value;
  map.until = request.until;
  if (map.a.name == map.b.name)
    refuse("perp study", "--map", map.b.name, "needs to be another axis than the first");
  if (request.steps.size() > 1)
    refuse("perp study", "--steps", request.steps[1], "needs to be one step [s] beside --map, or an axis h");
  if (request.steps.size() == 1)
    map.step = read_parameters("perp study", {"h=" + request.steps.front()}, "--steps").at("h");
  return study_map(map, arguments.folder);
}

/// The motions that the page links to. One that fails is said; the study goes on.
void make_motions(const StudyRequest& request, const std::string& folder) {
  for (const std::string& name : request.scenes) {
    RunRecord record;
    record.recipe.scene = name;
    record.recipe.set = request.set;
    record.recipe.folder = std::filesystem::current_path().string();
    const Scene scene = read_scene_of(record.recipe);
    const RunRecipe asked = motion_of(request, name, std::isnan(request.until) ? scene.t_end : request.until);
    record.recipe.method = asked.method;
    record.recipe.options = asked.options;
    record.recipe.step = asked.step;
    record.recipe.until = asked.until;
    const std::filesystem::path place = motion_folder(folder, scene.name);
    record.command = motion_command(asked, place);
    for (const SceneParameter& p : scene.parameters) record.parameters[p.name] = p.value;
    record.version = version;
    record.build = build();
    record.machine = computer();
    try {
      (void)run_into(place, record, scene, {.quiet = true, .view = true}, false);
    } catch (const std::invalid_argument& error) {
      std::fprintf(stderr, "perp: no motion of %s: %s\n", scene.name.c_str(), error.what());
    }
  }
}

int study(const CLI::App& command, StudyArguments& arguments) {
  if (!arguments.merge.empty()) {
    if (!arguments.request.scenes.empty() || !arguments.request.methods.empty())
      refuse("perp study", "--merge", arguments.merge.front(),
             "needs no scene and no method: the folders say which");
    if (is_sweep(arguments.merge.front())) return merge_sweep_command(arguments.merge, arguments.folder);
    return report(merge_studies({arguments.merge.begin(), arguments.merge.end()}, arguments.folder),
                  arguments);
  }
  if (!arguments.maps.empty()) return map_of(command, arguments);
  if (!arguments.tolerances.empty()) {
    const auto& names = arguments.request.methods;
    if (std::none_of(names.begin(), names.end(), [](const std::string& n) { return method(n).adaptive; }))
      refuse("perp study", "--tolerances", arguments.tolerances.front(),
             "needs a method that chooses its steps, as event does, among --methods");
    arguments.request.tolerances = arguments.tolerances;
  }
  need_uses(command, arguments.request);
  arguments.request.set = read_parameters("perp study", arguments.set);
  arguments.request.set_method = read_parameters("perp study", arguments.set_method, "--set-method");
  arguments.request.velocity = velocity_measure(arguments.velocity);
  if (!arguments.reference.empty()) arguments.request.reference = reference_named(arguments.reference);
  if (!arguments.shard.empty()) read_shard(arguments.shard, arguments.options);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal) arguments.options.progress = show_on_terminal;
  for (const char* option : {"--set-method", "--reference", "--view"})
    if (arguments.sweep.given() && command.count(option) > 0)
      refuse("perp study", option, "given beside --sweep", "needs to be left out");
  if (arguments.sweep.given())
    return run_sweep_command(command, arguments.sweep, arguments.request, arguments.options,
                             arguments.folder);
  if (arguments.view) make_motions(arguments.request, arguments.folder);
  const StudyOutcome outcome = run_study(arguments.request, arguments.folder, arguments.options);
  if (terminal) std::fprintf(stderr, "\r\033[K");
  return report(outcome, arguments);
}

}  // namespace

void add_study_command(CLI::App& perp, int& status) {
  CLI::App* command = perp.add_subcommand(
      "study", "Run scenes by methods over a ladder of steps: errors, orders, costs, charts");
  const auto arguments = std::make_shared<StudyArguments>();
  StudyRequest& request = arguments->request;
  StudyOptions& options = arguments->options;
  command->add_option("SCENE", request.scenes,
                      "built-in scenes (perp scenes), scene files or robots (.urdf)");
  command->add_option("--methods", request.methods, "methods (perp methods)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(some_text())
      ->type_name("A,B,...");
  command
      ->add_option("--steps", request.steps,
                   "steps h [s], or T/N for N steps; T/20, T/40, ..., T/2560 if not given")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(some_text())
      ->type_name("H1,H2,...");
  command->add_option("--tolerances", arguments->tolerances, "of methods that choose their steps")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(finite_number())
      ->type_name("R1,R2,...");
  command->add_option("--until", request.until, "end time T [s]; each scene's own if not given")
      ->check(finite_number());
  command->add_option("--set", arguments->set, "a parameter of all scenes, repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command
      ->add_option("--order", request.orders, "of extrapolated, which then takes --steps: 4, 6, 8, or more")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(whole_number())
      ->type_name("K1,K2,...");
  command->add_option("--set-method", arguments->set_method, "a setting of penalty, repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command->add_option("--edges", request.edges, "edges of the friction polygon")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(whole_number())
      ->type_name("N1,N2,...");
  command
      ->add_option("--envelope", request.envelope,
                   "K step counts a level, spread over [n, 1.25 n]; the largest error counts")
      ->transform(whole_number())
      ->type_name("K");
  command->add_option("--velocity", arguments->velocity, "error_v: end (at T), l1 or graph (over the run)")
      ->type_name("MEASURE");
  command->add_flag(
      "--over-run", request.over_run,
      "error_path and error_p too: the largest errors of configuration and of impulses over the run");
  command
      ->add_option("--reference", arguments->reference,
                   "what errors are counted from: exact, event, extrapolated or own-limit; exact where it is "
                   "known, else "
                   "event, if not given")
      ->check(some_text())
      ->type_name("R");
  command
      ->add_option(
          "--map", arguments->maps,
          "twice: a parameter of the scene, or h (the step), over which to map what the methods come to")
      ->type_name("NAME=LO:HI:N")
      ->expected(1)
      ->take_all();
  command
      ->add_option("--out", arguments->folder,
                   "folder for tables, charts and the page; an earlier study there goes on")
      ->check(some_text())
      ->required();
  command->add_option("--budget", options.budget, "wall-clock seconds, after which no run begins")
      ->check(finite_number())
      ->check(CLI::NonNegativeNumber)
      ->type_name("S");
  command->add_option("--jobs", options.jobs, "runs at a time")->transform(whole_number())->type_name("N");
  command->add_option("--shard", arguments->shard, "make part I of N alone, for --merge")->type_name("I/N");
  command->add_option("--merge", arguments->merge, "folders of the shards to put together")
      ->type_name("DIR...");
  command->add_flag("--view", arguments->view,
                    "the motion of every scene too, which the page links to (perp view)");
  add_sweep_options(*command, arguments->sweep);
  command->callback([&status, command, arguments] { status = study(*command, *arguments); });
}

}  // namespace perp
