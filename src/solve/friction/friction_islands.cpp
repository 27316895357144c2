#include "solve/friction/friction_islands.hpp"

#include <numeric>

namespace perp {
namespace {

/// Disjoint sets of 0 ... n - 1.
class DisjointSets {
 public:
  explicit DisjointSets(Eigen::Index n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  Eigen::Index root(Eigen::Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void tie(Eigen::Index a, Eigen::Index b) { parent_[root(a)] = root(b); }

 private:
  std::vector<Eigen::Index> parent_;
};

/// Ties row + first_row to column + first_column for every entry.
void tie_entries(const FrictionMatrix& A, Eigen::Index first_row, Eigen::Index first_column,
                 DisjointSets& sets) {
  for (Eigen::Index c = 0; c < A.cols(); ++c) {
    if (A.is_sparse()) {
      for (SparseMatrix::InnerIterator it(A.sparse(), c); it; ++it)
        if (it.value() != 0) sets.tie(first_row + it.row(), first_column + c);
    } else {
      for (Eigen::Index r = 0; r < A.rows(); ++r)
        if (A.dense()(r, c) != 0) sets.tie(first_row + r, first_column + c);
    }
  }
}

FrictionMatrix part(const FrictionMatrix& A, const std::vector<Eigen::Index>& rows,
                    const std::vector<Eigen::Index>& columns) {
  if (!A.is_sparse()) return Matrix(A.dense()(rows, columns));
  std::vector<Eigen::Index> place(A.rows(), -1);
  for (size_t i = 0; i < rows.size(); ++i) place[rows[i]] = static_cast<Eigen::Index>(i);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t j = 0; j < columns.size(); ++j)
    for (SparseMatrix::InnerIterator it(A.sparse(), columns[j]); it; ++it)
      if (place[it.row()] >= 0) entries.emplace_back(place[it.row()], j, it.value());
  SparseMatrix result(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns.size()));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace

std::vector<FrictionIsland> friction_islands(const FrictionProblem& problem) {
  // nodes: rows of r, then velocities, then bilateral rows
  const Eigen::Index m = problem.rows(), n = problem.is_global() ? problem.M.rows() : 0;
  const Eigen::Index k = problem.is_global() ? problem.G.cols() : 0;
  const std::vector<Eigen::Index> offsets = problem.offsets();
  DisjointSets sets(m + n + k);
  for (Eigen::Index i = 0; i < problem.blocks(); ++i)
    for (Eigen::Index row = offsets[i] + 1; row < offsets[i + 1]; ++row) sets.tie(row, offsets[i]);
  if (problem.is_global()) {
    tie_entries(problem.M, m, m, sets);
    tie_entries(problem.H, m, 0, sets);
    if (k > 0) tie_entries(problem.G, m, m + n, sets);
  } else {
    tie_entries(problem.W, 0, 0, sets);
  }

  std::vector<Eigen::Index> island_of_root(m + n + k, -1);
  Eigen::Index count = 0;
  for (Eigen::Index row = 0; row < m; ++row)
    if (Eigen::Index& island = island_of_root[sets.root(row)]; island < 0) island = count++;
  std::vector<FrictionIsland> islands;
  if (count < 2) return islands;
  const auto members = [&](Eigen::Index first, Eigen::Index size) {  // of each island, counted from `first`
    std::vector<std::vector<Eigen::Index>> lists(count);
    for (Eigen::Index i = 0; i < size; ++i)
      if (const Eigen::Index island = island_of_root[sets.root(first + i)]; island >= 0)
        lists[island].push_back(i);
    return lists;
  };
  const auto rows = members(0, m), velocities = members(m, n), bilateral = members(m + n, k);
  islands.resize(count);
  for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
    FrictionProblem& p = islands[island_of_root[sets.root(offsets[i])]].problem;
    p.kinds.push_back(problem.kind(i));
    const auto append = [i](Vector& part, const Vector& whole) {
      if (whole.size() == 0) return;
      part.conservativeResize(part.size() + 1);
      part(part.size() - 1) = whole(i);
    };
    append(p.mu, problem.mu);
    append(p.mu_o, problem.mu_o);
    append(p.torsion, problem.torsion);
    append(p.rolling, problem.rolling);
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    FrictionProblem& p = islands[i].problem;
    islands[i].rows = rows[i];
    if (!problem.is_global()) {
      p.W = part(problem.W, rows[i], rows[i]);
      p.q = problem.q(rows[i]);
      continue;
    }
    if (velocities[i].empty()) {  // contacts of nothing that moves: u = w
      const auto size = static_cast<Eigen::Index>(rows[i].size());
      p.W = Matrix::Zero(size, size);
      p.q = problem.w(rows[i]);
      continue;
    }
    p.M = part(problem.M, velocities[i], velocities[i]);
    p.H = part(problem.H, velocities[i], rows[i]);
    p.f = problem.f(velocities[i]);
    p.w = problem.w(rows[i]);
    if (k == 0) continue;
    p.G = part(problem.G, velocities[i], bilateral[i]);
    p.b = problem.b.size() > 0 ? Vector(problem.b(bilateral[i])) : Vector();
  }
  return islands;
}

}  // namespace perp
