// What the two formats of contact problems share.
#pragma once

#include <vector>

#include "perp/solve/friction_io.hpp"

namespace perp {

/// The one kind of all blocks if a file has a place for it, or a refusal: planar contacts (2 rows), cones (3), torsional (4), rolling (5), both
/// (6). Cones if there is no block.
BlockKind kind_of_all(const FrictionProblem& problem);

bool has_torsion(BlockKind kind);  ///< of these kinds, those with a torsion row
bool has_rolling(BlockKind kind);  ///< and those with rolling rows

FrictionProblem read_fclib(const std::string& path, std::vector<std::string>* remarks);

}  // namespace perp
