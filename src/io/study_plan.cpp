#include "io/study_plan.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "core/files.hpp"
#include "io/fingerprint.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

template <class Number>
Number number(const char* argument, const std::string& text, const char* need) {
  Number value{};
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size() || text.empty())
    refuse("perp study", argument, text, need);
  return value;
}

/// h in seconds or T/N.
double step_of(const std::string& text, double length) {
  constexpr const char* need = "needs to be a step in seconds, or T/N for N steps";
  if (text.rfind("T/", 0) != 0) return number<double>("--steps", text, need);
  const int n = number<int>("--steps", text.substr(2), need);
  if (n < 1) refuse("perp study", "--steps", text, need);
  return length / n;
}

std::string_view name_of(VelocityMeasure measure) {
  return measure == VelocityMeasure::AtEnd ? "end" : measure == VelocityMeasure::L1 ? "l1" : "graph";
}

bool is_file(const std::string& scene) {
  const auto& names = scene_names();
  return std::find(names.begin(), names.end(), scene) == names.end();
}

std::string contents(const std::string& file) { return read_file(file, "needs a scene file"); }

/// What a computed reference depends on besides the scene: the finest level.
std::string steps_of(const std::vector<std::vector<int>>& counts) {
  int most = 0;
  for (const std::vector<int>& level : counts) most = std::max(most, level.front());
  return std::to_string(most);
}

std::vector<StudyLine> lines_of(const StudyRequest& request) {
  std::vector<StudyLine> lines;
  std::set<std::string> seen;
  for (const std::string& name : request.methods) {
    const Method& chosen = method(name);
    if (!seen.insert(name).second) refuse("perp study", "--methods", name, "needs to be named once");
    const bool of_order = name == "extrapolated" && !request.orders.empty();
    if (!chosen.polygonal && !of_order) lines.push_back({.method = &chosen});
    for (const int order : request.orders)
      if (of_order) lines.push_back({.method = &chosen, .options = {.order = order}});
    if (name == "penalty") lines.back().settings = request.set_method;
    for (const int edges : request.edges)
      if (chosen.polygonal) lines.push_back({.method = &chosen, .options = {.edges = edges}});
  }
  for (const StudyLine& line : lines) (void)line.stepper();  // refuses options that it cannot take
  for (const auto& [key, value] : request.set_method) MethodOptions().set("penalty", key, value);
  return lines;
}

}  // namespace

StudyPlan plan_study(const StudyRequest& request, int shards, const TimingOptions& timing) {
  if (request.scenes.empty()) refuse("perp study", "SCENE", "nothing", "needs one scene or more");
  if (request.methods.empty()) refuse("perp study", "--methods", "nothing", "needs one method or more");
  if (request.edges.empty()) refuse("perp study", "--edges", "nothing", "needs a number or more");
  for (const double tolerance : request.tolerances)
    if (!(tolerance > 0) || !(tolerance < 1))
      refuse("perp study", "--tolerances", tolerance, "needs to be between 0 and 1");
  StudyPlan plan{.scenes = {}, .lines = lines_of(request), .runs = {}};
  std::set<std::string> names;
  for (const std::string& name : request.scenes) {
    ConvergenceStudy study{.scene = load_scene(name, request.set), .t_end = request.until};
    if (!names.insert(study.scene.name).second)
      refuse("perp study", "SCENE", study.scene.name, "needs to be there once");
    const double T = std::isnan(request.until) ? study.scene.t_end : request.until;
    for (const std::string& step : request.steps)
      study.steps.push_back(step_of(step, T - study.scene.start.t));
    study.envelope = request.envelope;
    study.velocity = request.velocity;
    study.timing = timing;
    study.reference = request.reference;
    study.over_run = request.over_run;
    plan.scenes.emplace_back(study);

    std::string identity = std::string(version) + " " + shortest(T) + " " +
                           std::string(name_of(request.velocity)) + " " +
                           std::string(name_of(request.reference));
    if (request.over_run) identity += " over-run";
    if (!plan.scenes.back().reference()) identity += " of " + steps_of(plan.scenes.back().counts());
    for (const auto& [key, value] : request.set) identity += " " + key + "=" + shortest(value);
    if (is_file(name)) identity += "\n" + contents(name);
    const std::string scene_key = study.scene.name + " " + fingerprint(identity);
    for (std::size_t line = 0; line < plan.lines.size(); ++line) {
      const std::unique_ptr<Stepper> stepper = plan.lines[line].stepper();
      std::string line_key = scene_key + " " + std::string(stepper->name()) + " " + parameter_of(*stepper);
      for (const auto& [setting, value] : plan.lines[line].settings)
        line_key += " " + setting + "=" + shortest(value);
      std::size_t turn = (names.size() - 1) * plan.lines.size() + line;
      const auto shard = [&] { return static_cast<int>(turn++ % static_cast<std::size_t>(shards)); };
      if (chooses_steps(*stepper)) {
        for (std::size_t level = 0; level < request.tolerances.size(); ++level)
          plan.runs.push_back({.scene = names.size() - 1,
                               .line = line,
                               .level = static_cast<int>(level),
                               .n = 1,
                               .tolerance = request.tolerances[level],
                               .shard = shard(),
                               .key = line_key + " rtol " + shortest(request.tolerances[level])});
        continue;
      }
      const auto& levels = plan.scenes.back().counts();
      for (std::size_t level = 0; level < levels.size(); ++level)
        for (const int n : levels[level])
          plan.runs.push_back({.scene = names.size() - 1,
                               .line = line,
                               .level = static_cast<int>(level),
                               .n = n,
                               .shard = shard(),
                               .key = line_key + " " + std::to_string(n)});
    }
  }
  return plan;
}

