// First guesses of a motion's start from its first rows.
#pragma once

#include "study/fit_runs.hpp"

namespace perp {

/// Sets guess and scale of each unknown from the data: starts by parabolas through the first rows, as many as one fits, sizes by how
/// far columns spread. Bases of rotations that are wholly free become the measured ones.
void guess_from_data(const FitRuns& runs, const Scene& scene, Unknowns& unknowns);

}  // namespace perp
