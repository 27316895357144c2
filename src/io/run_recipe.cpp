#include "io/run_recipe.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/fingerprint.hpp"
#include "io/machine.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/io/urdf.hpp"

namespace perp {
namespace {

using Json = nlohmann::ordered_json;

Json number(double x) { return std::isnan(x) ? Json(nullptr) : Json(x); }

Json parameters(const SceneParameters& all) {
  Json json = Json::object();
  for (const auto& [name, value] : all) json[name] = value;
  return json;
}

Json penalty_of(const PenaltyOptions& o) {
  return {{"stiffness", number(o.stiffness)},
          {"damping", number(o.damping)},
          {"slip_speed", number(o.slip_speed)},
          {"explicit", o.explicit_forces}};
}

/// The part of run.json that says what is run.
Json method_of(const RunRecipe& r) {
  return {{"method", r.method},
          {"step", number(r.step)},
          {"tolerance", r.options.tolerance},
          {"accuracy", number(r.accuracy)},
          {"order", r.options.order},
          {"edges", r.options.edges},
          {"integrator", name_of(r.options.integrator)},
          {"look", number(r.options.look)},
          {"impacts", name_of(r.options.impacts)},
          {"reactions", r.options.reactions == Reactions::MinimumNorm ? "minimum-norm" : "any"},
          {"penalty", penalty_of(r.options.penalty)},
          {"until", number(r.until)},
          {"every", r.every},
          {"assemble", r.assemble},
          {"allow_overlap", r.allow_overlap},
          {"format", r.format}};
}

/// Line and column of a byte of a text, from 1.
std::string place(const std::string& text, std::size_t byte) {
  const std::string_view before = std::string_view(text).substr(0, std::min(byte, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return std::to_string(line) + ":" + std::to_string(before.size() - begin + 1);
}

}  // namespace

std::string write_record(const RunRecord& record) {
  const RunRecipe& r = record.recipe;
  const auto or_null = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
  const Json json = {
      {"command", record.command},
      {"directory", r.folder},
      {"scene", {{"given", r.scene}, {"text", or_null(r.scene_text)}, {"included", r.included}}},
      {"set", parameters(r.set)},
      {"parameters", parameters(record.parameters)},
      {"run", method_of(r)},
      {"versions", library_versions()},
      {"build", record.build},
      {"machine", record.machine},
      {"start", or_null(record.start)},
      {"end", or_null(record.end)},
      {"exit_status", record.exit_status < 0 ? Json(nullptr) : Json(record.exit_status)},
      {"ended", or_null(record.ended)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

RunRecord read_record(const std::string& text, const std::string& file) {
  try {
    const Json json = Json::parse(text);
    const auto text_of = [](const Json& value) {
      return value.is_null() ? std::string() : value.get<std::string>();
    };
    const auto number_of = [](const Json& value) { return value.is_null() ? not_set : value.get<double>(); };
    RunRecord record;
    record.command = json.at("command").get<std::vector<std::string>>();
    record.parameters = json.at("parameters").get<SceneParameters>();
    record.version = json.at("versions").at("perp").get<std::string>();
    record.build = text_of(json.at("build"));
    record.machine = text_of(json.at("machine"));
    record.start = text_of(json.at("start"));
    record.end = text_of(json.at("end"));
    record.exit_status = json.at("exit_status").is_null() ? -1 : json.at("exit_status").get<int>();
    record.ended = text_of(json.at("ended"));
    RunRecipe& r = record.recipe;
    r.folder = json.at("directory").get<std::string>();
    r.scene = json.at("scene").at("given").get<std::string>();
    r.scene_text = text_of(json.at("scene").at("text"));
    r.included = json.at("scene").at("included").get<std::map<std::string, std::string>>();
    r.set = json.at("set").get<SceneParameters>();
    const Json& run = json.at("run");
    r.method = run.at("method").get<std::string>();
    r.step = number_of(run.at("step"));
    r.options.tolerance = run.at("tolerance").get<double>();
    if (run.contains("accuracy")) r.accuracy = number_of(run.at("accuracy"));  // not in older records
    if (run.contains("order")) r.options.order = run.at("order").get<int>();   // not in older records
    r.options.edges = run.at("edges").get<int>();
    r.options.integrator = integrator_named(run.at("integrator").get<std::string>());
    if (run.contains("look")) r.options.look = number_of(run.at("look"));  // not in older records
    if (run.contains("impacts"))                                           // not in older records
      r.options.impacts = impact_order_named(run.at("impacts").get<std::string>());
    r.options.reactions = run.at("reactions") == "minimum-norm" ? Reactions::MinimumNorm : Reactions::Any;
    if (run.contains("penalty")) {  // nor this
      const Json& penalty = run.at("penalty");
      r.options.penalty = {.stiffness = number_of(penalty.at("stiffness")),
                           .damping = number_of(penalty.at("damping")),
                           .slip_speed = number_of(penalty.at("slip_speed")),
                           .explicit_forces = penalty.at("explicit").get<bool>()};
    }
    r.until = number_of(run.at("until"));
    r.every = run.at("every").get<int>();
    r.assemble = run.at("assemble").get<bool>();
    r.allow_overlap = run.at("allow_overlap").get<bool>();
    r.format = run.at("format").get<std::string>();
    return record;
  } catch (const Json::parse_error& error) {
    throw std::invalid_argument(file + ":" + place(text, error.byte > 0 ? error.byte - 1 : 0) +
                                ": this is no JSON, needs to be as perp run wrote it");
  } catch (const Json::exception& error) {
    const std::string what = error.what();  // "[json.exception.NAME] sentence"
    throw std::invalid_argument(file + ":1:1: " + what.substr(std::min(what.find("] ") + 2, what.size())) +
                                ", needs to be as perp run wrote it");
  }
}

Scene read_scene_of(RunRecipe& recipe) {
  if (!is_scene_file(recipe.scene)) {
    Scene built_in = scene(recipe.scene, recipe.set);
    recipe.scene_text = text_of(built_in);
    return built_in;
  }
  recipe.scene_text = scene_text(recipe.scene);
  if (recipe.scene.ends_with(".urdf")) return make_scene(recipe);
  return read_scene(recipe.scene_text, recipe.scene, recipe.set,
                    [&](const std::string& path) { return recipe.included[path] = scene_text(path); });
}

Scene make_scene(const RunRecipe& recipe) {
  if (!is_scene_file(recipe.scene)) return scene(recipe.scene, recipe.set);
  if (recipe.scene.ends_with(".urdf")) return read_urdf(recipe.scene_text, recipe.scene, recipe.set);
  return read_scene(recipe.scene_text, recipe.scene, recipe.set, [&](const std::string& path) {
    const auto kept = recipe.included.find(path);
    if (kept == recipe.included.end()) refuse("run.json", "included", path, "needs to be kept there");
    return kept->second;
  });
}

std::string text_of(const Scene& scene) {
  try {
    return write_scene(scene);
  } catch (const std::invalid_argument&) {
    return {};
  }
}

std::string scene_mark(const RunRecipe& recipe) {
  std::string text = recipe.scene + "\n" + recipe.scene_text;
  for (const auto& [path, part] : recipe.included) text += "\n" + path + "\n" + part;
  for (const auto& [name, value] : recipe.set) text += "\n" + name + "=" + shortest(value);
  return fingerprint(text);
}

std::string method_mark(const RunRecipe& recipe) { return fingerprint(method_of(recipe).dump()); }

}  // namespace perp
