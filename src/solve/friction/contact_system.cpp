#include "solve/friction/contact_system.hpp"

#include <algorithm>
#include <cmath>

#include "solve/friction/velocity_operator.hpp"

namespace perp {
namespace {

/// Which blocks of W are not zero, made symmetric, and their values.
template <int R>
struct PackedBlocks {
  BlockPattern pattern;
  Squares<R> values;
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

template <int R>
PackedBlocks<R> pack(const FrictionMatrix& W, const std::vector<Eigen::Index>& offsets,
                     const std::vector<const BlockLayout*>& layout) {
  auto graph = block_graph(W, offsets);
  PackedBlocks<R> packed;
  packed.pattern = make_pattern(graph);
  packed.values.assign(packed.pattern.column.size(), Square<R>::Zero());
  const auto place = [&](int i, int j) -> Square<R>& { return packed.values[packed.pattern.find(i, j)]; };
  if (W.is_sparse()) {
    const std::vector<int> block = block_of_row(offsets);
    for (Eigen::Index c = 0; c < W.cols(); ++c) {
      const int j = block[c];
      for (SparseMatrix::InnerIterator it(W.sparse(), c); it; ++it) {
        const auto i = block[it.row()];
        place(i, j)(layout[i]->place[it.row() - offsets[i]], layout[j]->place[c - offsets[j]]) += it.value();
      }
    }
  } else {
    for (int i = 0; i < static_cast<int>(graph.size()); ++i)
      for (const int j : graph[i]) {
        Square<R>& value = place(i, j);
        for (int c = 0; c < layout[j]->rows; ++c)
          for (int r = 0; r < layout[i]->rows; ++r)
            value(layout[i]->place[r], layout[j]->place[c]) = W.dense()(offsets[i] + r, offsets[j] + c);
      }
  }
  return packed;
}

/// Rows of one unit: velocities (N, T1, T2), the spin, the rolling rows. A bound of constant size has one unit.
int unit_of(const BlockLayout& layout, int place) {
  return !layout.contact || place < 3 ? 0 : place == 3 ? 1 : 2;
}

/// s = (mean of W's diagonal over the rows of a unit)^(-1/2). Where that is not positive, the mean over all blocks of the first unit stands
/// in, for moments times the squared bound that makes a length of them.
template <int R, class Diagonal>
void find_scales(ContactSystem<R>& system, const FrictionProblem& problem, const Diagonal& diagonal) {
  const auto mean = [&](int i, int unit) {
    double sum = 0;
    int count = 0;
    for (int k = system.layout[i]->rows - 1; k >= 0; --k) {
      const int place = system.layout[i]->place[k];
      if (unit_of(*system.layout[i], place) == unit) sum += diagonal(i)(place, place), ++count;
    }
    return count > 0 ? sum / count : 0;
  };
  double sum = 0;
  int count = 0;
  for (int i = 0; i < system.n; ++i)
    if (const double d = mean(i, 0); d > 0) sum += d, ++count;
  const double fallback = count > 0 ? sum / count : 1;
  system.s = Columns<R>::Ones(R, system.n);
  for (int i = 0; i < system.n; ++i) {
    const double d = mean(i, 0);
    system.s.col(i).setConstant(1 / std::sqrt(d > 0 ? d : fallback));
    for (int k = 0; k < system.layout[i]->rows; ++k) {
      const int place = system.layout[i]->place[k], unit = unit_of(*system.layout[i], place);
      if (unit == 0) continue;
      const double moment = mean(i, unit), length = semi_axis(problem, i, place);
      if (moment > 0)
        system.s(place, i) = 1 / std::sqrt(moment);
      else if (length > 0)
        system.s(place, i) *= length;
    }
  }
}

/// Fills in what does not depend on how W is kept: scales from W's diagonal blocks, q, the bounds.
template <int R, class Diagonal>
void scale(ContactSystem<R>& system, const FrictionProblem& problem, const Vector& q,
           const Diagonal& diagonal) {
  const std::vector<Eigen::Index> offsets = problem.offsets();
  find_scales(system, problem, diagonal);
  system.q = Columns<R>::Zero(R, system.n);
  for (int i = 0; i < system.n; ++i)
    for (int k = 0; k < system.layout[i]->rows; ++k) {
      const int place = system.layout[i]->place[k];
      system.q(place, i) = system.s(place, i) * q(offsets[i] + k);
    }
  const double size = system.q.norm();
  system.sigma = size > 0 ? size : 1;
  system.q /= system.sigma;
  for (int i = 0; i < system.n; ++i)
    system.block.push_back(make_block<R>(problem, i, system.s.col(i), system.sigma));
}

template <int R>
ContactSystem<R> with_layouts(const FrictionProblem& problem) {
  ContactSystem<R> system;
  system.n = static_cast<int>(problem.blocks());
  for (int i = 0; i < system.n; ++i) system.layout.push_back(&layout_of(problem.kind(i)));
  return system;
}

}  // namespace

template <int R>
ContactSystem<R> contact_system(const FrictionProblem& local) {
  ContactSystem<R> system = with_layouts<R>(local);
  PackedBlocks<R> packed = pack<R>(local.W, local.offsets(), system.layout);
  const BlockPattern& pattern = packed.pattern;
  const Squares<R>& values = packed.values;
  scale(system, local, local.q,
        [&pattern, &values](int i) -> const Square<R>& { return values[pattern.find(i, i)]; });
  for (int i = 0; i < system.n; ++i)
    for (int e = pattern.row_start[i]; e < pattern.row_start[i + 1]; ++e)
      packed.values[e].array() *= (system.s.col(i) * system.s.col(pattern.column[e]).transpose()).array();
  system.W = std::make_unique<LocalOperator<R>>(std::move(packed.pattern), std::move(packed.values));
  return system;
}

template <int R>
ContactSystem<R> contact_system(const FrictionProblem& global, const MassResponse& response) {
  if (!VelocityOperator<R>::suits(global)) return contact_system<R>(to_local(global, response));
  ContactSystem<R> system = with_layouts<R>(global);
  Vector v_free, lambda;
  response.velocity(global.f, v_free, lambda);
  const Vector q = global.H.to_sparse().transpose() * v_free + global.w;
  auto W = std::make_unique<VelocityOperator<R>>(global, system.layout);
  scale(system, global, q, [&](int i) -> const Square<R>& { return W->diagonal(i); });
  W->scale(system.s);
  system.W = std::move(W);
  return system;
}

template <int R>
Columns<R> ContactSystem<R>::scaled_reaction(const Vector& r,
                                             const std::vector<Eigen::Index>& offsets) const {
  Columns<R> scaled = Columns<R>::Zero(R, n);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < layout[i]->rows; ++k) {
      const int place = layout[i]->place[k];
      scaled(place, i) = r(offsets[i] + k) / (s(place, i) * sigma);
    }
  return scaled;
}

template <int R>
Vector ContactSystem<R>::reaction(const Columns<R>& scaled, const std::vector<Eigen::Index>& offsets) const {
  Vector r(offsets.back());
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < layout[i]->rows; ++k) {
      const int place = layout[i]->place[k];
      r(offsets[i] + k) = scaled(place, i) * (s(place, i) * sigma);
    }
  return r;
}

template struct ContactSystem<3>;
template struct ContactSystem<6>;
template ContactSystem<3> contact_system<3>(const FrictionProblem&);
template ContactSystem<6> contact_system<6>(const FrictionProblem&);
template ContactSystem<3> contact_system<3>(const FrictionProblem&, const MassResponse&);
template ContactSystem<6> contact_system<6>(const FrictionProblem&, const MassResponse&);

}  // namespace perp
