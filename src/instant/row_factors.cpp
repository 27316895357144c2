#include "instant/row_factors.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <map>
#include <numeric>

namespace perp {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

/// Whether no row of N, of unit diagonal, is one of the others' but for rounding: a pivot's square root tells.
bool has_full_rank(const Matrix& N) {
  const Eigen::LLT<Matrix> llt(N);
  return llt.info() == Eigen::Success && llt.matrixLLT().diagonal().minCoeff() > 1e-6;
}

}  // namespace

Matrix range_basis(const Matrix& N) {
  if (N.rows() == 0) return {};
  const Vector scale = N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * N * scale.asDiagonal();
  if (has_full_rank(scaled)) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < N.rows(); ++i)
    if (eigen.eigenvalues()[i] > 1e-11 * static_cast<double>(N.rows())) kept.push_back(i);
  return scale.asDiagonal() * Matrix(eigen.eigenvectors()(Eigen::all, kept));
}

void RowFactors::arrange(const Rows& rows, std::vector<char> on) {
  if (on.empty()) on.assign(at(rows.size()), 1);
  const std::vector<RowGroup>& groups = rows.groups();
  const int n = static_cast<int>(groups.size());
  std::map<int, std::vector<std::array<int, 2>>> of_body;  // groups with their side, of bodies that move
  nv_ = 0;
  for (int g = 0; g < n; ++g)
    for (int side = 0; side < 2; ++side) {
      const RowGroup& group = groups[at(g)];
      if (group.n[side] > 0) of_body[group.body[side]].push_back({g, side});
      nv_ = std::max<Eigen::Index>(nv_, group.v[side] + group.n[side]);
    }
  std::vector<int> root(at(n));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int g) {
    while (root[at(g)] != g) g = root[at(g)] = root[at(root[at(g)])];
    return g;
  };
  std::vector<std::vector<int>> graph(at(n));
  for (int g = 0; g < n; ++g) graph[at(g)].push_back(g);
  for (const auto& [body, of] : of_body)
    for (const auto& [g, g_side] : of) {
      const int a = find(g), b = find(of.front()[0]);
      root[at(std::max(a, b))] = std::min(a, b);
      for (const auto& [h, h_side] : of) graph[at(g)].push_back(h);
    }
  pattern_ = make_pattern(graph);
  couples_.clear();
  for (const auto& [body, of] : of_body)
    for (const auto& [g, g_side] : of)
      for (const auto& [h, h_side] : of) couples_.push_back({g, g_side, h, h_side, pattern_.find(g, h)});
  values_.resize(pattern_.column.size());

  parts_.clear();
  place_.assign(at(rows.size()), -1);
  part_.assign(at(n), -1);
  std::vector<int> number(at(n), -1);
  for (int g = 0; g < n; ++g) {
    const RowGroup& group = groups[at(g)];
    const auto first = on.begin() + group.first;
    if (std::none_of(first, first + group.count, [](char take) { return take != 0; })) continue;
    int& part = number[at(find(g))];
    if (part < 0) {
      part = static_cast<int>(parts_.size());
      parts_.emplace_back();
    }
    part_[at(g)] = part;
    parts_[at(part)].groups.push_back(g);
    for (int i = group.first; i < group.first + group.count; ++i)
      if (on[at(i)] != 0) {
        place_[at(i)] = static_cast<int>(parts_[at(part)].rows.size());
        parts_[at(part)].rows.push_back(i);
      }
  }
  for (Part& part : parts_) part.dense = part.rows.size() <= few;
  lu_ = {};
}

