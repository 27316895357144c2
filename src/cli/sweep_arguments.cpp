#include "cli/sweep_arguments.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "cli/parameters.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/sweep.hpp"

namespace perp {
namespace {

/// NAME=LO:HI:N, of a drawn one NAME=LO:HI.
SweepAxis read_axis(const char* option, const std::string& text, bool drawn) {
  const auto fail = [&] {
    refuse("perp study", option, text,
           drawn ? "needs to be NAME=LO:HI with LO below HI"
                 : "needs to be NAME=LO:HI:N with LO no higher than HI");
  };
  const std::size_t equals = text.find('=');
  SweepAxis axis{.name = text.substr(0, equals), .drawn = drawn};
  if (equals == std::string::npos || equals == 0) fail();
  const char* at = text.data() + equals + 1;
  const char* const end = text.data() + text.size();
  const auto take = [&](auto& value, bool last) {
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc() || (last ? read.ptr != end : read.ptr == end || *read.ptr != ':')) fail();
    at = read.ptr + 1;
  };
  take(axis.low, false);
  take(axis.high, drawn);
  if (!drawn) take(axis.n, true);
  const bool range = drawn ? axis.low < axis.high : axis.low <= axis.high && axis.n >= 1;
  if (!std::isfinite(axis.low) || !std::isfinite(axis.high) || !range) fail();
  return axis;
}

int report(const SweepOutcome& outcome, const std::string& folder, bool shard) {
  std::printf("%ld runs: %ld made now, %ld found there, %ld failed\n", outcome.planned, outcome.made,
              outcome.before, outcome.failed);
  if (shard)
    std::printf("wrote the runs of a shard to %s: perp study --merge makes the tables\n", folder.c_str());
  else
    std::printf("wrote sweep.csv and its picture to %s\n", folder.c_str());
  if (!outcome.no_pictures.empty())
    std::fprintf(stderr, "perp: no picture: %s; its data and script are there\n",
                 outcome.no_pictures.c_str());
  if (outcome.failed > 0) std::fprintf(stderr, "perp: %ld runs failed: sweep.csv says why\n", outcome.failed);
  if (outcome.left() > 0)
    std::fprintf(stderr, "perp: %ld runs are left: the same command goes on with them\n", outcome.left());
  return outcome.failed > 0 || outcome.left() > 0 ? ToleranceNotReached : Done;
}

}  // namespace

void add_sweep_options(CLI::App& command, SweepArguments& arguments) {
  command
      .add_option("--sweep", arguments.sweep,
                  "a sweep instead of a study: N values of a parameter, repeatable; all combinations are run")
      ->type_name("NAME=LO:HI:N")
      ->expected(1)
      ->take_all();
  command.add_option("--draw", arguments.draw, "of a sweep: a parameter drawn at random, repeatable")
      ->type_name("NAME=LO:HI")
      ->expected(1)
      ->take_all();
  command.add_option("--draws", arguments.draws, "of a sweep: draws for each combination")
      ->transform(whole_number())
      ->type_name("N");
  command.add_option("--seed", arguments.seed, "of a sweep: of what is drawn")
      ->transform(whole_number())
      ->type_name("N");
  command
      .add_option("--ask", arguments.ask,
                  "of a sweep, repeatable: an expression at the run's end (BODY.x), or time:EVENT, when an "
                  "event of that "
                  "name or kind came first")
      ->type_name("WHAT")
      ->expected(1)
      ->take_all();
  command
      .add_option("--pass", arguments.pass,
                  "of a sweep: A > B or A < B at the run's end; the share of runs that pass")
      ->check(some_text())
      ->type_name("TEST");
}

int run_sweep_command(const CLI::App& command, const SweepArguments& arguments, const StudyRequest& study,
                      const StudyOptions& options, const std::string& folder) {
  for (const char* option : {"--envelope", "--velocity"})
    if (command.count(option) > 0)
      refuse("perp study", option, "given beside --sweep", "needs a study of errors");
  if (study.scenes.size() != 1)
    refuse("perp study", "SCENE", std::to_string(study.scenes.size()) + " scenes",
           "needs one beside --sweep");
  if (study.steps.size() > 1)
    refuse("perp study", "--steps", study.steps[1], "needs one step beside --sweep");
  if (study.edges.size() > 1)
    refuse("perp study", "--edges", double(study.edges[1]), "needs one number beside --sweep");
  if (command.count("--tolerances") > 0 && study.tolerances.size() > 1)
    refuse("perp study", "--tolerances", study.tolerances[1], "needs one tolerance beside --sweep");
  if (arguments.draws < 1 || arguments.draws > 1'000'000'000)
    refuse("perp study", "--draws", std::to_string(arguments.draws), "needs to be in 1 ... 1e9");
  if (arguments.seed < 0)
    refuse("perp study", "--seed", std::to_string(arguments.seed), "needs to be 0 or more");
  SweepRequest request{.scene = study.scenes.front(), .methods = study.methods, .axes = {}};
  if (!study.steps.empty()) request.step = study.steps.front();
  if (command.count("--tolerances") > 0) request.tolerance = study.tolerances.front();
  request.until = study.until;
  request.edges = study.edges.front();
  request.set = study.set;
  for (const std::string& text : arguments.sweep) request.axes.push_back(read_axis("--sweep", text, false));
  for (const std::string& text : arguments.draw) request.axes.push_back(read_axis("--draw", text, true));
  request.draws = static_cast<int>(arguments.draws);
  request.seed = static_cast<unsigned long long>(arguments.seed);
  request.ask = arguments.ask;
  request.pass = arguments.pass;
  return report(run_sweep(request, folder, options), folder, options.shards > 1);
}

int merge_sweep_command(const std::vector<std::string>& folders, const std::string& folder) {
  return report(merge_sweeps({folders.begin(), folders.end()}, folder), folder, false);
}

}  // namespace perp
