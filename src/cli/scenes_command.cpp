// perp scenes: the built-in scenes, their default end time and parameters.
#include <cstdio>
#include <memory>
#include <string>

#include "cli/commands.hpp"
#include "perp/core/errors.hpp"
#include "perp/step/methods.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

/// "mu=0.2 radius=1"
std::string settings(const Scene& scene) {
  std::string text;
  for (const SceneParameter& parameter : scene.parameters) {
    text += (text.empty() ? "" : " ") + parameter.name + "=" + shortest(parameter.value);
  }
  return text;
}

void print_csv() {
  std::string methods;
  for (const Method& method : perp::methods())
    methods += (methods.empty() ? "" : " ") + std::string(method.name);
  std::printf("name,id,until,exact,methods,parameters\n");
  for (const std::string& name : scene_names()) {
    const Scene s = scene(name);
    std::printf("%s,%s,%s,%s,%s,%s\n", s.name.c_str(), s.id.c_str(), shortest(s.t_end).c_str(),
                s.exact ? "yes" : "no", methods.c_str(), settings(s).c_str());
  }
}

void print_list() {
  for (const std::string& name : scene_names()) {
    const Scene s = scene(name);
    std::printf("%-20s %s\n", s.name.c_str(), s.what.c_str());
    std::printf("%-20s %s, %s s, exact motion %s\n", "", s.id.c_str(), shortest(s.t_end).c_str(),
                s.exact ? "known" : "not known");
    for (const SceneParameter& p : s.parameters) {
      std::printf("%-20s   --set %s=%s  %s\n", "", p.name.c_str(), shortest(p.value).c_str(), p.what.c_str());
    }
  }
}

}  // namespace

void add_scenes_command(CLI::App& perp, int& status) {
  CLI::App* command =
      perp.add_subcommand("scenes", "List the built-in scenes: default end time and parameters");
  const auto csv = std::make_shared<bool>(false);
  command->add_flag("--csv", *csv, "as CSV: name,id,until,exact,methods,parameters");
  command->callback([&status, csv] {
    *csv ? print_csv() : print_list();
    status = Done;
  });
}

}  // namespace perp
