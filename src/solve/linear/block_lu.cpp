#include "solve/linear/block_lu.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/OrderingMethods>
#include <numeric>

namespace perp {
template <int B>
bool invert(Eigen::Matrix<double, B, B>& a) {
  // rows and columns of unit diagonal, to powers of two: lengths and angles may share a block, in any units
  Eigen::Matrix<double, B, 1> scale;
  for (int i = 0; i < B; ++i)
    scale[i] = a(i, i) == 0 || !std::isfinite(a(i, i)) ? 1 : std::ldexp(1.0, -std::ilogb(a(i, i)) / 2);
  a = scale.asDiagonal() * a * scale.asDiagonal();
  constexpr double rounding = 1e-15;
  const double least = rounding * a.cwiseAbs().maxCoeff();
  int pivot_row[B];
  for (int k = 0; k < B; ++k) {
    int p = k;
    for (int i = k + 1; i < B; ++i)
      if (std::abs(a(i, k)) > std::abs(a(p, k))) p = i;
    if (!(std::abs(a(p, k)) > least)) return false;
    pivot_row[k] = p;
    if (p != k) a.row(p).swap(a.row(k));
    const double inverse = 1 / a(k, k);
    a(k, k) = 1;
    a.row(k) *= inverse;
    for (int i = 0; i < B; ++i) {
      if (i == k) continue;
      const double factor = a(i, k);
      a(i, k) = 0;
      a.row(i) -= factor * a.row(k);
    }
  }
  for (int k = B - 1; k >= 0; --k)
    if (pivot_row[k] != k) a.col(pivot_row[k]).swap(a.col(k));
  a = scale.asDiagonal() * a * scale.asDiagonal();
  return true;
}

template bool invert<3>(Eigen::Matrix3d&);
template bool invert<6>(Eigen::Matrix<double, 6, 6>&);

int BlockPattern::find(int row, int col) const {
  const auto first = column.begin() + row_start[row], last = column.begin() + row_start[row + 1];
  return static_cast<int>(std::lower_bound(first, last, col) - column.begin());
}

BlockPattern make_pattern(std::vector<std::vector<int>>& rows) {
  BlockPattern pattern;
  pattern.row_start.push_back(0);
  for (std::vector<int>& row : rows) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    pattern.column.insert(pattern.column.end(), row.begin(), row.end());
    pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
  }
  return pattern;
}

std::vector<int> elimination_order(const BlockPattern& pattern) {
  const int n = pattern.size();
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  const auto blocks = static_cast<long>(pattern.column.size());
  if (n <= 3 || blocks == long{n} * n) return order;
  Eigen::SparseMatrix<double> graph(n, n);
  graph.resizeNonZeros(pattern.column.size());
  std::copy(pattern.row_start.begin(), pattern.row_start.end(), graph.outerIndexPtr());
  std::copy(pattern.column.begin(), pattern.column.end(), graph.innerIndexPtr());
  std::fill_n(graph.valuePtr(), graph.nonZeros(), 1.0);
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(graph, permutation);
  std::copy_n(permutation.indices().data(), n, order.begin());
  return order;
}

EliminationStructure eliminate(const BlockPattern& pattern, const std::vector<int>& order,
                               const std::vector<int>& rank) {
  const int n = pattern.size();
  EliminationStructure structure;
  structure.start.assign(1, 0);
  structure.start.reserve(n + 1);
  std::vector<std::vector<int>> children(n);  // pivots whose first later pivot is this one
  std::vector<int> mark(n, -1);
  for (int k = 0; k < n; ++k) {
    const auto begin = structure.later.size();
    mark[k] = k;
    const auto add = [&](int i) {
      if (i > k && mark[i] != k) {
        mark[i] = k;
        structure.later.push_back(i);
      }
    };
    const auto row = order[k];
    for (int e = pattern.row_start[row]; e < pattern.row_start[row + 1]; ++e) add(rank[pattern.column[e]]);
    for (const int child : children[k])
      for (int e = structure.start[child]; e < structure.start[child + 1]; ++e) add(structure.later[e]);
    std::sort(structure.later.begin() + static_cast<std::ptrdiff_t>(begin), structure.later.end());
    if (structure.later.size() > begin) children[structure.later[begin]].push_back(k);
    structure.start.push_back(static_cast<int>(structure.later.size()));
  }
  return structure;
}

