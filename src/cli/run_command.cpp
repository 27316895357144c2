// perp run: one scene under one method, its motion into files as it goes on; or a run that was interrupted, to its end.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "cli/run_job.hpp"
#include "cli/view_page.hpp"
#include "io/machine.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/auto_method.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

struct RunArguments {
  RunRecipe recipe;
  RunManner manner;
  std::string folder, resume, integrator, reactions = "any", impacts = "simultaneous";
  std::vector<std::string> set, set_method, command;
};

/// The method's options. What a method does not use is refused: it would be taken for used.
void read_method(const CLI::App& command, const RunArguments& arguments, RunRecipe& recipe) {
  const Method& chosen = method(recipe.method);
  const auto given = [&](const char* option) { return command.count(option) > 0; };
  const bool chooses = chosen.adaptive;
  if (given("--accuracy")) {
    if (!(recipe.accuracy > 0))
      refuse("perp run", "--accuracy", recipe.accuracy, "needs to be positive [m, rad]");
    for (const char* other : {"--step", "--tolerance", "--order"})
      if (given(other))
        refuse("perp run", other, "given beside --accuracy",
               "needs to be left out: the accuracy decides on step and tolerance");
  }
  if (!chooses && !given("--step") && !given("--accuracy"))
    refuse("perp run", "--step", "not given", "method " + recipe.method + " needs a step [s]");
  if (!chooses && given("--tolerance"))
    refuse("perp run", "--tolerance", recipe.options.tolerance,
           "needs a method that chooses its steps: event or extrapolated");
  if (given("--order")) {
    const auto order = static_cast<double>(recipe.options.order);
    if (recipe.method != "extrapolated")
      refuse("perp run", "--order", order, "needs the method extrapolated");
    if (recipe.options.order == 0) refuse("perp run", "--order", order, "needs to be 2, 4, 6, 8 or more");
    if (!given("--step") || given("--tolerance"))
      refuse("perp run", "--order", order, "needs --step, and no --tolerance, which chooses the order");
  }
  if (given("--step") && !(recipe.step > 0))
    refuse("perp run", "--step, h,", recipe.step, "needs to be positive [s]");
  if (given("--edges") && !chosen.polygonal)
    refuse("perp run", "--edges", static_cast<double>(recipe.options.edges),
           "needs a method with a friction polygon, lcp or lcp-ap: " + recipe.method + " has circular cones");
  if (given("--integrator")) {
    if (recipe.method != "event")
      refuse("perp run", "--integrator", arguments.integrator, "needs the method event");
    recipe.options.integrator = integrator_named(arguments.integrator);
  }
  if (given("--look")) {
    if (!chooses)
      refuse("perp run", "--look", recipe.options.look,
             "needs a method that chooses its steps: event or extrapolated");
    if (!(recipe.options.look > 0))
      refuse("perp run", "--look", recipe.options.look, "needs to be positive [s]");
  }
  recipe.options.impacts = impact_order_named(arguments.impacts);
  if (given("--impacts") && !chooses)
    refuse("perp run", "--impacts", arguments.impacts,
           "needs a method that locates impacts, event or extrapolated: others take all of a step at once");
  if (arguments.reactions == "minimum-norm") {
    if (chooses)
      refuse("perp run", "--reactions", arguments.reactions, "needs a method of steps of fixed size");
    recipe.options.reactions = Reactions::MinimumNorm;
  }
}

/// T and h, which the scene's start decides on.
void check_times(const Scene& scene, RunRecipe& recipe) {
  if (std::isnan(recipe.until)) recipe.until = scene.t_end;
  const double length = recipe.until - scene.start.t;
  if (!(length > 0))
    refuse("perp run", "--until", recipe.until, "needs to be past the start, t = " + shortest(scene.start.t));
  constexpr double digits = 1.01;  // an end written with fewer digits than the step is still one step
  if (recipe.step > digits * length)
    refuse("perp run", "--step", recipe.step,
           "needs to be no longer than the run, " + shortest(length) + " s");
  constexpr double most = 1e12;  // steps: a year at 30 us
  if (length / recipe.step > most)
    refuse("perp run", "--step", recipe.step, "needs " + shortest(most) + " steps at most to the end");
  if (recipe.every < 1)
    refuse("perp run", "--every", static_cast<double>(recipe.every), "needs to be 1 or more");
}

