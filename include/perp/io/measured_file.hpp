// Measured motions as CSV: t, and some of trajectory.csv's columns.
#pragma once

#include <filesystem>

#include "perp/study/fit.hpp"

namespace perp {

/// Reads a file whose first column is t [s], the others BODY.x and so on as in trajectory.csv; an empty cell is "not measured". Its
/// stem is the motion's name. Throws std::invalid_argument "FILE:LINE:COLUMN: what was found, what is needed" for a table that is
/// none, a cell that is no finite number, times that do not rise, quaternions far from unit length, and a file in which nothing is
/// measured.
[[nodiscard]] MeasuredMotion read_measured(const std::filesystem::path& file);

}  // namespace perp
