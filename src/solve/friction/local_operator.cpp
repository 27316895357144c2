#include <cmath>

#include "solve/friction/contact_system.hpp"

namespace perp {

template <int R>
LocalOperator<R>::LocalOperator(BlockPattern pattern, Squares<R> values)
    : pattern_(std::move(pattern)), values_(std::move(values)) {
  const int n = pattern_.size();
  for (int i = 0; i < n; ++i)
    for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e)
      if (pattern_.column[e] == i) diagonal_.push_back(e);
  open_.resize(n);
}

template <int R>
const Square<R>& LocalOperator<R>::diagonal(int i) const {
  return values_[diagonal_[i]];
}

template <int R>
Column<R> LocalOperator<R>::row(int i, const Columns<R>& r) const {
  Column<R> sum = Column<R>::Zero();
  for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e)
    sum.noalias() += values_[e] * r.col(pattern_.column[e]);
  return sum;
}

template <int R>
double LocalOperator<R>::sweep_work() const {
  return 1.0 * R * R * static_cast<double>(values_.size());
}

template <int R>
double LocalOperator<R>::newton_work() {
  if (!lu_.analyzed()) lu_.analyze(pattern_);
  return lu_.factor_work() + 3 * lu_.solve_work() + 1.0 * R * R * R * static_cast<double>(values_.size());
}

template <int R>
void LocalOperator<R>::apply(const Columns<R>& r, Columns<R>& Wr) const {
  Wr.resize(R, r.cols());
  for (int i = 0; i < pattern_.size(); ++i) Wr.col(i) = row(i, r);
}

template <int R>
bool LocalOperator<R>::factor(const Squares<R>& A, const Squares<R>& B) {
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
      Square<R> value = B[i] * values_[at];
      if (pattern_.column[at] == static_cast<int>(i)) value += A[i];
      lu_.set(e, value);
    }
  }
  return lu_.factor();
}

template <int R>
void LocalOperator<R>::solve_once(const Columns<R>& y, Columns<R>& x) {
  x = y;
  if (any_open_) {
    // an open block's unknown is A_i^-1 y_i; the others see it through their rows of W
    for (size_t i = 0; i < open_.size(); ++i)
      if (open_[i]) x.col(i) = A_[i].partialPivLu().solve(y.col(i));
    for (size_t i = 0; i < open_.size(); ++i) {
      if (open_[i]) continue;
      Column<R> known = Column<R>::Zero();
      for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e) {
        const int j = pattern_.column[e];
        if (open_[j]) known.noalias() += values_[e] * x.col(j);
      }
      x.col(i).noalias() -= B_[i] * known;
    }
  }
  lu_.solve(x);
}

template <int R>
bool LocalOperator<R>::solve(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx) {
  solve_once(y, x);
  return this->refine(y, x, Wx, A_, B_,
                      [this](const Columns<R>& rhs, Columns<R>& out) { solve_once(rhs, out); });
}

template <int R>
Matrix LocalOperator<R>::dense() const {
  Matrix W = Matrix::Zero(R * pattern_.size(), R * pattern_.size());
  for (int i = 0; i < pattern_.size(); ++i)
    for (int e = pattern_.row_start[i]; e < pattern_.row_start[i + 1]; ++e)
      W.block<R, R>(R * i, R * pattern_.column[e]) = values_[e];
  return W;
}

template class LocalOperator<3>;
template class LocalOperator<6>;

}  // namespace perp
