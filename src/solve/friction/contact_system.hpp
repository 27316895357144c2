// A friction problem made ready for the solvers: R rows a block, scaled, with its linear algebra.
//
// Every block is padded to R = 3 or 6 rows (blocks/layout.hpp) whose unused ones have W = 0, q = 0, r = 0. Each block is scaled by
// one number a unit of its rows and the whole by sigma, as in friction_residual.hpp, so that the mean of W's diagonal is 1 over the
// rows of a unit, and |q| = 1.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "perp/solve/friction_residual.hpp"
#include "solve/blocks/block.hpp"
#include "solve/linear/block_lu.hpp"

namespace perp {

/// Multiplications of one block's own problem in a sweep, and of what an iteration of Newton's method does beside factors, about.
template <int R>
double own_work(const Block<R>& block) {
  return block.frictionless() ? 5 : R > 3 ? 800 : block.planar() ? 40 : 100;
}
inline constexpr double newton_own_work = 100;

/// The linear maps of the scaled problem: W itself, and solutions of (A + B W) x = y for block-diagonal A, B, the
/// form of every Newton system here. A block with B_i = 0 is eliminated before factoring.
template <int R>
class DelassusOperator {
 public:
  virtual ~DelassusOperator() = default;
  virtual const Square<R>& diagonal(int i) const = 0;
  virtual void apply(const Columns<R>& r, Columns<R>& Wr) const = 0;
  /// False if A + B W is numerically singular.
  virtual bool factor(const Squares<R>& A, const Squares<R>& B) = 0;
  /// x with (A + B W) x = y, refined if need be, and Wx beside it. False if x is not finite.
  virtual bool solve(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx) = 0;
  /// Row i of W r alone.
  virtual Column<R> row(int i, const Columns<R>& r) const = 0;
  /// Dense copy, for small problems and other solvers' stages.
  virtual Matrix dense() const = 0;

  /// For sweeps: keeps W r of some r up to date while its blocks change one by one.
  virtual void hold(const Columns<R>& r) { held_ = r; }
  virtual Column<R> held(int i) const { return row(i, held_); }
  virtual void add(int i, const Column<R>& dr) { held_.col(i) += dr; }
  /// Multiplications of W in a sweep, and of one Newton system set up, factored and solved, about. By default factors are out of reach.
  virtual double sweep_work() const { return 1; }
  virtual double newton_work() { return infinity; }

 protected:
  template <class SolveOnce>
  bool refine(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx, const Squares<R>& A, const Squares<R>& B,
              const SolveOnce& solve_once);

 private:
  Columns<R> residual_, correction_, held_;
};

/// W stored as sparse (R, R) blocks, factored in its own pattern.
template <int R>
class LocalOperator final : public DelassusOperator<R> {
 public:
  LocalOperator(BlockPattern pattern, Squares<R> values);
  const Square<R>& diagonal(int i) const override;
  void apply(const Columns<R>& r, Columns<R>& Wr) const override;
  bool factor(const Squares<R>& A, const Squares<R>& B) override;
  bool solve(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx) override;
  Column<R> row(int i, const Columns<R>& r) const override;
  Matrix dense() const override;
  double sweep_work() const override;
  double newton_work() override;

 private:
  void solve_once(const Columns<R>& y, Columns<R>& x);

  BlockPattern pattern_;
  Squares<R> values_;
  std::vector<int> diagonal_;  // place of W_ii in values_
  BlockLu<R> lu_;
  Squares<R> A_, B_;
  std::vector<char> open_;  // blocks with B_i = 0
  bool any_open_ = false;
};

/// A scaled problem of n blocks.
template <int R>
struct ContactSystem {
  int n = 0;
  std::vector<Block<R>> block;             ///< with scaled bounds
  std::vector<const BlockLayout*> layout;  ///< where the problem's rows stand
  Columns<R> q;                            ///< (R, n) scaled, |q| = 1 unless zero
  Columns<R> s;                            ///< (R, n) scale of each row
  double sigma = 1;                        ///< scale of the whole
  std::unique_ptr<DelassusOperator<R>> W;
  bool associated = false;  ///< the convex problem K ∋ r ⟂ u ∈ K*, without the De Saxcé term

  Columns<R> scaled_reaction(const Vector& r, const std::vector<Eigen::Index>& offsets) const;
  Vector reaction(const Columns<R>& scaled, const std::vector<Eigen::Index>& offsets) const;
};

/// Scales and packs a local problem.
template <int R>
ContactSystem<R> contact_system(const FrictionProblem& local);

/// The same for a global problem, in the bodies' velocities where the mass matrix allows, else brought to the
/// local form.
class MassResponse;
template <int R>
ContactSystem<R> contact_system(const FrictionProblem& global, const MassResponse& response);

/// Refines x of (A + B W) x = y by solve_once while that helps, at most twice; Wx is that of the x left. False if x
/// is not finite.
template <int R>
template <class SolveOnce>
bool DelassusOperator<R>::refine(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx, const Squares<R>& A,
                                 const Squares<R>& B, const SolveOnce& solve_once) {
  constexpr double enough = 1e-10, useless = 0.5;  // of |y|; of the miss before
  const double size = y.norm();
  double last = infinity;
  for (int refinements = 0;; ++refinements) {
    apply(x, Wx);
    residual_.resize(R, x.cols());
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
template <int R>
FrictionResidual friction_residual(const FrictionProblem& local, const ContactSystem<R>& system,
                                   const Vector& r, const Vector& u);

}  // namespace perp
