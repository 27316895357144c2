// A contact problem taken apart where nothing ties its contacts to each other.
#pragma once

#include <vector>

#include "perp/solve/friction_problem.hpp"

namespace perp {

/// Part of a problem that stands for itself.
struct FrictionIsland {
  FrictionProblem problem;
  std::vector<Eigen::Index> rows;  ///< of the whole problem's r, in order
};

/// The islands: blocks tied by entries of W, or by a chain of bodies, through M, H and G. One island gives an empty list.
std::vector<FrictionIsland> friction_islands(const FrictionProblem& problem);

}  // namespace perp
