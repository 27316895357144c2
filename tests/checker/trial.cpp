#include "trial.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "energy.hpp"
#include "perp/io/run_files.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"

namespace checker {
namespace {

std::string by_program(const std::string& method, double h, double until, const TrialOptions& options) {
  const std::string scene = options.folder + "/scene.toml", out = options.folder + "/out";
  std::string command = "timeout " + std::to_string(options.patience) + " " + options.program + " run " +
                        scene + " --method " + method;
  if (method != "event") command += " --step " + digits(h);
  command += " --until " + digits(until) + " --out " + out + " 2>&1 >/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  std::string said;
  std::array<char, 512> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) said += buffer.data();
  const int status = WEXITSTATUS(pclose(pipe));
  if (status == 0) return "";
  if (status == 1) return said;
  std::filesystem::remove(out + "/report.csv");
  if (status == 124) return "takes longer than " + std::to_string(options.patience) + " s";
  return "mistake: " + std::to_string(status) + " " + said;
}

std::string in_process(const std::string& text, const std::string& method, double h, double until,
                       const std::string& out) {
  try {
    const perp::Scene scene = perp::read_scene(text, "scene.toml");
    const std::unique_ptr<perp::Stepper> stepper =
        method == "event" ? std::make_unique<perp::EventDriven>(
                                perp::EventDrivenOptions{.rtol = 1e-10, .max_evaluations = 10'000})
                          : perp::make_stepper(method);
    try {
      perp::SimulateOptions options{.t_end = until};
      if (method != "event") options.h = h;
      perp::write_run(out, scene.model, perp::simulate(scene.model, *stepper, scene.start, options),
                      {.halves = stepper->halves()});
      return "";
    } catch (const perp::StepFailure& failure) {
      perp::write_run(out, scene.model, failure.trajectory,
                      {.failed = &failure.report, .halves = stepper->halves()});
      return failure.what();
    }
  } catch (const std::invalid_argument& mistake) {
    return std::string("mistake: ") + mistake.what();
  }
}

/// In a child of this process, so that a step that takes for ever or ends the program is one refusal and no more.
std::string apart(const std::string& text, const std::string& method, double h, double until,
                  const TrialOptions& options) {
  const std::string out = options.folder + "/out", said = options.folder + "/said";
  std::filesystem::remove(said);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    // its own time, so that a busy machine refuses no more than an idle one; and of the clock, should it sleep
    const rlimit most{options.patience, options.patience + 1};
    setrlimit(RLIMIT_CPU, &most);
    alarm(20 * options.patience);
    std::string reason;
    try {
      reason = in_process(text, method, h, until, out);
    } catch (const std::exception& error) {
      reason = std::string("mistake: ") + error.what();
    }
    std::ofstream(said) << reason;
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) {
    std::filesystem::remove(out + "/report.csv");
    if (WTERMSIG(status) == SIGALRM || WTERMSIG(status) == SIGXCPU)
      return "takes longer than " + std::to_string(options.patience) + " s";
    return "mistake: ends by the signal " + std::to_string(WTERMSIG(status));
  }
  std::ifstream file(said);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string run_scene(const std::string& text, const std::string& method, double h, double until,
                      const TrialOptions& options) {
  const std::string out = options.folder + "/out";
  std::filesystem::create_directories(out);
  for (const char* name : {"trajectory.csv", "contacts.csv", "joints.csv", "report.csv"})
    std::filesystem::remove(out + "/" + name);
  std::ofstream(options.folder + "/scene.toml") << text;
  return options.program.empty() ? apart(text, method, h, until, options)
                                 : by_program(method, h, until, options);
}

Trial try_scene(const RandomScene& random, const std::string& method, const TrialOptions& options) {
  Trial trial;
  const std::string text = text_of(random.scene);
  trial.reason = run_scene(text, method, random.h, random.until(), options);
  if (!trial.reason.empty()) trial.ending = Ending::Refused;
  if (trial.reason.starts_with("mistake: ")) {
    trial.ending = Ending::Mistake;
    return trial;
  }
  if (!std::filesystem::exists(options.folder + "/out/report.csv")) return trial;
  try {
    const Scene scene = read_scene(options.folder + "/scene.toml");
    const Run run = read_run(scene, options.folder + "/out");
    trial.judgement = judge(scene, run, method);
    if (options.energy && options.program.empty()) judge_energy(scene, run, method, options, trial);
  } catch (const std::exception& error) {
    trial.ending = Ending::Unjudged;
    trial.reason = error.what();
  }
  return trial;
}

}  // namespace checker