/// N's blocks, of which those of rows that do not take part are the identity's.
void RowFactors::assemble(const Rows& rows, const Rows::Response& Y) {
  const std::vector<RowGroup>& groups = rows.groups();
  for (RowGroup::Block& value : values_) value.setZero();
  for (const Couple& k : couples_)
    values_[at(k.place)].noalias() +=
        groups[at(k.row)].R[k.row_side].transpose() * Y[at(k.column)][at(k.column_side)];
  const auto takes_part = [&](const RowGroup& g, int i) {
    return i < g.count && place_[at(g.first + i)] >= 0;
  };
  for (int g = 0; g < static_cast<int>(groups.size()); ++g)
    for (int e = pattern_.row_start[at(g)]; e < pattern_.row_start[at(g) + 1]; ++e) {
      const int h = pattern_.column[at(e)];
      RowGroup::Block& value = values_[at(e)];
      for (int i = 0; i < 6; ++i) {
        const bool row = takes_part(groups[at(g)], i);
        if (!row) value.row(i).setZero();
        if (!takes_part(groups[at(h)], i)) value.col(i).setZero();
        if (g == h && !row) value(i, i) = 1;
      }
    }
}

void RowFactors::gather(const Rows& rows, Part& part) const {
  const std::vector<RowGroup>& groups = rows.groups();
  const auto size = static_cast<Eigen::Index>(part.rows.size());
  part.N.setZero(size, size);
  for (const int g : part.groups)
    for (int e = pattern_.row_start[at(g)]; e < pattern_.row_start[at(g) + 1]; ++e) {
      const RowGroup &row = groups[at(g)], &column = groups[at(pattern_.column[at(e)])];
      for (int i = 0; i < row.count; ++i)
        for (int j = 0; j < column.count; ++j) {
          const int to_row = place_[at(row.first + i)], to_column = place_[at(column.first + j)];
          if (to_row >= 0 && to_column >= 0) part.N(to_row, to_column) = values_[at(e)](i, j);
        }
    }
}

void RowFactors::factor(const Rows& rows, const Rows::Response& Y) {
  assemble(rows, Y);
  bool any_block = false;
  for (Part& part : parts_) {
    if (in_blocks(part)) {
      any_block = true;
      continue;
    }
    gather(rows, part);
    if (part.V.size() > 0)
      part.lu.compute(part.V.transpose() * part.N * part.V);
    else
      part.lu.compute(part.N);
  }
  if (!any_block || factor_blocks()) return;
  for (Part& part : parts_) {
    if (!in_blocks(part)) continue;
    part.dense = true;
    gather(rows, part);
    part.lu.compute(part.N);
  }
}

bool RowFactors::factor_blocks() {
  if (!lu_.analyzed()) lu_.analyze(pattern_);
  lu_.clear();
  for (int g = 0; g < pattern_.size(); ++g) {
    if (part_[at(g)] < 0 || !in_blocks(parts_[at(part_[at(g)])])) {
      lu_.leave_out(g);
      continue;
    }
    for (int e = pattern_.row_start[at(g)]; e < pattern_.row_start[at(g) + 1]; ++e)
      lu_.set(e, values_[at(e)]);
  }
  return lu_.factor();
}

bool RowFactors::is_regular(const Part& part) const {
  constexpr double least = 1e-12;  // share of a diagonal entry: the sine squared of a row to those before it
  for (const int g : part.groups) {
    const RowGroup::Block& N = values_[at(pattern_.find(g, g))];
    const RowGroup::Block& inverse = lu_.inverse_pivot(g);
    for (int i = 0; i < 6; ++i)
      if (!(N(i, i) * inverse(i, i) * least < 1)) return false;
  }
  return true;
}

void RowFactors::find_dependent(const Rows& rows, const Rows::Response& Y, double threshold) {
  for (Part& part : parts_) part.Z.resize(0, 0), part.V.resize(0, 0);
  assemble(rows, Y);
  const bool blocks = std::any_of(parts_.begin(), parts_.end(), in_blocks);
  const bool factored = blocks && factor_blocks();
  for (Part& part : parts_) {
    if (factored && in_blocks(part) && is_regular(part)) continue;
    gather(rows, part);
    const auto n = static_cast<Eigen::Index>(part.rows.size());
    const Vector scale = part.N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Matrix scaled = scale.asDiagonal() * part.N * scale.asDiagonal();
    if (has_full_rank(scaled)) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
    const Eigen::Index count = (eigen.eigenvalues().array() <= threshold * static_cast<double>(n)).count();
    if (count > 0) part.Z = scale.asDiagonal() * Matrix(eigen.eigenvectors().leftCols(count));  // ascending
  }
}

