// Which of a model's loads is not finite.
#pragma once

#include <string>

#include "perp/instant/instant.hpp"

namespace perp {

/// A phrase that names the first load at x that is not finite, and its body or joint: "force 2 on body 'ball', (nan, 0, 0) N,". `instant` has
/// poses, velocities and joints' coordinates of x. "a load" where no single one is found.
[[nodiscard]] std::string load_fault(const Model& model, const State& x, const Instant& instant);

}  // namespace perp
