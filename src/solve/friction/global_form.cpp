#include "solve/friction/global_form.hpp"

#include <Eigen/LU>
#include <numeric>
#include <vector>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr Eigen::Index largest_block = 40;  // bodies have 6 rows; larger blocks are left to the sparse LU

/// M^-1 block by block; empty if a block is large. Throws if one is singular.
SparseMatrix block_inverse(const SparseMatrix& M) {
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<int> local(M.rows());
  for (const std::vector<int>& rows : connected_blocks(M)) {
    const auto size = static_cast<Eigen::Index>(rows.size());
    if (size > largest_block) return {};
    for (int i = 0; i < size; ++i) local[rows[i]] = i;
    Matrix block = Matrix::Zero(size, size);
    for (const int c : rows)
      for (SparseMatrix::InnerIterator it(M, c); it; ++it) block(local[it.row()], local[c]) += it.value();
    if (size == 1) {
      if (block(0, 0) == 0) refuse("FrictionProblem", "M", "singular", "an invertible mass matrix is needed");
      entries.emplace_back(rows[0], rows[0], 1 / block(0, 0));
      continue;
    }
    const Eigen::PartialPivLU<Matrix> lu(block);
    const Vector pivots = lu.matrixLU().diagonal().cwiseAbs();
    if (!(pivots.minCoeff() > 1e-14 * pivots.maxCoeff()))
      refuse("FrictionProblem", "M", "singular", "an invertible mass matrix is needed");
    const Matrix inverse = lu.inverse();
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < size; ++j)
        if (inverse(i, j) != 0) entries.emplace_back(rows[i], rows[j], inverse(i, j));
  }
  SparseMatrix inverse(M.rows(), M.rows());
  inverse.setFromTriplets(entries.begin(), entries.end());
  return inverse;
}

}  // namespace

std::vector<std::vector<int>> connected_blocks(const SparseMatrix& M) {
  std::vector<int> root(M.rows());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (int c = 0; c < M.cols(); ++c)
    for (SparseMatrix::InnerIterator it(M, c); it; ++it) {
      if (root[it.row()] == root[c]) continue;
      const int a = find(static_cast<int>(it.row())), b = find(c);
      root[std::max(a, b)] = std::min(a, b);
    }
  std::vector<std::vector<int>> blocks;
  std::vector<int> number(M.rows(), -1);
  for (int i = 0; i < M.rows(); ++i) {
    int& block = number[find(i)];
    if (block < 0) {
      block = static_cast<int>(blocks.size());
      blocks.emplace_back();
    }
    blocks[block].push_back(i);
  }
  return blocks;
}

MassResponse::MassResponse(const FrictionProblem& global)
    : n_(global.M.rows()), k_(global.G.cols()), b_(global.b), kkt_(n_ + k_, n_ + k_) {
  const SparseMatrix M = global.M.to_sparse();
  if (k_ == 0) {
    inverse_ = block_inverse(M);
    kkt_ = M;
    if (inverse_.rows() > 0) return;
  } else {
    const SparseMatrix G = global.G.to_sparse();
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index c = 0; c < n_; ++c)
      for (SparseMatrix::InnerIterator it(M, c); it; ++it) entries.emplace_back(it.row(), c, it.value());
    for (Eigen::Index c = 0; c < k_; ++c)
      for (SparseMatrix::InnerIterator it(G, c); it; ++it) {
        entries.emplace_back(it.row(), n_ + c, -it.value());
        entries.emplace_back(n_ + c, it.row(), it.value());
      }
    kkt_.setFromTriplets(entries.begin(), entries.end());
  }
  lu_ = std::make_unique<Eigen::SparseLU<SparseMatrix>>(kkt_);
  if (lu_->info() != Eigen::Success)
    refuse("FrictionProblem", "[M -G; G^T 0]", "singular", "an invertible matrix is needed");
}

Vector MassResponse::solve(const Vector& rhs) const {
  return lu_ ? Vector(lu_->solve(rhs)) : Vector(inverse_ * rhs);
}

void MassResponse::velocity(const Vector& load, Vector& v, Vector& lambda) const {
  Vector rhs(n_ + k_);
  rhs.head(n_) = load;
  if (k_ > 0) rhs.tail(k_) = -b_;
  Vector x = solve(rhs);
  x += solve(rhs - kkt_ * x);
  v = x.head(n_);
  lambda = x.tail(k_);
}

SparseMatrix MassResponse::times(const SparseMatrix& H) const {
  if (!lu_) return inverse_ * H;
  std::vector<Eigen::Triplet<double>> entries;
  Vector rhs(n_ + k_);
  for (Eigen::Index c = 0; c < H.cols(); ++c) {
    rhs.setZero();
    for (SparseMatrix::InnerIterator it(H, c); it; ++it) rhs(it.row()) += it.value();
    Vector x = solve(rhs);
    x += solve(rhs - kkt_ * x);
    for (Eigen::Index i = 0; i < n_; ++i)
      if (x(i) != 0) entries.emplace_back(i, c, x(i));
  }
  SparseMatrix AH(n_, H.cols());
  AH.setFromTriplets(entries.begin(), entries.end());
  return AH;
}

FrictionProblem to_local(const FrictionProblem& problem) {
  return problem.is_global() ? to_local(problem, MassResponse(problem)) : problem;
}

FrictionProblem to_local(const FrictionProblem& problem, const MassResponse& response) {
  const SparseMatrix H = problem.H.to_sparse();
  FrictionProblem local;
  local.W = FrictionMatrix(SparseMatrix(SparseMatrix(H.transpose()) * response.times(H)));
  Vector v_free, lambda;
  response.velocity(problem.f, v_free, lambda);
  local.q = H.transpose() * v_free + problem.w;
  local.mu = problem.mu;
  local.mu_o = problem.mu_o;
  local.torsion = problem.torsion;
  local.rolling = problem.rolling;
  local.kinds = problem.kinds;
  if (local.kinds.empty())
    for (Eigen::Index i = 0; i < problem.blocks(); ++i) local.kinds.push_back(problem.kind(i));
  return local;
}

}  // namespace perp