/// The page is made from the tables.
void need_tables(const RunRecipe& recipe) {
  if (recipe.format != "csv")
    refuse("perp run", "--view", "given beside --format " + recipe.format, "needs --format csv");
}

int new_run(const CLI::App& command, RunArguments& arguments) {
  RunRecord record;
  RunRecipe& recipe = record.recipe;
  recipe = arguments.recipe;
  if (arguments.manner.view) need_tables(recipe);
  for (const char* needed : {"SCENE", "--method", "--out"})
    if (command.count(needed) == 0)
      refuse("perp run", needed, "not given", "needs to be there, or --resume OUT alone");
  recipe.folder = std::filesystem::current_path().string();
  recipe.set = read_parameters("perp run", arguments.set);
  const Scene scene = read_scene_of(recipe);
  for (const SceneParameter& p : scene.parameters) record.parameters[p.name] = p.value;
  if (recipe.method == "auto") {
    const MethodChoice choice = choose_method(scene.model, command.count("--step") > 0);
    recipe.method = choice.method;
    if (!arguments.manner.quiet) std::printf("auto: %s: %s\n", recipe.method.c_str(), choice.why.c_str());
  }
  read_method(command, arguments, recipe);
  apply_method_settings(scene, recipe.method, recipe.options);
  for (const auto& [key, value] : read_parameters("perp run", arguments.set_method, "--set-method"))
    recipe.options.set(recipe.method, key, value);
  check_times(scene, recipe);
  record.command = arguments.command;
  record.version = version;
  record.build = build();
  record.machine = computer();
  return run_into(arguments.folder, record, scene, arguments.manner, false);
}

/// The scene that OUT's run.json keeps. Refuses it where its file, or the built-in scene, is another one now.
Scene scene_again(const RunRecipe& recipe, const std::string& folder) {
  if (!is_scene_file(recipe.scene)) {
    Scene scene = make_scene(recipe);
    if (text_of(scene) != recipe.scene_text)
      refuse("perp run", "--resume", folder, "the scene " + recipe.scene + " is no longer that of the run");
    return scene;
  }
  const auto compare = [&](const std::string& name, const std::string& text) {
    const std::filesystem::path file = std::filesystem::path(recipe.folder) / name;
    if (std::error_code none; std::filesystem::exists(file, none) && scene_text(file) != text)
      refuse("perp run", "--resume", folder,
             "the scene file " + file.string() + " is no longer that of the run");
  };
  compare(recipe.scene, recipe.scene_text);
  for (const auto& [name, text] : recipe.included) compare(name, text);
  return make_scene(recipe);
}

int resume(const CLI::App& command, const RunArguments& arguments) {
  for (const CLI::Option* option : command.get_options())
    if (option->count() > 0 && !option->check_lname("resume") && !option->check_lname("budget") &&
        !option->check_lname("quiet") && !option->check_lname("verbose") && !option->check_lname("view"))
      refuse("perp run", option->get_name(), "given beside --resume",
             "needs to be left out: the folder says what is run");
  const RunRecord record = RunFolder::record_in(arguments.resume);
  if (arguments.manner.view) need_tables(record.recipe);
  if (record.exit_status == Done) {
    if (arguments.manner.view)
      write_view({arguments.resume}, std::filesystem::path(arguments.resume) / "view.html",
                 arguments.manner.quiet);
    if (!arguments.manner.quiet)
      std::printf("the run in %s is complete: %s\n", arguments.resume.c_str(), record.ended.c_str());
    return Done;
  }
  const Scene scene = scene_again(record.recipe, arguments.resume);
  return run_into(arguments.resume, record, scene, arguments.manner, true);
}

