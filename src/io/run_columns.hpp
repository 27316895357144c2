// The columns of trajectory.csv.
#pragma once

#include <vector>

#include "io/run_table.hpp"
#include "perp/model/model.hpp"

namespace perp {

/// t, then those of each body in the model's order (perp/io/run_files.hpp).
[[nodiscard]] std::vector<RunColumn> trajectory_header(const Model& model);

}  // namespace perp
