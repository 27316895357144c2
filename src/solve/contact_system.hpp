// A friction problem made ready for the solvers: three rows a block, scaled, with its linear algebra.
//
// Every block is padded to three rows (N, T1, T2) whose unused ones have W = 0, q = 0, r = 0; an interval is
// planar friction under a known normal reaction, so its row is T1. Each block is scaled
// by one number s_i and the whole by sigma, as in friction_residual.hpp, so that tr W_ii = rows_i and |q| = 1.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "block_lu.hpp"
#include "perp/solve/friction_residual.hpp"

namespace perp {

using Columns3 = Eigen::Matrix3Xd;  ///< one column a block
using Blocks3 = std::vector<Matrix3>;

/// Where a block's rows stand among the three.
inline int first_row(BlockKind kind) { return kind == BlockKind::Interval ? 1 : 0; }

/// Multiplications of one contact's own problem, about.
inline constexpr double one_contact_work = 100;

/// The linear maps of the scaled problem: W itself, and solutions of (A + B W) x = y for block-diagonal A, B, the
/// form of every Newton system here. A block with B_i = 0 is eliminated before factoring.
class DelassusOperator {
 public:
  virtual ~DelassusOperator() = default;
  virtual const Matrix3& diagonal(int i) const = 0;
  virtual void apply(const Columns3& r, Columns3& Wr) const = 0;
  /// False if A + B W is numerically singular.
  virtual bool factor(const Blocks3& A, const Blocks3& B) = 0;
  /// x with (A + B W) x = y, refined if need be, and Wx beside it. False if x is not finite.
  virtual bool solve(const Columns3& y, Columns3& x, Columns3& Wx) = 0;
  /// Row i of W r alone.
  virtual Vector3 row(int i, const Columns3& r) const = 0;
  /// For sweeps: keeps W r of some r up to date while its blocks change one by one.
  virtual void hold(const Columns3& r) { held_ = r; }
  virtual Vector3 held(int i) const { return row(i, held_); }
  virtual void add(int i, const Vector3& dr) { held_.col(i) += dr; }
  /// Multiplications, about: of a sweep, and of one Newton system set up, factored and solved. By default factors are out of reach.
  virtual double sweep_work() const { return 0; }
  virtual double newton_work() { return infinity; }
  /// Dense copy, for small problems and other solvers' stages.
  virtual Matrix dense() const = 0;

 protected:
  template <class SolveOnce>
  bool refine(const Columns3& y, Columns3& x, Columns3& Wx, const Blocks3& A, const Blocks3& B,
              const SolveOnce& solve_once);

 private:
  Columns3 residual_, correction_, held_;
};

/// W stored as sparse 3x3 blocks, factored in its own pattern.
class LocalOperator final : public DelassusOperator {
 public:
  LocalOperator(BlockPattern pattern, Blocks3 values);
  const Matrix3& diagonal(int i) const override;
  void apply(const Columns3& r, Columns3& Wr) const override;
  bool factor(const Blocks3& A, const Blocks3& B) override;
  bool solve(const Columns3& y, Columns3& x, Columns3& Wx) override;
  Vector3 row(int i, const Columns3& r) const override;
  double sweep_work() const override;
  double newton_work() override;
  Matrix dense() const override;

 private:
  void solve_once(const Columns3& y, Columns3& x);

  BlockPattern pattern_;
  Blocks3 values_;
  std::vector<int> diagonal_;  // place of W_ii in values_
  BlockLu<3> lu_;
  Blocks3 A_, B_;
  std::vector<char> open_;  // blocks with B_i = 0
  bool any_open_ = false;
};

/// A scaled problem of n blocks.
struct ContactSystem {
  int n = 0;
  std::vector<BlockKind> kind;
  std::vector<double> mu;  ///< coefficient; an interval's scaled bound
  Columns3 q;              ///< (3, n) scaled, |q| = 1 unless zero
  std::vector<double> s;   ///< (n) scale of each block
  double sigma = 1;        ///< scale of the whole
  std::unique_ptr<DelassusOperator> W;
  bool associated = false;  ///< the convex problem K ∋ r ⟂ u ∈ K*, without the De Saxcé term

  Columns3 scaled_reaction(const Vector& r, const std::vector<Eigen::Index>& offsets) const;
  Vector reaction(const Columns3& scaled, const std::vector<Eigen::Index>& offsets) const;
};

/// Scales and packs a local problem.
ContactSystem contact_system(const FrictionProblem& local);

/// The same for a global problem, in the bodies' velocities where the mass matrix allows, else brought to the
/// local form.
class MassResponse;
ContactSystem contact_system(const FrictionProblem& global, const MassResponse& response);

/// Refines x of (A + B W) x = y by solve_once while that helps, at most twice; Wx is that of the x left. False if x
/// is not finite.
template <class SolveOnce>
bool DelassusOperator::refine(const Columns3& y, Columns3& x, Columns3& Wx, const Blocks3& A,
                              const Blocks3& B, const SolveOnce& solve_once) {
  constexpr double enough = 1e-10, useless = 0.5;  // of |y|; of the miss before
  const double size = y.norm();
  double last = infinity;
  for (int refinements = 0;; ++refinements) {
    apply(x, Wx);
    residual_.resize(3, x.cols());
    for (int i = 0; i < static_cast<int>(x.cols()); ++i)
      residual_.col(i) = y.col(i) - A[i] * x.col(i) - B[i] * Wx.col(i);
    const double miss = residual_.norm();
    if (!std::isfinite(miss)) return false;
    if (miss <= enough * size || miss > useless * last || refinements == 2) return true;
    last = miss;
    solve_once(residual_, correction_);
    x += correction_;
  }
}

/// The residuals of r and u = W r + q, with the system's scales.
FrictionResidual friction_residual(const FrictionProblem& local, const ContactSystem& system, const Vector& r,
                                   const Vector& u);

}  // namespace perp
