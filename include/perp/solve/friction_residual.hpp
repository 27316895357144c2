// How far reactions are from solving a contact problem: one measure without units, others with.
#pragma once

#include "perp/solve/friction_problem.hpp"

namespace perp {

/// Residuals of r, recomputed from the problem's own data. Let û = u + mu |u_T| e_N (with the moments' parts where a block has them,
/// (3) of FrictionProblem) and P_K the projection onto
/// K. r solves the problem exactly if the natural map r - P_K(r - û) is zero. Its size depends on units, so each
/// block is first scaled: rows of velocity by one number, s_i = (tr W_ii / rows_i)^(-1/2), which keeps the circular cone round, the torsion
/// row and the two rolling rows each by their own, with the semi-axes scaled along; and the whole
/// by sigma = |s q|: r~ = r/(s sigma), u~ = s u/sigma (sigma = 1 if q = 0; where the trace is <= 0 the
/// mean of the others is taken, for moments times the squared semi-axis).
struct FrictionResidual {
  double absolute = 0;     ///< |r~ - P_K(r~ - û~)|, Euclidean over all blocks [-]
  double round_off = 0;    ///< what rounding of u~ may hide in `absolute`: 4 epsilon |r~| [-]
  double relative = 0;     ///< absolute / max(1, |r~|) [-]: the measure that decides
  double file = 0;         ///< |r - P_K(r - û)| in the problem's own numbers, as other programs print it
  double penetration = 0;  ///< max(0, -min u_N) over contacts [unit of u]
  /// max(0, |r_T| - mu r_N), and -r_N, |r| - mu of constant bounds: largest [unit of r]. Of an ellipsoid a (|A^-1 r| - r_N) with its longest
  /// semi-axis a, or a = 1 where it bounds moments alone.
  double cone = 0;
  double sliding =
      0;  ///< largest of |u_T| r_N mu + r_T.u_T, over mu r_N, on loaded contacts [unit of u]; likewise (|A u| + r.u/r_N)/a
  double lift = 0;  ///< max u_N of a contact that pushes with more than 1e-9 of the largest r [unit of u]
};

/// Residuals of the reactions r (m); in the global form v and lambda are solved for.
FrictionResidual friction_residual(const FrictionProblem& problem, const Vector& r);

/// Projection of z (as many entries as the block has rows, normal first) onto block i's set of admissible reactions, in the problem's own
/// numbers: Euclidean, so where a block has moments too it depends on the unit of length.
Vector project_reaction(const FrictionProblem& problem, Eigen::Index block, const Vector& z);
Vector project_reaction(BlockKind kind, double mu, const Vector& z);  ///< of kinds that mu alone describes

}  // namespace perp
