// What arguments of the command line may look like, and what --set gives.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "perp/study/scene.hpp"

namespace perp {

/// KEY=VALUE pairs as parameters of a scene. Throws std::invalid_argument naming `command` and the pair that is none.
[[nodiscard]] SceneParameters read_parameters(const std::string& command,
                                              const std::vector<std::string>& pairs,
                                              const std::string& option = "--set");

// Validators of CLI11, each refusing what the option could not mean. CLI11 itself takes 010 for 8 and nan for a number.
[[nodiscard]] CLI::Validator whole_number();   ///< decimal, zeros in front or not
[[nodiscard]] CLI::Validator finite_number();  ///< decimal; no nan, no inf
[[nodiscard]] CLI::Validator some_text();      ///< not empty

}  // namespace perp
