#include <cmath>

#include "contact_system.hpp"

namespace perp {

LocalOperator::LocalOperator(BlockPattern pattern, Blocks3 values)
    : pattern_(std::move(pattern)), values_(std::move(values)) {
  const int n = pattern_.size();
  for (int i = 0; i < n; ++i)
    for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e)
      if (pattern_.column[e] == i) diagonal_.push_back(e);
  open_.resize(n);
}

const Matrix3& LocalOperator::diagonal(int i) const { return values_[diagonal_[i]]; }

Vector3 LocalOperator::row(int i, const Columns3& r) const {
  Vector3 sum = Vector3::Zero();
  for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e)
    sum.noalias() += values_[e] * r.col(pattern_.column[e]);
  return sum;
}

double LocalOperator::sweep_work() const {
  return 9.0 * static_cast<double>(values_.size()) + one_contact_work * pattern_.size();
}

double LocalOperator::newton_work() {
  if (!lu_.analyzed()) lu_.analyze(pattern_);
  return lu_.factor_work() + 3 * lu_.solve_work() + 27.0 * static_cast<double>(values_.size());
}

void LocalOperator::apply(const Columns3& r, Columns3& Wr) const {
  Wr.resize(3, r.cols());
  for (int i = 0; i < pattern_.size(); ++i) Wr.col(i) = row(i, r);
}

bool LocalOperator::factor(const Blocks3& A, const Blocks3& B) {
  if (!lu_.analyzed()) lu_.analyze(pattern_);
  A_ = A;
  B_ = B;
  lu_.clear();
  any_open_ = false;
  for (size_t i = 0; i < open_.size(); ++i) {
    open_[i] = B[i].isZero(0);
    if (open_[i]) {
      any_open_ = true;
      lu_.leave_out(static_cast<int>(i));
    }
  }
  for (size_t i = 0; i < open_.size(); ++i) {
    if (open_[i]) continue;
    for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e) {
      const auto at = e;
      if (open_[pattern_.column[at]]) continue;
      Matrix3 value = B[i] * values_[at];
      if (pattern_.column[at] == static_cast<int>(i)) value += A[i];
      lu_.set(e, value);
    }
  }
  return lu_.factor();
}

void LocalOperator::solve_once(const Columns3& y, Columns3& x) {
  x = y;
  if (any_open_) {
    // an open block's unknown is A_i^-1 y_i; the others see it through their rows of W
    for (size_t i = 0; i < open_.size(); ++i)
      if (open_[i]) x.col(i) = A_[i].partialPivLu().solve(y.col(i));
    for (size_t i = 0; i < open_.size(); ++i) {
      if (open_[i]) continue;
      Vector3 known = Vector3::Zero();
      for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e) {
        const int j = pattern_.column[e];
        if (open_[j]) known.noalias() += values_[e] * x.col(j);
      }
      x.col(i).noalias() -= B_[i] * known;
    }
  }
  lu_.solve(x);
}

bool LocalOperator::solve(const Columns3& y, Columns3& x, Columns3& Wx) {
  solve_once(y, x);
  return refine(y, x, Wx, A_, B_, [this](const Columns3& rhs, Columns3& out) { solve_once(rhs, out); });
}

Matrix LocalOperator::dense() const {
  Matrix W = Matrix::Zero(3 * pattern_.size(), 3 * pattern_.size());
  for (int i = 0; i < pattern_.size(); ++i)
    for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e)
      W.block<3, 3>(3 * i, 3 * pattern_.column[e]) = values_[e];
  return W;
}

}  // namespace perp
