// perp fit: parameters of a scene from measured motions.
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/fit_files.hpp"
#include "perp/io/measured_file.hpp"
#include "perp/io/scene_file.hpp"

namespace perp {
namespace {

struct FitArguments {
  FitProblem problem;
  std::string scene, folder;
  std::vector<std::string> data, predict, free, set;
  long long seed = 1;
};

/// NAME or NAME=LO:HI.
FreeQuantity read_free(const std::string& text) {
  constexpr const char* need = "needs to be NAME or NAME=LO:HI with LO below HI";
  FreeQuantity free{.name = text.substr(0, text.find('='))};
  if (free.name.empty()) refuse("perp fit", "--free", text, need);
  if (free.name.size() == text.size()) return free;
  const char* const end = text.data() + text.size();
  const auto low = std::from_chars(text.data() + free.name.size() + 1, end, free.low);
  if (low.ec != std::errc() || low.ptr == end || *low.ptr != ':') refuse("perp fit", "--free", text, need);
  const auto high = std::from_chars(low.ptr + 1, end, free.high);
  if (high.ec != std::errc() || high.ptr != end || !std::isfinite(free.low) || !std::isfinite(free.high) ||
      !(free.low < free.high))
    refuse("perp fit", "--free", text, need);
  return free;
}

std::vector<MeasuredMotion> read_all(const std::vector<std::string>& files, std::set<std::string>& names) {
  std::vector<MeasuredMotion> motions;
  for (const std::string& file : files) {
    motions.push_back(read_measured(file));
    // two files of one name, in two folders, are told apart by a number
    const std::string stem = motions.back().name;
    for (int n = 2; !names.insert(motions.back().name).second; ++n)
      motions.back().name = stem + "-" + std::to_string(n);
  }
  return motions;
}

int fit_scene(const CLI::App& command, FitArguments& arguments) {
  FitProblem& problem = arguments.problem;
  for (const std::string& text : arguments.free) problem.free.push_back(read_free(text));
  problem.set = read_parameters("perp fit", arguments.set);
  const Method& chosen = method(problem.method);
  if (chosen.adaptive && command.count("--step") > 0)
    refuse("perp fit", "--step", problem.h, "needs a method of steps of fixed size");
  if (!chosen.adaptive && command.count("--tolerance") > 0)
    refuse("perp fit", "--tolerance", problem.options.tolerance,
           "needs a method that chooses its steps: event");
  if (arguments.seed < 0 || arguments.seed > 4294967295)
    refuse("perp fit", "--seed", std::to_string(arguments.seed), "needs to be in 0 ... 4294967295");
  problem.seed = static_cast<unsigned>(arguments.seed);
  const bool file = is_scene_file(arguments.scene) && !arguments.scene.ends_with(".urdf");
  const std::string text = file ? scene_text(arguments.scene) : std::string();
  problem.scene = [&, file](const SceneParameters& set) {
    return file ? read_scene(text, arguments.scene, set) : load_scene(arguments.scene, set);
  };
  (void)problem.scene(problem.set);  // refuses the scene before anything is read
  std::set<std::string> names;
  problem.measured = read_all(arguments.data, names);
  problem.held_back = read_all(arguments.predict, names);
  const FitResult result = fit(problem);
  const std::string no_picture = write_fit(result, arguments.folder);
  std::fputs(summary_of(result).c_str(), stdout);
  std::printf("wrote fit.csv, residuals.csv, prediction.csv and fit.html to %s\n", arguments.folder.c_str());
  if (!no_picture.empty()) std::fprintf(stderr, "perp: no picture: %s\n", no_picture.c_str());
  if (result.status == FitStatus::Converged) return Done;
  std::fprintf(stderr, "perp: %s: the fit %s\n", arguments.scene.c_str(), result.message.c_str());
  return ToleranceNotReached;
}

}  // namespace

void add_fit_command(CLI::App& perp, int& status) {
  CLI::App* command = perp.add_subcommand("fit", "Find a scene's parameters from measured motions");
  const auto arguments = std::make_shared<FitArguments>();
  FitProblem& problem = arguments->problem;
  command->add_option("SCENE", arguments->scene, "a scene file, a robot (.urdf), or a built-in scene")
      ->check(some_text())
      ->required();
  command
      ->add_option(
          "--data", arguments->data,
          "measured motions: CSV, t first, any of trajectory.csv's columns, an empty cell is not measured")
      ->type_name("FILE...")
      ->check(some_text())
      ->required();
  command
      ->add_option("--free", arguments->free,
                   "what may change, within bounds: the scene's parameters, BODY.x ... of the start "
                   "(BODY.start: all of "
                   "it), clock.offset, clock.rate, frame.x ... frame.rz, frame.scale")
      ->delimiter(',')
      ->type_name("NAME[=LO:HI],...")
      ->check(some_text())
      ->required();
  command
      ->add_option("--hold-back", problem.hold_back,
                   "share of the files (of one file its last rows) to predict")
      ->check(finite_number())
      ->type_name("SHARE");
  command->add_option("--predict", arguments->predict, "files to predict")
      ->type_name("FILE...")
      ->check(some_text());
  command->add_option("--seed", arguments->seed, "of what is held back, and of the search")
      ->transform(whole_number())
      ->type_name("N");
  command->add_option("--method", problem.method, "a method (perp methods); ncp2 if not given")
      ->check(some_text());
  command
      ->add_option("--step", problem.h, "step h [s]; a sixteenth of the data's median interval if not given")
      ->check(finite_number());
  command->add_option("--tolerance", problem.options.tolerance, "rtol = atol of event; 1e-10 if not given")
      ->check(finite_number())
      ->type_name("R");
  command
      ->add_option("--set", arguments->set, "a parameter of the scene, where the fit starts from, repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command->add_option("--search", problem.search_runs, "runs for the derivative-free search at most; 0: none")
      ->transform(whole_number())
      ->type_name("N");
  command->add_flag("--starts-first", problem.starts_first,
                    "each file's own quantities from its rows before the first contact, and kept");
  command->add_option("--jobs", problem.jobs, "threads")->transform(whole_number())->type_name("N");
  command
      ->add_option("--out", arguments->folder, "folder for fit.csv, residuals.csv, prediction.csv, fit.html")
      ->check(some_text())
      ->required();
  command->callback([&status, command, arguments] { status = fit_scene(*command, *arguments); });
}

}  // namespace perp
