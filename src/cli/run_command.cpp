// perp run: one scene under one method, its motion into files.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/reduced_system.hpp"
#include "perp/io/run_files.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

struct RunArguments {
  std::string scene, method, folder;
  double h = not_set, until = not_set;
  bool step_given = false;
  int every = 1;
  double tolerance = not_set, look = not_set;
  std::string integrator, reactions = "any";
  bool assemble = false;
  MethodOptions method_options;
  std::vector<std::string> set;
};

/// What the user looks at first: how far it came, how well the steps' equations hold, what did not go into them.
void summarise(const Scene& scene, const Stepper& stepper, const Trajectory& run, const std::string& folder) {
  double residual = 0, gap = infinity, joint_error = 0;
  for (std::size_t i = 0; i < run.steps(); ++i) {
    const StepFigures& f = run.figures(i);
    residual = std::max({residual, f.residuals.normal, f.residuals.friction});
    gap = std::min(gap, f.gap_min);
    joint_error = std::max(joint_error, f.joint_error);
  }
  std::printf("%s by %s: %zu steps to t = %s s\n", scene.name.c_str(), std::string(stepper.name()).c_str(),
              run.steps(), shortest(run.t(run.size() - 1)).c_str());
  std::printf("largest contact residual %.1e m/s, smallest gap %.1e m, largest joint error %.1e\n", residual,
              gap, joint_error);
  if (run.evaluations > 0)
    std::printf("%zu events, %ld evaluations of the right-hand side\n", run.events.size(), run.evaluations);
  if (run.unseen > 0)
    std::printf("loads that do not say when they jump were looked at every %.2g s (--look)\n", run.unseen);
  if (run.carried_error > 0)
    std::printf("steps were carried across, which are first-order: off by about %.1e together\n",
                run.carried_error);
  if (!scene.model.joints().empty()) {
    Instant start;
    evaluate(scene.model, run.front(), start);
    std::printf("%zu joint equations of rank %d\n", start.joint_rows.size(), joint_rank(scene.model, start));
  }
  if (!scene.unused.empty())
    std::printf("%zu things of the file are not used: perp check lists them\n", scene.unused.size());
  std::printf("wrote trajectory.csv, contacts.csv, joints.csv%s and report.csv to %s\n",
              (run.between || !run.events.empty()) ? ", events.csv" : "", folder.c_str());
}

/// The method with what was asked for it; a method of fixed steps needs one, another may have a tolerance.
std::unique_ptr<Stepper> stepper_of(const RunArguments& arguments) {
  MethodOptions options = arguments.method_options;
  const bool chooses = method(arguments.method).adaptive;
  if (!chooses && !arguments.step_given)
    refuse("perp run", "--step", "not given", "method " + arguments.method + " needs a step [s]");
  if (!chooses && !std::isnan(arguments.tolerance))
    refuse("perp run", "--tolerance", arguments.tolerance, "needs a method that chooses its steps: event");
  if (arguments.step_given && !(arguments.h > 0))
    refuse("perp run", "--step, h,", arguments.h, "needs to be positive [s]");
  if (!std::isnan(arguments.tolerance)) options.tolerance = arguments.tolerance;
  if (!arguments.integrator.empty()) {
    if (arguments.method != "event")
      refuse("perp run", "--integrator", arguments.integrator, "needs the method event");
    options.integrator = integrator_named(arguments.integrator);
  }
  if (!std::isnan(arguments.look)) {
    if (!chooses)
      refuse("perp run", "--look", arguments.look, "needs a method that chooses its steps: event");
    options.look = arguments.look;
  }
  if (arguments.reactions == "minimum-norm") {
    if (chooses)
      refuse("perp run", "--reactions", arguments.reactions, "needs a method of steps of fixed size");
    options.reactions = Reactions::MinimumNorm;
  }
  return make_stepper(arguments.method, options);
}

int run_scene(const RunArguments& arguments) {
  const Scene s = load_scene(arguments.scene, read_parameters("perp run", arguments.set));
  const std::unique_ptr<Stepper> stepper = stepper_of(arguments);
  State start = s.start;
  if (arguments.assemble) {
    const Projection found = project_onto_constraints(s.model, start);
    if (found.reached)
      std::printf("assembly moved the start by %.6g m or rad and %.6g m/s or rad/s\n", found.moved,
                  found.moved_velocity);
    else
      refuse("perp run", "--assemble", "not possible", "no consistent start is near (perp check says more)");
  }
  const double until = std::isnan(arguments.until) ? s.t_end : arguments.until;
  try {
    const Trajectory run =
        simulate(s.model, *stepper, start,
                 {.t_end = until,
                  .h = arguments.h,
                  .events = load_events(arguments.scene, read_parameters("perp run", arguments.set))});
    write_run(arguments.folder, s.model, run, {.every = arguments.every});
    summarise(s, *stepper, run, arguments.folder);
    return Done;
  } catch (const StepFailure& failure) {
    write_run(arguments.folder, s.model, failure.trajectory,
              {.every = arguments.every, .failed = &failure.report});
    summarise(s, *stepper, failure.trajectory, arguments.folder);
    std::fprintf(stderr, "perp: %s: %s\n", s.name.c_str(), failure.what());
    return ToleranceNotReached;
  }
}

}  // namespace

void add_run_command(CLI::App& perp, int& status) {
  CLI::App* command = perp.add_subcommand("run", "Run a scene by a method and write its motion to files");
  const auto arguments = std::make_shared<RunArguments>();
  command
      ->add_option("SCENE", arguments->scene,
                   "a scene file, a robot (.urdf), or a built-in scene (perp scenes)")
      ->required();
  command->add_option("--method", arguments->method, "a method (perp methods)")->required();
  command->add_option(
      "--step", arguments->h,
      "step h [s]; the run takes round(T/h) equal steps. Of event: rows at its multiples too");
  command->add_option("--tolerance", arguments->tolerance, "rtol = atol of event; 1e-10 if not given")
      ->type_name("R");
  command
      ->add_option("--integrator", arguments->integrator, "of event: arkode, cvode-adams, cvode-bdf or ida")
      ->type_name("I");
  command->add_option(
      "--look", arguments->look,
      "of event: longest time between two looks at loads that change with time [s]; T/4096 if not given");
  command->add_option("--until", arguments->until, "end time T [s]; the scene's own if not given");
  command->add_option("--out", arguments->folder, "folder for trajectory.csv, contacts.csv, report.csv")
      ->required();
  command->add_flag("--assemble", arguments->assemble,
                    "begin at the nearest start that joints and gaps allow");
  command->add_option("--every", arguments->every, "write the steps K, 2 K, ... and the last")
      ->type_name("K");
  command->add_option("--edges", arguments->method_options.edges, "edges of the friction polygon")
      ->type_name("N");
  command
      ->add_option("--reactions", arguments->reactions,
                   "any, or minimum-norm: of redundant contacts and joints those that share what they carry")
      ->check(CLI::IsMember({"any", "minimum-norm"}));
  command->add_option("--set", arguments->set, "a parameter of the scene, repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command->callback([&status, arguments, command] {
    arguments->step_given = command->count("--step") > 0;
    status = run_scene(*arguments);
  });
}

}  // namespace perp
