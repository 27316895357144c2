// What a run is made of: all that run.json keeps, and all that `perp run --resume` needs.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "perp/step/methods.hpp"
#include "perp/study/scene.hpp"

namespace perp {

struct RunRecipe {
  std::string scene;       ///< a built-in name or a file, as given
  std::string scene_text;  ///< of the file; of a built-in scene as a file says it, empty where none can
  std::map<std::string, std::string> included = {};  ///< texts of files that the file includes, by path
  std::string folder;                                ///< from which files are named
  SceneParameters set = {};                          ///< parameters given
  std::string method;
  MethodOptions options = {};
  double step = not_set, until = not_set;  ///< [s]
  double accuracy = not_set;               ///< [m, rad]; the step or the tolerance are chosen for it
  int every = 1;
  bool assemble = false, allow_overlap = false;
  std::string format = "csv";
};

/// How a run stands, as run.json says it.
struct RunRecord {
  RunRecipe recipe;
  std::vector<std::string> command;
  SceneParameters parameters;  ///< in force
  std::string version, build, machine;
  std::string start, end;  ///< UTC; empty: not yet
  int exit_status = -1;    ///< -1: not yet
  std::string ended;       ///< why, one sentence
};

[[nodiscard]] std::string write_record(const RunRecord& record);
/// Throws std::invalid_argument "FILE:LINE:COLUMN: what was found, what is allowed".
[[nodiscard]] RunRecord read_record(const std::string& text, const std::string& file);

/// The scene that a recipe names: reads its file, and the files included there, and keeps their texts in it.
[[nodiscard]] Scene read_scene_of(RunRecipe& recipe);
/// The same scene again, from the texts that the recipe keeps.
[[nodiscard]] Scene make_scene(const RunRecipe& recipe);

/// A scene as a file says it; empty where no file can.
[[nodiscard]] std::string text_of(const Scene& scene);

// What a run's bytes depend on, as fingerprints.
[[nodiscard]] std::string scene_mark(const RunRecipe& recipe);
[[nodiscard]] std::string method_mark(const RunRecipe& recipe);

}  // namespace perp
