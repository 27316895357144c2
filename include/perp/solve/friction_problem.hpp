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

/// The admissible reactions of one block; its rows stand together, in the order named. Torsion is a moment about the normal, rolling
/// one about the two tangents, with the angular velocities of the second body relative to the first as their velocities.
enum class BlockKind {
  HalfLine,       ///< 1 row: 0 <= r ⟂ u >= 0, a contact without friction
  Planar,         ///< 2 rows (N, T): Coulomb friction in the plane, |r_T| <= mu r_N
  Cone,           ///< 3 rows (N, T1, T2): Coulomb friction, |r_T| <= mu r_N, or with mu_o the elliptic cone
  Interval,       ///< 1 row: |r| <= mu, u = 0 inside, u <= 0 at r = mu, u >= 0 at r = -mu: dry joint friction
  PlanarRolling,  ///< 3 rows (N, T, rolling): and |m| <= rolling r_N
  Torsional,      ///< 4 rows (N, T1, T2, torsion): |r_T|²/mu² + tau²/torsion² <= r_N²
  Rolling,        ///< 5 rows (N, T1, T2, rolling 1, 2): |r_T| <= mu r_N and |m| <= rolling r_N
  TorsionalRolling,  ///< 6 rows (N, T1, T2, torsion, rolling 1, 2): as Torsional, and |m| <= rolling r_N
  Disc,              ///< 2 rows: |r| <= mu, dry friction that resists in any direction of a plane
  Ball,              ///< 3 rows: |r| <= mu, dry friction of a ball joint
};

/// Rows that a block of the kind has.
int block_rows(BlockKind kind);

/// Find reactions r (impulses or forces) and relative velocities u with
///   u = W r + q                                       local form                             (1)
///   M v = H r + G lambda + f,  Gᵀ v + b = 0,  u = Hᵀ v + w    global form                    (2)
///   K_i ∋ r_i ⟂ u_i + (|A_i u_i| + |B_i u_i|) e_N ∈ K_i*      for every block i              (3)
/// with K_i = {r : |A_i^-1 r| <= r_N, |B_i^-1 r| <= r_N} and its dual cone K_i*: A_i = diag(mu, mu_o, torsion) are the semi-axes of
/// sliding with torsion, B_i = diag(rolling, rolling) those of rolling, as far as the kind has the rows (for a bound of
/// constant size: -u_i in its normal cone at r_i). For the circular cone (3) is Signorini's condition 0 <= u_N ⟂ r_N >= 0 with
/// Coulomb's law r_T = -mu r_N u_T/|u_T| while sliding [DSF98]; for the others it is Signorini's with maximum dissipation, the
/// friction r_A = -r_N A² u_A/|A u_A| while A u_A is not zero. u is velocity of the second body minus the first's; r acts on
/// the second body.
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

  Vector mu;  ///< (blocks) coefficient [-] >= 0; a constant bound [unit of r]; not read for a half line
  Vector
      mu_o{};  ///< (blocks) coefficient along T2 [-] >= 0 where another than mu holds there, or empty: the same
  Vector torsion{};  ///< (blocks), or empty where no block has the row: semi-axis of torsion [length] >= 0
  Vector
      rolling{};  ///< (blocks), or empty where no block has the rows: bound of rolling over r_N [length] >= 0

  /// (blocks), or empty: then all blocks are alike, by m / blocks: 1 half lines, 2 planar, 3 cones, 4 torsional, 5 rolling, 6 both.
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
