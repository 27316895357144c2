// LU factors of a sparse matrix of small square blocks, without pivoting between blocks.
//
// Contacts couple only through the bodies they share, so the matrices of the friction solvers are sparse in 3x3
// blocks and, in a minimum-degree order, hardly fill in. The diagonal blocks are inverted with pivoting inside
// the block; between blocks there is none, so the caller checks the answer against the matrix.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace perp {

/// Places of the blocks of an (n, n) block matrix, row by row, columns ascending; the diagonal is always there
/// and the pattern is symmetric.
struct BlockPattern {
  std::vector<int> row_start;  ///< (n + 1)
  std::vector<int> column;     ///< (blocks)
  int size() const { return static_cast<int>(row_start.size()) - 1; }
  int find(int row, int col) const;  ///< place of the block (row, col), which must be there
};

/// The pattern of lists of columns, sorted and freed of doubles here; they must be symmetric.
BlockPattern make_pattern(std::vector<std::vector<int>>& rows);

/// a := a^-1 by Gauss-Jordan with row pivoting; false if a pivot vanishes beside the largest entry.
template <int B>
bool invert(Eigen::Matrix<double, B, B>& a);

/// An elimination order of small fill (approximate minimum degree): order[k] is the k-th pivot.
std::vector<int> elimination_order(const BlockPattern& pattern);

/// For each pivot k (in elimination order) the later pivots that its elimination couples, ascending.
struct EliminationStructure {
  std::vector<int> start;  ///< (n + 1)
  std::vector<int> later;  ///< (fill)
};
EliminationStructure eliminate(const BlockPattern& pattern, const std::vector<int>& order,
                               const std::vector<int>& rank);

/// P A Pᵀ = L D U with unit block-triangular L, U and block-diagonal D, for blocks of size B.
template <int B>
class BlockLu {
 public:
  using Block = Eigen::Matrix<double, B, B>;
  using Columns = Eigen::Matrix<double, B, Eigen::Dynamic>;

  /// Finds the order and the places of the factors' blocks.
  void analyze(const BlockPattern& pattern);
  bool analyzed() const { return !order_.empty(); }

  /// Before set(): every block zero, every row taking part.
  void clear();
  /// Block k of the pattern.
  void set(int k, const Block& value) { *place_[k] = value; }
  /// Row i is to be left out of the factors and of solve(): its unknown is known already.
  void leave_out(int i) { active_[rank_[i]] = false; }

  /// False if a diagonal block is singular to working precision.
  bool factor();
  /// x := A^-1 x over the rows that take part; the others stay as they are.
  void solve(Columns& x) const;
  /// After factor(): the inverse of what is left of row i's diagonal block when the rows before it are eliminated.
  const Block& inverse_pivot(int i) const { return diagonal_[rank_[i]]; }

  /// Multiplications of factor() and of solve() where every row takes part.
  double factor_work() const;
  double solve_work() const;

 private:
  std::vector<int> order_, rank_;
  EliminationStructure structure_;
  std::vector<Block> diagonal_, lower_, upper_;  // lower_[k]: (later[k], pivot); upper_[k]: (pivot, later[k])
  std::vector<Block*> place_;                    // of the pattern's blocks
  std::vector<char> active_;
};

}  // namespace perp
