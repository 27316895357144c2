// The run behind the motion that a study's page links to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/run_recipe.hpp"
#include "perp/io/study_folder.hpp"

namespace perp {

/// The scene of the study by its first method, in 200 steps to `t_end`, or to a tolerance of 1e-8 where the method chooses its steps:
/// enough for the eye.
[[nodiscard]] RunRecipe motion_of(const StudyRequest& request, const std::string& scene, double t_end);

/// Its folder beside the study's page.
[[nodiscard]] std::filesystem::path motion_folder(const std::filesystem::path& study,
                                                  const std::string& scene);

/// The command that makes the recipe's run in `folder`, with its page.
[[nodiscard]] std::vector<std::string> motion_command(const RunRecipe& recipe,
                                                      const std::filesystem::path& folder);

}  // namespace perp
