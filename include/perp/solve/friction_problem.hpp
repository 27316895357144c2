// Contact problems with exact Coulomb cones, as pure algebra: what is given and what is asked.
#pragma once

#include <vector>

#include "perp/core/sparse.hpp"
#include "perp/core/types.hpp"

namespace perp {

/// A matrix that its owner gave dense or sparse; the solvers look at the structure either way.
class FrictionMatrix {
 public:
  FrictionMatrix() = default;
  template <class Derived>
  FrictionMatrix(const Eigen::MatrixBase<Derived>& dense) : dense_(dense) {}
  template <class Derived>
  FrictionMatrix(const Eigen::SparseMatrixBase<Derived>& sparse) : is_sparse_(true), sparse_(sparse) {
    sparse_.makeCompressed();
  }

  bool is_sparse() const { return is_sparse_; }
  Eigen::Index rows() const { return is_sparse_ ? sparse_.rows() : dense_.rows(); }
  Eigen::Index cols() const { return is_sparse_ ? sparse_.cols() : dense_.cols(); }
  const Matrix& dense() const { return dense_; }          ///< empty if is_sparse()
  const SparseMatrix& sparse() const { return sparse_; }  ///< empty unless is_sparse()
  Matrix to_dense() const { return is_sparse_ ? Matrix(sparse_) : dense_; }
  SparseMatrix to_sparse() const { return is_sparse_ ? sparse_ : SparseMatrix(dense_.sparseView()); }
  Vector times(const Vector& x) const { return is_sparse_ ? Vector(sparse_ * x) : Vector(dense_ * x); }
  bool allFinite() const { return is_sparse_ ? sparse_.coeffs().allFinite() : dense_.allFinite(); }

 private:
  bool is_sparse_ = false;
  Matrix dense_;
  SparseMatrix sparse_;
};

/// The admissible reactions of one block; its rows stand together, normal first.
enum class BlockKind {
  HalfLine,  ///< 1 row: 0 <= r ⟂ u >= 0, a contact without friction
  Planar,    ///< 2 rows (N, T): Coulomb friction in the plane, |r_T| <= mu r_N
  Cone,      ///< 3 rows (N, T1, T2): Coulomb friction with the circular cone
  Interval,  ///< 1 row: |r| <= mu, u = 0 inside, u <= 0 at r = mu, u >= 0 at r = -mu: dry joint friction
};

/// Rows that a block of the kind has.
int block_rows(BlockKind kind);

/// Find reactions r (impulses or forces) and relative velocities u with
///   u = W r + q                                       local form                             (1)
///   M v = H r + G lambda + f,  Gᵀ v + b = 0,  u = Hᵀ v + w    global form                    (2)
///   K_i ∋ r_i ⟂ u_i + mu_i |u_T,i| e_N ∈ K_i*          for every block i                      (3)
/// with K_i = {|r_T| <= mu_i r_N} and its dual cone K_i* (for an interval: -u_i in its normal cone at r_i).
/// (3) is Signorini's condition 0 <= u_N ⟂ r_N >= 0 with Coulomb's law r_T = -mu r_N u_T/|u_T| while sliding
/// [DSF98]. u is velocity of the second body minus the first's; r acts on the second body.
/// Sizes: n degrees of freedom, m rows over all blocks, k bilateral rows. Any consistent units.
struct FrictionProblem {
  FrictionMatrix W;  ///< (m, m), may be singular, indefinite or unsymmetric
  Vector q;          ///< (m) [unit of u]

  FrictionMatrix M;  ///< (n, n) mass matrix; a problem with M is in the global form, and W, q are not read
  FrictionMatrix H;  ///< (n, m) wrench map
  FrictionMatrix G;  ///< (n, k) bilateral constraints, or empty
  Vector f;          ///< (n) [unit of M v]
  Vector w;          ///< (m) [unit of u]
  Vector b;          ///< (k) or empty

  Vector
      mu;  ///< (blocks) coefficient [-] >= 0; the bound of an interval [unit of r]; not read for a half line

  /// (blocks), or empty: then all blocks are alike, cones, planar contacts or half lines by m / blocks = 3, 2, 1.
  std::vector<BlockKind> kinds;

  bool is_global() const { return M.rows() > 0; }
  Eigen::Index blocks() const { return mu.size(); }
  Eigen::Index rows() const { return is_global() ? w.size() : q.size(); }  ///< m
  BlockKind kind(Eigen::Index i) const;                                    ///< of block i
  std::vector<Eigen::Index> offsets() const;  ///< (blocks + 1) first row of each block, then m
};

/// Throws std::invalid_argument if sizes disagree, a number is not finite or a coefficient is negative.
void check(const FrictionProblem& problem);

/// The global form brought to the local one: W = Hᵀ A H, q = Hᵀ v_free + w with v_free the velocity without
/// contact and A the response of the bilaterally constrained system. Returns a local problem as it is.
/// Throws std::invalid_argument if [M G; Gᵀ 0] is singular.
FrictionProblem to_local(const FrictionProblem& problem);

}  // namespace perp