void RowFactors::solve_least(const Rows& rows, const Rows::Response& Y, const Vector& b, Vector& c) {
  assemble(rows, Y);
  c.setZero(rows.size());
  std::vector<Matrix> V;
  for (Part& part : parts_) V.emplace_back(std::move(part.V)), part.V.resize(0, 0);
  const bool blocks = std::any_of(parts_.begin(), parts_.end(), in_blocks);
  const bool factored = blocks && factor_blocks();
  if (factored) solve_blocks(rows, b, c);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    if (!(factored && in_blocks(part) && is_regular(part))) {
      gather(rows, part);
      const Matrix basis = range_basis(part.N);
      const Vector rhs = b(part.rows);
      if (basis.size() == 0)
        c(part.rows) = part.N.llt().solve(rhs);
      else
        c(part.rows) = basis * (basis.transpose() * part.N * basis).llt().solve(basis.transpose() * rhs);
    }
    part.V = std::move(V[i]);
  }
}

void RowFactors::solve_blocks(const Rows& rows, const Vector& b, Vector& c) {
  const std::vector<RowGroup>& groups = rows.groups();
  columns_.setZero(6, static_cast<Eigen::Index>(groups.size()));
  for (const Part& part : parts_) {
    if (!in_blocks(part)) continue;
    for (const int g : part.groups) {
      const RowGroup& group = groups[at(g)];
      for (int i = 0; i < group.count; ++i)
        if (place_[at(group.first + i)] >= 0) columns_(i, g) = b[group.first + i];
    }
  }
  lu_.solve(columns_);
  for (const Part& part : parts_) {
    if (!in_blocks(part)) continue;
    for (const int g : part.groups) {
      const RowGroup& group = groups[at(g)];
      for (int i = 0; i < group.count; ++i)
        if (place_[at(group.first + i)] >= 0) c[group.first + i] += columns_(i, g);
    }
  }
}

void RowFactors::solve_dense(const Part& part, const Vector& b, Vector& c) const {
  if (part.V.size() > 0)
    c(part.rows) = part.V * part.lu.solve(part.V.transpose() * b(part.rows));
  else
    c(part.rows) = part.lu.solve(b(part.rows));
}

void RowFactors::solve(const Rows& rows, const Rows::Response& Y, const Vector& b, Vector& c) {
  constexpr double enough = 1e-13, failed = 1e-8;  // of |b|
  c.setZero(rows.size());
  bool any_block = false;
  for (const Part& part : parts_) {
    if (in_blocks(part))
      any_block = true;
    else
      solve_dense(part, b, c);
  }
  if (!any_block) return;
  solve_blocks(rows, b, c);
  const auto miss = [&] {
    nu_.setZero(nv_);
    rows.add_response(Y, c, nu_);
    rows.velocity(nu_, missed_);
    missed_ = b - missed_;
    double largest = 0;
    for (const Part& part : parts_)
      if (in_blocks(part))
        for (const int i : part.rows) largest = std::max(largest, std::abs(missed_[i]));
    return std::isfinite(largest) ? largest : infinity;
  };
  const double size = b.cwiseAbs().maxCoeff();
  double left = miss();
  if (left > enough * size) {
    solve_blocks(rows, missed_, c);
    left = miss();
  }
  if (left <= failed * size) return;
  for (Part& part : parts_) {
    if (!in_blocks(part)) continue;
    part.dense = true;
    gather(rows, part);
    part.lu.compute(part.N);
    solve_dense(part, b, c);
  }
}

}  // namespace perp
