// What the two formats of contact problems share.
#pragma once

#include "perp/solve/friction_io.hpp"

namespace perp {

/// 2 or 3, or a refusal: the rows of every block of the problem.
int space_dimension(const FrictionProblem& problem);

/// Cones or planar contacts, one a coefficient.
void set_kinds(FrictionProblem& problem, int dimension);

FrictionProblem read_fclib(const std::string& path);

}  // namespace perp
