// What --set gives.
#pragma once

#include <string>
#include <vector>

#include "perp/study/scene.hpp"

namespace perp {

/// KEY=VALUE pairs as parameters of a scene. Throws std::invalid_argument naming `command` and the pair that is none.
[[nodiscard]] SceneParameters read_parameters(const std::string& command,
                                              const std::vector<std::string>& pairs);

}  // namespace perp
