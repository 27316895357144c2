// perp scenes: the built-in scenes, their default end time and parameters; each as a scene file.
#include <cstdio>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"

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

/// Those that know the scene's friction: of most scenes all.
std::string methods_of(const Scene& scene) {
  std::string names;
  for (const Method& method : methods())
    if (method.make({})->knows(scene.model)) names += (names.empty() ? "" : " ") + std::string(method.name);
  return names;
}

void print_all_csv() {
  std::printf("name,id,until,exact,methods,parameters\n");
  for (const std::string& name : scene_names()) {
    const Scene s = scene(name);
    std::printf("%s,%s,%s,%s,%s,%s\n", s.name.c_str(), s.id.c_str(), shortest(s.t_end).c_str(),
                s.exact ? "yes" : "no", methods_of(s).c_str(), settings(s).c_str());
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
  struct Arguments {
    std::string scene;
    bool csv = false, toml = false;
    std::vector<std::string> set;
  };
  CLI::App* command = perp.add_subcommand(
      "scenes", "List the built-in scenes: default end time and parameters; or print one as a scene file");
  const auto arguments = std::make_shared<Arguments>();
  CLI::Option* name =
      command->add_option("SCENE", arguments->scene, "a built-in scene, a scene file or a robot (.urdf)");
  CLI::Option* toml =
      command->add_flag("--toml", arguments->toml, "print SCENE as a scene file")->needs(name);
  command->add_flag("--csv", arguments->csv, "as CSV: name,id,until,exact,methods,parameters")
      ->excludes(name);
  command->add_option("--set", arguments->set, "a parameter of SCENE, repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all()
      ->needs(toml);
  name->needs(toml);
  command->callback([&status, arguments] {
    if (arguments->toml) {
      const Scene s = load_scene(arguments->scene, read_parameters("perp scenes", arguments->set));
      std::fputs(write_scene(s).c_str(), stdout);
    } else {
      arguments->csv ? print_all_csv() : print_list();
    }
    status = Done;
  });
}

}  // namespace perp
