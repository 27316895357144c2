// One rule for redundant reactions: the limit of rows that give a little, as what they give goes to nothing.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>

#include "perp/core/types.hpp"
#include "perp/solve/friction_solver.hpp"

namespace perp {

/// Equations A y + b = 0 of reactions y whose modes are known: rows that may repeat each other, columns that with sliding friction
/// are not those of a symmetric matrix. Where A is singular,
///   y = lim_{eps -> 0} y(eps),   A y(eps) + b + eps (C y(eps) + k) = 0,                       (1)
/// C the compliances. With N_l a basis of the null space of Aᵀ, (1) times N_lᵀ is N_lᵀ (C y + k) = 0 for every eps, so that
///   A y + b = 0,   N_lᵀ (C y + k) = 0,                                                        (2)
/// solved as (A + C_l N_l N_lᵀ C_l) y = ... of full rank. For A = Aᵀ, k = 0 this is the solution of least yᵀ C y; with sliding it is not.
///
/// Keeps its workspace: nothing is allocated while sizes stay the same.
class VanishingCompliance {
 public:
  enum class Outcome {
    Unique,   ///< A is regular
    Shared,   ///< A is singular, and (1) has the one limit y
    Several,  ///< N_lᵀ C N_r is singular too: (1) has no limit, or not one. y is meaningless
    None      ///< A y + b = 0 has no solution
  };

  /// `scale` (n), positive: entries of y times scale, and of A y over scale, are of one unit. The rank of A is that of the
  /// scaled matrix, with `dependent` of its largest pivot taken as zero.
  Outcome solve(const Matrix& A, const Vector& b, const Matrix& C, const Vector& k, const Vector& scale,
                Vector& y);

  /// y_1 with y(eps) = y + eps y_1 + ..., of the last solve, from the same C, k, scale and its y: A y_1 + C y + k = 0.
  void first_order(const Matrix& C, const Vector& k, const Vector& scale, const Vector& y, Vector& y_1);

  /// Dimension of what statics leaves open, of the last solve.
  int redundancy() const { return redundancy_; }

 private:
  /// Rows repeat each other: directions that differ by 1e-6 rad, squared by W = Gᵀ M^-1 G. Ten times more would take contacts a
  /// few micrometres apart on a metre as one; ten times less comes near the rounding of A where masses differ by 1e3.
  static constexpr double dependent = 1e-12;

  int redundancy_ = 0;
  Matrix A_, B_, C_, null_, across_;
  Vector b_, k_, y_, rest_;
  Eigen::ColPivHouseholderQR<Matrix> qr_;
  Eigen::PartialPivLU<Matrix> lu_;
};

/// solve_friction of a local problem, and where its W is singular the solution that is the limit of
///   u = (W + eps C) r + q + eps k,   eps -> 0,
/// C (m, m) and k (m) the compliances of the rows: the problem with a small eps tells modes, those the limit. Where there is no one
/// limit, or it is not found, any solution.
[[nodiscard]] FrictionSolution solve_evenly(const FrictionProblem& problem, const Matrix& C, const Vector& k,
                                            const FrictionOptions& options = {});

}  // namespace perp