std::string write_request(const StudyRequest& request) {
  std::string text;
  const auto line = [&](const char* word, std::string_view value) {
    text.append(word).append(" ").append(value).append("\n");
  };
  for (const std::string& scene : request.scenes)
    line("scene", is_file(scene) ? std::filesystem::absolute(scene).lexically_normal().string() : scene);
  for (const std::string& name : request.methods) line("method", name);
  for (const std::string& step : request.steps) line("step", step);
  if (!std::isnan(request.until)) line("until", shortest(request.until));
  for (const auto& [key, value] : request.set) line("set", key + "=" + shortest(value));
  for (const int order : request.orders) line("order", std::to_string(order));
  for (const auto& [key, value] : request.set_method) line("set-method", key + "=" + shortest(value));
  for (const int edges : request.edges) line("edges", std::to_string(edges));
  for (const double tolerance : request.tolerances) line("tolerance", shortest(tolerance));
  line("envelope", std::to_string(request.envelope));
  line("velocity", name_of(request.velocity));
  if (request.over_run) line("over-run", "1");
  if (request.reference != ReferenceChoice::Automatic) line("reference", name_of(request.reference));
  return text;
}

StudyRequest read_request(const std::filesystem::path& file) {
  if (std::error_code none; !std::filesystem::exists(file, none))
    refuse("perp study", "folder", file.parent_path().string(),
           "holds no study: there is no " + file.string());
  std::istringstream in(read_file(file, "needs to be as perp study wrote it"));
  StudyRequest request;
  request.edges.clear();
  request.tolerances.clear();
  const char* need = "needs to be as perp study wrote it";
  for (std::string text; std::getline(in, text);) {
    const std::size_t space = std::min(text.find(' '), text.size());
    const std::string word = text.substr(0, space), value = text.substr(std::min(space + 1, text.size()));
    if (word == "scene")
      request.scenes.push_back(value);
    else if (word == "method")
      request.methods.push_back(value);
    else if (word == "step")
      request.steps.push_back(value);
    else if (word == "until")
      request.until = number<double>("until", value, need);
    else if (word == "set" || word == "set-method")
      (word == "set" ? request.set : request.set_method)[value.substr(0, value.find('='))] =
          number<double>("set", value.substr(std::min(value.find('='), value.size() - 1) + 1), need);
    else if (word == "order")
      request.orders.push_back(number<int>("order", value, need));
    else if (word == "edges")
      request.edges.push_back(number<int>("edges", value, need));
    else if (word == "tolerance")
      request.tolerances.push_back(number<double>("tolerance", value, need));
    else if (word == "envelope")
      request.envelope = number<int>("envelope", value, need);
    else if (word == "velocity")
      request.velocity = velocity_measure(value);
    else if (word == "over-run")
      request.over_run = true;
    else if (word == "reference")
      request.reference = reference_named(value);
    else
      refuse("perp study", "request", text, need);
  }
  return request;
}

VelocityMeasure velocity_measure(std::string_view name) {
  for (const VelocityMeasure measure : {VelocityMeasure::AtEnd, VelocityMeasure::L1, VelocityMeasure::Graph})
    if (name_of(measure) == name) return measure;
  refuse("perp study", "--velocity", name, "needs to be end, l1 or graph");
}

}  // namespace perp
