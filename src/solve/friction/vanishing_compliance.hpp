// One rule for redundant reactions: the limit of rows that give a little, as what they give goes to nothing.
#pragma once

#include <Eigen/LU>

#include "perp/core/types.hpp"

namespace perp {

/// Equations A y + b = 0 of reactions y whose modes are known: rows that may repeat each other, columns that with sliding friction
/// are not those of a symmetric matrix. Where A is singular,
///   y = lim_{eps -> 0} y(eps),   A y(eps) + b + eps (C y(eps) + k) = 0,                       (1)
/// C the compliances. With N_l a basis of the null space of Aᵀ, (1) times N_lᵀ is, for every eps,
///   N_lᵀ (C y + k) = 0.                                                                       (2)
/// For A = Aᵀ, k = 0 the limit has the least yᵀ C y; with sliding it has not. Where A is regular it is the one solution.
///
/// Found with the factors of B = A + eps C for one small eps, and no decision about rank: corrections B dy = -(A y + b) leave (2) as
/// it is and gain a factor of about eps over A's smallest other singular value each; rounding, which they bring into (2), is taken
/// out by a last correction B dy = -eps (C y + k), made up for in A y + b by its like.
///
/// Keeps its workspace: nothing is allocated while sizes stay the same.
class VanishingCompliance {
 public:
  enum class Outcome {
    Found,
    Several,  ///< N_lᵀ C N_r is singular too: (1) has no limit, or more than one. y is meaningless
    None      ///< A y + b = 0 has no solution, to rounding
  };

  /// A, C (n, n); b, k (n). `scale` (n), positive: entries of y times scale, and of A y over scale, are of one unit. Rows of C
  /// may be zero where those of A do not repeat others.
  Outcome solve(const Matrix& A, const Vector& b, const Matrix& C, const Vector& k, const Vector& scale,
                Vector& y);

  /// y_1 of y(eps) = y + eps y_1 + ..., after the last solve that found y.
  const Vector& first_order() const { return y_1_; }

 private:
  void correct(const Vector& rest, Vector& dy);

  Matrix A_, C_, B_;
  Vector inverse_, b_, k_, y_, y_1_, rest_, dy_, give_, back_;
  Eigen::PartialPivLU<Matrix> lu_;
};

}  // namespace perp