template <int B>
void BlockLu<B>::analyze(const BlockPattern& pattern) {
  const int n = pattern.size();
  order_ = elimination_order(pattern);
  rank_.resize(n);
  for (int k = 0; k < n; ++k) rank_[order_[k]] = k;
  structure_ = eliminate(pattern, order_, rank_);
  diagonal_.resize(n);
  lower_.resize(structure_.later.size());
  upper_.resize(structure_.later.size());
  active_.assign(n, true);
  place_.resize(pattern.column.size());
  for (int row = 0; row < n; ++row)
    for (auto e = pattern.row_start[row]; e < pattern.row_start[row + 1]; ++e) {
      const int i = rank_[row], j = rank_[pattern.column[e]];
      if (i == j) {
        place_[e] = &diagonal_[i];
        continue;
      }
      const auto first = structure_.later.begin() + structure_.start[std::min(i, j)];
      const auto last = structure_.later.begin() + structure_.start[std::min(i, j) + 1];
      const auto at = std::lower_bound(first, last, std::max(i, j)) - structure_.later.begin();
      place_[e] = i > j ? &lower_[at] : &upper_[at];
    }
}

template <int B>
void BlockLu<B>::clear() {
  const auto zero = [](std::vector<Block>& blocks) {
    for (Block& block : blocks) block.setZero();
  };
  zero(diagonal_);
  zero(lower_);
  zero(upper_);
  std::fill(active_.begin(), active_.end(), true);
}

template <int B>
bool BlockLu<B>::factor() {
  const int n = static_cast<int>(order_.size());
  const int* later = structure_.later.data();
  for (int k = 0; k < n; ++k) {
    if (!active_[k]) continue;
    Block& inverse = diagonal_[k];
    if (!invert<B>(inverse)) return false;
    const int begin = structure_.start[k];
    const int end = structure_.start[k + 1];
    for (int e = begin; e < end; ++e) {
      Block& u = upper_[e];
      u = (inverse * u).eval();
    }
    // Schur complement: A_rc -= A_rk A_kk^-1 A_kc for all later r, c that k couples
    for (int p = begin; p < end; ++p) {
      const int c = later[p];
      if (!active_[c]) continue;
      const Block lower_p = lower_[p], upper_p = upper_[p];
      diagonal_[c].noalias() -= lower_p * upper_p;
      int at = structure_.start[c];
      for (int s = p + 1; s < end; ++s) {
        const int r = later[s];
        while (later[at] != r) ++at;
        if (!active_[r]) continue;
        lower_[at].noalias() -= lower_[s] * upper_p;
        upper_[at].noalias() -= lower_p * upper_[s];
      }
    }
  }
  return true;
}

template <int B>
void BlockLu<B>::solve(Columns& x) const {
  const int n = static_cast<int>(order_.size());
  for (int k = 0; k < n; ++k) {
    if (!active_[k]) continue;
    const int row = order_[k];
    x.col(row) = (diagonal_[k] * x.col(row)).eval();
    const Eigen::Matrix<double, B, 1> y = x.col(row);
    for (int e = structure_.start[k]; e < structure_.start[k + 1]; ++e) {
      const int r = structure_.later[e];
      if (active_[r]) x.col(order_[r]).noalias() -= lower_[e] * y;
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    if (!active_[k]) continue;
    auto y = x.col(order_[k]);
    for (int e = structure_.start[k]; e < structure_.start[k + 1]; ++e) {
      const int c = structure_.later[e];
      if (active_[c]) y.noalias() -= upper_[e] * x.col(order_[c]);
    }
  }
}

template <int B>
double BlockLu<B>::factor_work() const {
  double blocks = 0;  // inverses and products
  for (size_t k = 0; k < order_.size(); ++k) {
    const double later = structure_.start[k + 1] - structure_.start[k];
    blocks += 1 + later + later * later;
  }
  return B * B * B * blocks;
}

template <int B>
double BlockLu<B>::solve_work() const {
  return B * B * (static_cast<double>(order_.size()) + 2 * static_cast<double>(structure_.later.size()));
}

template class BlockLu<3>;
template class BlockLu<6>;

}  // namespace perp
