// Siconos's solvers of contact problems in the plane and in space, called for comparison.
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
  int dimension, id;

  /// Reactions from a cold start; not finite for a problem of the other dimension.
  Vector solve(const FrictionProblem& problem) const {
    Vector reaction = Vector::Zero(problem.rows()), velocity = reaction;
    if (problem.rows() != dimension * problem.blocks()) return Vector::Constant(problem.rows(), not_set);
    const FrictionProblem local = to_local(problem);
    NumericsMatrix* M = dimension == 3 ? sparse(local.W.to_sparse()) : dense(local.W.to_dense());
    Vector q = local.q, mu = local.mu;
    FrictionContactProblem* contact =
        frictionContactProblem_new_with_data(dimension, static_cast<int>(mu.size()), M, q.data(), mu.data());
    SolverOptions* options = solver_options_create(id);
    options->dparam[SICONOS_DPARAM_TOL] = 1e-12;
    (dimension == 3 ? fc3d_driver : fc2d_driver)(contact, reaction.data(), velocity.data(), options);
    solver_options_delete(options);
    NM_clear(M);
    return reaction;
  }

 private:
  static NumericsMatrix* sparse(const SparseMatrix& W) {
    const int m = static_cast<int>(W.rows());
    NumericsMatrix* M = NM_create(NM_SPARSE, m, m);
    NM_triplet_alloc(M, W.nonZeros());
    for (int c = 0; c < m; ++c)
      for (SparseMatrix::InnerIterator it(W, c); it; ++it)
        NM_entry(M, static_cast<int>(it.row()), c, it.value());
    return M;
  }
  /// The solvers of planar problems take no other.
  static NumericsMatrix* dense(const Matrix& W) {
    const int m = static_cast<int>(W.rows());
    NumericsMatrix* M = NM_create(NM_DENSE, m, m);
    Eigen::Map<Matrix>(M->matrix0, m, m) = W;
    return M;
  }
};

inline std::vector<SiconosSolver> siconos_solvers() {
  return {{"siconos NSGS", 3, SICONOS_FRICTION_3D_NSGS},  {"siconos NSN_AC", 3, SICONOS_FRICTION_3D_NSN_AC},
          {"siconos PROX", 3, SICONOS_FRICTION_3D_PROX},  {"siconos 2D NSGS", 2, SICONOS_FRICTION_2D_NSGS},
          {"siconos 2D CPG", 2, SICONOS_FRICTION_2D_CPG}, {"siconos 2D LEMKE", 2, SICONOS_FRICTION_2D_LEMKE}};
}

}  // namespace perp
