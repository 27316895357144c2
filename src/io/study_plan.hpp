// A study's request made definite: which runs there are, in which order, each with a key of its own.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "perp/io/study_folder.hpp"
#include "perp/step/methods.hpp"

namespace perp {

/// One curve of a chart: a method with what was chosen for it.
struct StudyLine {
  const Method* method = nullptr;
  MethodOptions options = {};
  SceneParameters settings = {};

  std::unique_ptr<Stepper> stepper() const { return method->make(options); }
  /// The same, of a method that chooses its steps at this tolerance, with what the scene sets of the method, and the study over that.
  std::unique_ptr<Stepper> stepper(const Scene& scene, double tolerance) const {
    MethodOptions chosen = options;
    apply_method_settings(scene, method->name, chosen);
    for (const auto& [key, value] : settings) chosen.set(method->name, key, value);
    if (!std::isnan(tolerance)) chosen.tolerance = tolerance;
    return method->make(chosen);
  }
};

struct PlannedRun {
  std::size_t scene = 0, line = 0;
  int level = 0, n = 0;        ///< n is 1 of methods that choose their steps
  double tolerance = not_set;  ///< theirs
  int shard = 0;               ///< from 0, of the number asked for
  std::string key = {};  ///< the same for the same run in any study: of the same scene, settings and version
};

struct StudyPlan {
  std::vector<ScenePlan> scenes;
  std::vector<StudyLine> lines;
  std::vector<PlannedRun> runs;  ///< in the order of study.csv
};

/// Throws std::invalid_argument for what cannot be run. Shards take the runs of a line in turn, each line beginning with
/// another one, so that none gets all small steps.
[[nodiscard]] StudyPlan plan_study(const StudyRequest& request, int shards = 1,
                                   const TimingOptions& timing = {});

/// The request as text, a line "WORD VALUE" for each thing asked, and back. Files are named by their whole path.
[[nodiscard]] std::string write_request(const StudyRequest& request);
[[nodiscard]] StudyRequest read_request(const std::filesystem::path& file);

}  // namespace perp
