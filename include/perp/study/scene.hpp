// A scene: a model, where it starts, and what is known of its motion. Data, apart from any method.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "perp/model/model.hpp"
#include "perp/step/user_event.hpp"

namespace perp {

/// A number of a scene that a user may set: `perp run SCENE --set NAME=VALUE`.
struct SceneParameter {
  std::string name;
  double value = 0;  ///< in force, in SI units
  std::string what;  ///< meaning and unit, one phrase
};

struct Scene {
  std::string name;  ///< as in `perp run NAME`
  std::string id;    ///< of the reference collection, B1, C5, ...; empty for a user's file
  std::string what;  ///< one sentence
  Model model;
  State start;
  double t_end = 1;                    ///< [s] default length of a run
  std::vector<UserEvent> events = {};  ///< what a run looks out for: for SimulateOptions::events
  std::vector<SceneParameter> parameters;
  std::vector<std::string>
      unused;  ///< what of the file that it was read from does not enter, and where it stands

  /// The motion: a closed form, or the equations of motion in minimal coordinates integrated to round-off by means that share
  /// no code with the model. Empty where neither is known (or not for these parameters); q and nu are NaN at times past
  /// which it is not. Just after an impact if t is the time of one, but the start at t = 0.
  std::function<State(double t)> exact;

  /// What the scene sets of methods: [method.penalty] of its file, by name of the method and of the setting (MethodOptions::set).
  std::map<std::string, std::map<std::string, double>> method_settings = {};
};

struct MethodOptions;
/// The scene's settings of the method into `options`.
void apply_method_settings(const Scene& scene, std::string_view method, MethodOptions& options);

using SceneParameters = std::map<std::string, double, std::less<>>;

/// The built-in scene `name` with some parameters set. Throws std::invalid_argument for a name that is none (listing those
/// that are), a parameter that it does not have, or a value that it cannot take.
[[nodiscard]] Scene scene(std::string_view name, const SceneParameters& set = {});

/// Names of all built-in scenes, in the order of their ids.
[[nodiscard]] const std::vector<std::string>& scene_names();

}  // namespace perp
