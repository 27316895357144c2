// How far reactions are from solving a contact problem: one measure without units, others with.
#pragma once

#include "perp/solve/friction_problem.hpp"

namespace perp {

/// Residuals of r, recomputed from the problem's own data. Let û = u + mu |u_T| e_N and P_K the projection onto
/// K. r solves the problem exactly if the natural map r - P_K(r - û) is zero. Its size depends on units, so each
/// block is first scaled by one number, s_i = (tr W_ii / rows_i)^(-1/2), which keeps the cone round, and the whole
/// by sigma = |s q|: r~ = r/(s sigma), u~ = s u/sigma (sigma = 1 if q = 0; a block with tr W_ii <= 0 takes the
/// mean of the others).
struct FrictionResidual {
  double absolute = 0;     ///< |r~ - P_K(r~ - û~)|, Euclidean over all blocks [-]
  double round_off = 0;    ///< what rounding of u~ may hide in `absolute`: 4 epsilon |r~| [-]
  double relative = 0;     ///< absolute / max(1, |r~|) [-]: the measure that decides
  double file = 0;         ///< |r - P_K(r - û)| in the problem's own numbers, as other programs print it
  double penetration = 0;  ///< max(0, -min u_N) over contacts [unit of u]
  double cone = 0;         ///< max(0, |r_T| - mu r_N), and -r_N, |r| - mu of intervals: largest [unit of r]
  double sliding =
      0;            ///< largest of |u_T| r_N mu + r_T.u_T, over mu r_N, on contacts in the cone [unit of u]
  double lift = 0;  ///< max u_N of a contact that pushes with more than 1e-9 of the largest r [unit of u]
};

/// Residuals of the reactions r (m); in the global form v and lambda are solved for.
FrictionResidual friction_residual(const FrictionProblem& problem, const Vector& r);

/// Projection of z (1 to 3 entries, normal first) onto the block's set of admissible reactions.
Vector project_reaction(BlockKind kind, double mu, const Vector& z);

}  // namespace perp
