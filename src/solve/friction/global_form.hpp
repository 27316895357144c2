// Velocities from reactions in the global form: M v = H r + G lambda + f, Gᵀ v + b = 0.
#pragma once

#include <Eigen/SparseLU>
#include <memory>

#include "perp/solve/friction_problem.hpp"

namespace perp {

/// Factors of [M -G; Gᵀ 0]. Without bilateral rows a mass matrix of small blocks (bodies) is inverted block by block.
class MassResponse {
 public:
  /// Throws std::invalid_argument if the matrix is singular.
  explicit MassResponse(const FrictionProblem& global);

  /// v and lambda under the generalised impulse `load` (n) = H r + f, refined once.
  void velocity(const Vector& load, Vector& v, Vector& lambda) const;
  /// A H for A the response of v to a load, bilateral rows homogeneous.
  SparseMatrix times(const SparseMatrix& H) const;

 private:
  Vector solve(const Vector& rhs) const;

  Eigen::Index n_, k_;
  Vector b_;
  SparseMatrix kkt_;
  SparseMatrix inverse_;  // of M if it falls into small blocks and k = 0, else empty
  std::unique_ptr<Eigen::SparseLU<SparseMatrix>> lu_;
};

/// The connected blocks of M, each a list of rows.
std::vector<std::vector<int>> connected_blocks(const SparseMatrix& M);

/// to_local with the response at hand.
FrictionProblem to_local(const FrictionProblem& global, const MassResponse& response);

}  // namespace perp
