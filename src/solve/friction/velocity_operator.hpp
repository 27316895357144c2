// W = Hᵀ M^-1 H kept as its factors: the systems of the solvers become systems in the bodies' velocities.
#pragma once

#include "solve/friction/contact_system.hpp"
#include "solve/friction/global_form.hpp"

namespace perp {

/// For mass matrices of diagonal blocks up to 6x6. (A + B W) x = y with v = M^-1 H x is
///   (M + H D Hᵀ) v = H A^-1 y,  x = A^-1 y - D Hᵀ v,  D = A^-1 B:
/// one 6x6 block a body however many contacts it has. Where A is singular D does not exist, so A + delta B stands
/// in its place (W + delta I in W's), and the answer is refined against A itself.
template <int R>
class VelocityOperator final : public DelassusOperator<R> {
 public:
  using Block6 = Eigen::Matrix<double, 6, 6>;
  using Wrench = Eigen::Matrix<double, 6, R>;  ///< of one block on one body

  /// Whether the problem has this form (no bilateral rows, M of small blocks) and gains by it: no more bodies than
  /// contacts.
  static bool suits(const FrictionProblem& global);
  VelocityOperator(const FrictionProblem& global, const std::vector<const BlockLayout*>& layout);
  void scale(const Columns<R>& s);  ///< multiplies the columns of H, row by row

  const Square<R>& diagonal(int i) const override { return diagonal_[i]; }
  void apply(const Columns<R>& r, Columns<R>& Wr) const override;
  bool factor(const Squares<R>& A, const Squares<R>& B) override;
  bool solve(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx) override;
  Column<R> row(int i, const Columns<R>& r) const override;
  Matrix dense() const override;
  void hold(const Columns<R>& r) override;
  Column<R> held(int i) const override;
  void add(int i, const Column<R>& dr) override;
  double sweep_work() const override;
  double newton_work() override;

 private:
  struct Arm {
    int contact, body;
    Wrench H;
  };
  void find_diagonal();
  void solve_once(const Columns<R>& y, Columns<R>& x);

  int contacts_, bodies_;
  std::vector<Block6> mass_, inverse_mass_;
  std::vector<Arm> arms_;       // by contact
  std::vector<int> arm_start_;  // (contacts + 1)
  std::vector<std::vector<int>> arms_of_body_;
  Squares<R> diagonal_;
  BlockPattern pattern_;
  std::vector<int> place_;  // in the pattern, of each pair of arms of a contact, in order
  BlockLu<6> lu_;
  std::vector<Block6> sum_;  // the pattern's blocks
  Squares<R> A_, B_, A_inverse_, D_;
  mutable BlockLu<6>::Columns v_;
  BlockLu<6>::Columns held_v_;  // M^-1 H r of what is held
};

}  // namespace perp
