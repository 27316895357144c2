// What a step of each method costs on a scene.
#pragma once

#include "perp/study/scene.hpp"

namespace perp {

/// Prints a line a method: unknowns and rows of its step at the start, and the CPU time of one step, measured.
void print_prices(const Scene& scene);

}  // namespace perp
