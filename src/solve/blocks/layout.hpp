// Where the rows of each kind of block stand: the one table of kinds that the solvers read.
//
// Solvers keep every block in a column of R rows, unused ones zero: R = 3 holds N, T1, T2 (normal, tangential), R = 6 holds
// N, T1, T2, torsion, rolling T1, rolling T2. A block without a normal row has a bound of constant size in its place.
#pragma once

#include <array>

#include "perp/solve/friction_problem.hpp"

namespace perp {

struct BlockLayout {
  int rows;                  ///< of the problem
  bool contact;              ///< has a normal row; else its bound is of constant size
  std::array<int, 6> place;  ///< in a column, of each row
};

const BlockLayout& layout_of(BlockKind kind);

/// Rows of the columns that hold a problem's blocks: 3 if all fit, else 6.
int column_rows(const FrictionProblem& problem);

/// The semi-axis that bounds the row at `place` of block i, in the problem's own units: of contacts times the normal reaction.
double semi_axis(const FrictionProblem& problem, Eigen::Index i, int place);

}  // namespace perp
