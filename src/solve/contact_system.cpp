#include "contact_system.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

/// Which blocks of W are not zero, made symmetric, and their values.
struct PackedBlocks {
  BlockPattern pattern;
  Blocks3 values;
};

std::vector<int> block_of_row(const std::vector<Eigen::Index>& offsets) {
  std::vector<int> block(offsets.back());
  for (size_t i = 0; i + 1 < offsets.size(); ++i)
    std::fill(block.begin() + offsets[i], block.begin() + offsets[i + 1], static_cast<int>(i));
  return block;
}

/// Sorted lists of the columns of each block row.
std::vector<std::vector<int>> block_graph(const FrictionMatrix& W, const std::vector<Eigen::Index>& offsets) {
  const size_t n = offsets.size() - 1;
  std::vector<std::vector<int>> graph(n);
  for (size_t i = 0; i < n; ++i) graph[i].push_back(static_cast<int>(i));
  const auto couple = [&](size_t i, size_t j) {
    graph[i].push_back(static_cast<int>(j));
    graph[j].push_back(static_cast<int>(i));
  };
  if (W.is_sparse()) {
    const std::vector<int> block = block_of_row(offsets);
    for (Eigen::Index c = 0; c < W.cols(); ++c)
      for (SparseMatrix::InnerIterator it(W.sparse(), c); it; ++it) {
        const int i = block[it.row()], j = block[c];
        if (i != j) couple(i, j);
      }
  } else {
    for (size_t i = 0; i < n; ++i)
      for (size_t j = 0; j < n; ++j) {
        if (i == j) continue;
        const auto part =
            W.dense().block(offsets[i], offsets[j], offsets[i + 1] - offsets[i], offsets[j + 1] - offsets[j]);
        if ((part.array() != 0).any()) couple(i, j);
      }
  }
  for (auto& row : graph) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  return graph;
}

PackedBlocks pack(const FrictionMatrix& W, const std::vector<Eigen::Index>& offsets,
                  const std::vector<BlockKind>& kind) {
  const auto graph = block_graph(W, offsets);
  PackedBlocks packed;
  packed.pattern.row_start.push_back(0);
  for (const auto& row : graph) {
    packed.pattern.column.insert(packed.pattern.column.end(), row.begin(), row.end());
    packed.pattern.row_start.push_back(static_cast<int>(packed.pattern.column.size()));
  }
  packed.values.assign(packed.pattern.column.size(), Matrix3::Zero());
  const auto place = [&](size_t i, int j) -> Matrix3& {
    const auto first = packed.pattern.column.begin() + packed.pattern.row_start[i];
    const auto last = packed.pattern.column.begin() + packed.pattern.row_start[i + 1];
    return packed.values[std::lower_bound(first, last, j) - packed.pattern.column.begin()];
  };
  if (W.is_sparse()) {
    const std::vector<int> block = block_of_row(offsets);
    for (Eigen::Index c = 0; c < W.cols(); ++c) {
      const int j = block[c];
      for (SparseMatrix::InnerIterator it(W.sparse(), c); it; ++it) {
        const auto i = block[it.row()];
        place(i, j)(it.row() - offsets[i] + first_row(kind[i]), c - offsets[j] + first_row(kind[j])) +=
            it.value();
      }
    }
  } else {
    for (size_t i = 0; i < graph.size(); ++i)
      for (const int j : graph[i]) {
        const Eigen::Index rows = offsets[i + 1] - offsets[i];
        const Eigen::Index cols = offsets[j + 1] - offsets[j];
        place(i, j).block(first_row(kind[i]), first_row(kind[j]), rows, cols) =
            W.dense().block(offsets[i], offsets[j], rows, cols);
      }
  }
  return packed;
}

/// s_i = (tr W_ii / rows_i)^(-1/2); blocks without a positive trace take the mean of the others.
std::vector<double> block_scales(const std::vector<double>& mean_diagonal) {
  double sum = 0;
  int count = 0;
  for (const double d : mean_diagonal)
    if (d > 0) sum += d, ++count;
  const double fallback = count > 0 ? sum / count : 1;
  std::vector<double> s;
  for (const double d : mean_diagonal) s.push_back(1 / std::sqrt(d > 0 ? d : fallback));
  return s;
}

}  // namespace

ContactSystem contact_system(const FrictionProblem& local) {
  const std::vector<Eigen::Index> offsets = local.offsets();
  ContactSystem system;
  system.n = static_cast<int>(local.blocks());
  for (int i = 0; i < system.n; ++i) system.kind.push_back(local.kind(i));
  PackedBlocks packed = pack(local.W, offsets, system.kind);
  std::vector<double> mean_diagonal;
  for (int i = 0; i < system.n; ++i) {
    for (int e = packed.pattern.row_start[i]; e < packed.pattern.row_start[i + 1]; ++e)
      if (packed.pattern.column[e] == i)
        mean_diagonal.push_back(packed.values[e].trace() / block_rows(system.kind[i]));
  }
  system.s = block_scales(mean_diagonal);
  system.q = Columns3::Zero(3, system.n);
  for (int i = 0; i < system.n; ++i) {
    const Eigen::Index rows = offsets[i + 1] - offsets[i];
    system.q.col(i).segment(first_row(system.kind[i]), rows) =
        system.s[i] * local.q.segment(offsets[i], rows);
    for (int e = packed.pattern.row_start[i]; e < packed.pattern.row_start[i + 1]; ++e) {
      const auto at = e;
      packed.values[at] *= system.s[i] * system.s[packed.pattern.column[at]];
    }
  }
  const double size = system.q.norm();
  system.sigma = size > 0 ? size : 1;
  system.q /= system.sigma;
  for (int i = 0; i < system.n; ++i) {
    const double mu = local.mu(i);
    system.mu.push_back(system.kind[i] == BlockKind::Interval ? mu / (system.s[i] * system.sigma) : mu);
  }
  system.W = std::make_unique<LocalOperator>(std::move(packed.pattern), std::move(packed.values));
  return system;
}

Columns3 ContactSystem::scaled_reaction(const Vector& r, const std::vector<Eigen::Index>& offsets) const {
  Columns3 scaled = Columns3::Zero(3, n);
  for (int i = 0; i < n; ++i) {
    const Eigen::Index rows = offsets[i + 1] - offsets[i];
    scaled.col(i).segment(first_row(kind[i]), rows) = r.segment(offsets[i], rows) / (s[i] * sigma);
  }
  return scaled;
}

Vector ContactSystem::reaction(const Columns3& scaled, const std::vector<Eigen::Index>& offsets) const {
  Vector r(offsets.back());
  for (int i = 0; i < n; ++i) {
    const Eigen::Index rows = offsets[i + 1] - offsets[i];
    r.segment(offsets[i], rows) = scaled.col(i).segment(first_row(kind[i]), rows) * (s[i] * sigma);
  }
  return r;
}

}  // namespace perp
