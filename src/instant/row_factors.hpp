// N = Rᵀ M^-1 L over rows between bodies, factored along the graph that bodies make of them.
#pragma once

#include <Eigen/LU>

#include "instant/rows.hpp"
#include "solve/block_lu.hpp"

namespace perp {

/// Solves N c = b, N = Rᵀ Y, Y = M^-1 L (or of another instant with the same rows), for some or all of the rows. Rows couple through
/// bodies that move: what no body ties to the rest is a part of its own; a part is factored dense where it is small or asked to be, else
/// in blocks of one group, which on a tree of joints costs O(rows). Between blocks there is no pivoting, so answers are checked against
/// N and refined once; a part that they miss is factored dense.
class RowFactors {
 public:
  /// Rows tied to each other by bodies.
  struct Part {
    std::vector<int> groups, rows;  ///< rows that take part
    bool dense = false;
    Matrix Z;  ///< (rows, k) R Z = 0: how they repeat each other; empty if they do not
    Matrix V;  ///< (rows, rows - k) what c may be, then, set by the owner; c is free if it is empty
    Matrix N;  ///< where dense
    Eigen::PartialPivLU<Matrix> lu;
  };

  /// Of these rows; `on` tells which take part, all if it is empty.
  void arrange(const Rows& rows, std::vector<char> on = {});
  std::vector<Part>& parts() { return parts_; }
  const std::vector<Part>& parts() const { return parts_; }

  /// Sets Z of the parts whose rows repeat each other (eigenvalues of N, its diagonal scaled to 1, below threshold * rows; Y = M^-1 R),
  /// clears V.
  void find_dependent(const Rows& rows, const Rows::Response& Y, double threshold);

  /// Parts with a V by Vᵀ N V.
  void factor(const Rows& rows, const Rows::Response& Y);
  /// c of factor()'s N, zero of rows that do not take part.
  void solve(const Rows& rows, const Rows::Response& Y, const Vector& b, Vector& c);

  /// N symmetric (Y = M^-1 R) and semidefinite: c of least norm after N's diagonal is scaled to 1, by part. Factors are lost.
  void solve_least(const Rows& rows, const Rows::Response& Y, const Vector& b, Vector& c);

 private:
  struct Couple {
    int row, row_side, column, column_side, place;
  };
  static constexpr int few = 12;  // rows that are factored dense

  static bool in_blocks(const Part& part) { return !part.dense && part.V.size() == 0; }
  void assemble(const Rows& rows, const Rows::Response& Y);
  void gather(const Rows& rows, Part& part) const;
  bool factor_blocks();
  /// After factor_blocks(), N symmetric: whether no row is one of those before but for rounding.
  bool is_regular(const Part& part) const;
  void solve_blocks(const Rows& rows, const Vector& b, Vector& c);
  void solve_dense(const Part& part, const Vector& b, Vector& c) const;

  std::vector<Part> parts_;
  std::vector<int> part_;   // of each group, -1 without rows that take part
  std::vector<int> place_;  // of each row in its part, -1 if it does not take part
  std::vector<RowGroup::Block> values_;
  std::vector<Couple> couples_;
  BlockPattern pattern_;
  BlockLu<6> lu_;
  BlockLu<6>::Columns columns_;
  Vector nu_, missed_;
  Eigen::Index nv_ = 0;
};

/// An orthonormal basis of the range of the symmetric positive semidefinite N, after its diagonal is scaled to 1, scaled back;
/// empty if N has full rank.
[[nodiscard]] Matrix range_basis(const Matrix& N);

}  // namespace perp
