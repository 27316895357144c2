#include "contact_system.hpp"

#include <algorithm>
#include <cmath>

#include "velocity_operator.hpp"

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

/// The columns of each block row.
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
  return graph;
}

PackedBlocks pack(const FrictionMatrix& W, const std::vector<Eigen::Index>& offsets,
                  const std::vector<BlockKind>& kind) {
  auto graph = block_graph(W, offsets);
  PackedBlocks packed;
  packed.pattern = make_pattern(graph);
  packed.values.assign(packed.pattern.column.size(), Matrix3::Zero());
  const auto place = [&](int i, int j) -> Matrix3& { return packed.values[packed.pattern.find(i, j)]; };
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
    for (int i = 0; i < static_cast<int>(graph.size()); ++i)
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

/// Fills in what does not depend on how W is kept: kinds, scales from W's diagonal blocks, q, mu.
template <class Diagonal>
void scale(ContactSystem& system, const FrictionProblem& problem, const Vector& q, const Diagonal& diagonal) {
  const std::vector<Eigen::Index> offsets = problem.offsets();
  std::vector<double> mean_diagonal;
  for (int i = 0; i < system.n; ++i)
    mean_diagonal.push_back(diagonal(i).trace() / block_rows(system.kind[i]));
  system.s = block_scales(mean_diagonal);
  system.q = Columns3::Zero(3, system.n);
  for (int i = 0; i < system.n; ++i) {
    const Eigen::Index rows = offsets[i + 1] - offsets[i];
    system.q.col(i).segment(first_row(system.kind[i]), rows) = system.s[i] * q.segment(offsets[i], rows);
  }
  const double size = system.q.norm();
  system.sigma = size > 0 ? size : 1;
  system.q /= system.sigma;
  for (int i = 0; i < system.n; ++i)
    system.mu.push_back(system.kind[i] == BlockKind::Interval ? problem.mu(i) / (system.s[i] * system.sigma)
                                                              : problem.mu(i));
}

ContactSystem with_kinds(const FrictionProblem& problem) {
  ContactSystem system;
  system.n = static_cast<int>(problem.blocks());
  for (int i = 0; i < system.n; ++i) system.kind.push_back(problem.kind(i));
  return system;
}

}  // namespace

ContactSystem contact_system(const FrictionProblem& local) {
  ContactSystem system = with_kinds(local);
  PackedBlocks packed = pack(local.W, local.offsets(), system.kind);
  const BlockPattern& pattern = packed.pattern;
  scale(system, local, local.q, [&](int i) { return packed.values[pattern.find(i, i)]; });
  for (int i = 0; i < system.n; ++i)
    for (int e = pattern.row_start[i]; e < pattern.row_start[i + 1]; ++e)
      packed.values[e] *= system.s[i] * system.s[pattern.column[e]];
  system.W = std::make_unique<LocalOperator>(std::move(packed.pattern), std::move(packed.values));
  return system;
}

ContactSystem contact_system(const FrictionProblem& global, const MassResponse& response) {
  if (!VelocityOperator::suits(global)) return contact_system(to_local(global, response));
  ContactSystem system = with_kinds(global);
  Vector v_free, lambda;
  response.velocity(global.f, v_free, lambda);
  const Vector q = global.H.to_sparse().transpose() * v_free + global.w;
  auto W = std::make_unique<VelocityOperator>(global, system.kind);
  scale(system, global, q, [&](int i) { return W->diagonal(i); });
  W->scale(system.s);
  system.W = std::move(W);
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
