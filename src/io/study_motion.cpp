#include "io/study_motion.hpp"

#include "io/study_page.hpp"
#include "perp/core/errors.hpp"

namespace perp {

RunRecipe motion_of(const StudyRequest& request, const std::string& scene, double t_end) {
  constexpr double steps = 200, tolerance = 1e-8;
  RunRecipe recipe;
  recipe.scene = scene;
  recipe.set = request.set;
  recipe.method = request.methods.front();
  recipe.until = t_end;
  if (method(recipe.method).adaptive)
    recipe.options.tolerance = tolerance;
  else
    recipe.step = t_end / steps;
  return recipe;
}

std::filesystem::path motion_folder(const std::filesystem::path& study, const std::string& scene) {
  return study / (chart_name(scene) + "-motion");
}

std::vector<std::string> motion_command(const RunRecipe& recipe, const std::filesystem::path& folder) {
  std::vector<std::string> words{"perp", "run", recipe.scene, "--method", recipe.method};
  const auto add = [&](const char* option, double value) {
    words.emplace_back(option);
    words.push_back(shortest(value));
  };
  if (method(recipe.method).adaptive)
    add("--tolerance", recipe.options.tolerance);
  else
    add("--step", recipe.step);
  add("--until", recipe.until);
  for (const auto& [name, value] : recipe.set) {
    words.emplace_back("--set");
    words.push_back(name + "=" + shortest(value));
  }
  for (const std::string& word : {std::string("--view"), std::string("--out"), folder.string()})
    words.push_back(word);
  return words;
}

}  // namespace perp
