// Siconos's solvers of three-dimensional contact problems, called for comparison.
#pragma once

#include <Friction_cst.h>
#include <FrictionContactProblem.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>

#include <functional>
#include <string>
#include <vector>

#include "perp/solve/friction_problem.hpp"

namespace perp {

struct SiconosSolver {
  std::string name;
  int id;

  /// Reactions from a cold start; not finite for a planar problem, which these solvers do not take.
  Vector solve(const FrictionProblem& problem) const {
    Vector reaction = Vector::Zero(problem.rows()), velocity = reaction;
    if (problem.rows() != 3 * problem.blocks()) return Vector::Constant(problem.rows(), not_set);
    const FrictionProblem local = to_local(problem);
    const SparseMatrix W = local.W.to_sparse();
    const int m = static_cast<int>(local.q.size());
    NumericsMatrix* M = NM_create(NM_SPARSE, m, m);
    NM_triplet_alloc(M, W.nonZeros());
    for (int c = 0; c < m; ++c)
      for (SparseMatrix::InnerIterator it(W, c); it; ++it)
        NM_entry(M, static_cast<int>(it.row()), c, it.value());
    Vector q = local.q, mu = local.mu;
    FrictionContactProblem* contact =
        frictionContactProblem_new_with_data(3, static_cast<int>(mu.size()), M, q.data(), mu.data());
    SolverOptions* options = solver_options_create(id);
    options->dparam[SICONOS_DPARAM_TOL] = 1e-12;
    fc3d_driver(contact, reaction.data(), velocity.data(), options);
    solver_options_delete(options);
    NM_clear(M);
    return reaction;
  }
};

inline std::vector<SiconosSolver> siconos_solvers() {
  return {{"siconos NSGS", SICONOS_FRICTION_3D_NSGS},
          {"siconos NSN_AC", SICONOS_FRICTION_3D_NSN_AC},
          {"siconos PROX", SICONOS_FRICTION_3D_PROX}};
}

}  // namespace perp
