// A linear complementarity problem solved from a basis that is nearly right, such as the last step's.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "perp/solve/lcp.hpp"

namespace perp {

/// Block principal pivots on 0 <= z ⟂ w = A z + b >= 0 [JP94]: with `basic` the i whose w_i = 0,
///   A_II z_I = -b_I,   z_J = 0,
/// and all i at which z_I or w_J is negative change sides, as long as they grow fewer. Where the basis of a solution is
/// kept from step to step that is one factorisation of A_II, which is as large as the bodies' freedoms at most, where Lemke's path
/// takes O(n) exchanges of an n x n dictionary.
class BasisPivots {
 public:
  /// True, with `out` filled and `basic` that of the solution, if lcp_relative_residual(A, b, z) is within that of LcpOptions; else
  /// false, and nothing is said of the problem. Keeps its workspace.
  bool solve(const Matrix& A, const Vector& b, std::vector<char>& basic, LcpSolution& out);

 private:
  bool solve_basis(const Matrix& A, const Vector& b, const std::vector<char>& basic, Vector& z);
  int infeasible(const Vector& z, double size);

  std::vector<int> in_;
  std::vector<char> wrong_;
  Matrix A_in_;
  Vector b_in_, z_in_, w_;
  Eigen::PartialPivLU<Matrix> lu_;
};

/// The basis that solved a problem, and what tells that problem from others.
struct KeptBasis {
  std::vector<int> of;
  std::vector<char> basic;

  void keep(const std::vector<int>& problem, const Vector& z);
};

}  // namespace perp