void add_method_options(CLI::App* command, RunArguments& arguments) {
  RunRecipe& recipe = arguments.recipe;
  command->add_option("--method", recipe.method, "a method (perp methods), or auto")->check(some_text());
  command
      ->add_option("--step", recipe.step,
                   "step h [s]; the run takes round(T/h) equal steps. Of event, and of extrapolated without "
                   "--order: rows at its multiples too")
      ->check(finite_number());
  command
      ->add_option("--tolerance", recipe.options.tolerance,
                   "rtol = atol of event and extrapolated; 1e-10 if not given")
      ->check(finite_number())
      ->type_name("R");
  command
      ->add_option("--accuracy", recipe.accuracy,
                   "in place of step and tolerance: of positions [m] and angles [rad] at every row; "
                   "report.csv has error_estimate")
      ->check(finite_number())
      ->type_name("A");
  command
      ->add_option("--order", recipe.options.order,
                   "of extrapolated, with --step: 4, 6, 8, any even number from 2 to 16")
      ->transform(whole_number())
      ->type_name("K");
  command->add_option("--integrator", arguments.integrator, "of event: arkode, cvode-adams, cvode-bdf or ida")
      ->type_name("I");
  command
      ->add_option("--look", recipe.options.look,
                   "of event and extrapolated: longest time between two looks at loads that change with "
                   "time, and at the "
                   "scene's events [s]; T/4096 if not given")
      ->check(finite_number())
      ->type_name("S");
  command->add_option("--edges", recipe.options.edges, "edges of the friction polygon")
      ->transform(whole_number())
      ->type_name("N");
  command
      ->add_option("--set-method", arguments.set_method,
                   "a setting of the method, repeatable; of penalty stiffness, damping, slip_speed, explicit")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command
      ->add_option(
          "--impacts", arguments.impacts,
          "of event and extrapolated: simultaneous, or sequential: one pair of bodies after the other")
      ->check(CLI::IsMember({"simultaneous", "sequential"}));
  command
      ->add_option("--reactions", arguments.reactions,
                   "any, or minimum-norm: of redundant contacts and joints those that share what they carry")
      ->check(CLI::IsMember({"any", "minimum-norm"}));
}

}  // namespace

void add_run_command(CLI::App& perp, const std::vector<std::string>& command_line, int& status) {
  CLI::App* command = perp.add_subcommand("run", "Run a scene by a method and write its motion to files");
  const auto arguments = std::make_shared<RunArguments>();
  RunRecipe& recipe = arguments->recipe;
  RunManner& manner = arguments->manner;
  command
      ->add_option("SCENE", recipe.scene, "a scene file, a robot (.urdf), or a built-in scene (perp scenes)")
      ->check(some_text());
  add_method_options(command, *arguments);
  command->add_option("--until", recipe.until, "end time T [s]; the scene's own if not given")
      ->check(finite_number());
  command
      ->add_option("--out", arguments->folder,
                   "folder for run.json and the tables: trajectory, contacts, joints, report")
      ->check(some_text());
  command->add_flag("--assemble", recipe.assemble, "begin at the nearest start that joints and gaps allow");
  command->add_flag("--allow-overlap", recipe.allow_overlap,
                    "begin at the start as it is, whatever overlaps or is open there");
  command->add_option("--every", recipe.every, "write the steps K, 2 K, ... and the last")
      ->transform(whole_number())
      ->type_name("K");
  command->add_option("--format", recipe.format, "csv, or hdf5: the same tables and columns in OUT/run.h5")
      ->check(CLI::IsMember({"csv", "hdf5"}));
  command->add_option("--set", arguments->set, "a parameter of the scene, repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command->add_option("--resume", arguments->resume, "go on with the run in OUT that was interrupted")
      ->check(some_text())
      ->type_name("OUT");
  command->add_option("--budget", manner.budget, "wall-clock seconds, after which the run stops")
      ->check(finite_number())
      ->check(CLI::NonNegativeNumber)
      ->type_name("S");
  command->add_flag("--view", manner.view,
                    "when the run ends, write OUT/view.html too, the page that shows the motion (perp view)");
  command->add_flag("--quiet", manner.quiet, "print nothing but errors");
  command->add_flag("--verbose", manner.verbose, "print what the solver did in every step");
  command->callback([&status, arguments, command, command_line] {
    arguments->command = command_line;
    if (arguments->manner.quiet && arguments->manner.verbose)
      refuse("perp run", "--quiet", "given beside --verbose", "needs one of the two");
    status = arguments->resume.empty() ? new_run(*command, *arguments) : resume(*command, *arguments);
  });
}

}  // namespace perp
