#include "vanishing_compliance.hpp"

#include <cmath>

namespace perp {

VanishingCompliance::Outcome VanishingCompliance::solve(const Matrix& A, const Vector& b, const Matrix& C,
                                                        const Vector& k, const Vector& scale, Vector& y) {
  const Eigen::Index n = b.size();
  redundancy_ = 0;
  y.resize(n);
  if (n == 0) return Outcome::Unique;
  const auto inverse = scale.cwiseInverse().asDiagonal();
  A_.noalias() = inverse * A * inverse;
  b_.noalias() = inverse * b;
  qr_.setThreshold(dependent);
  qr_.compute(A_);
  redundancy_ = static_cast<int>(n - qr_.rank());
  B_ = A_;
  y_ = -b_;
  if (redundancy_ > 0) {
    // the columns of Q past the rank span the null space of Aᵀ
    null_.setZero(n, redundancy_);
    null_.bottomRows(redundancy_).setIdentity();
    null_.applyOnTheLeft(qr_.householderQ());
    rest_.noalias() = null_.transpose() * b_;
    constexpr double rounding = 1e-9;  // of b: what it has across the range of A is not a load but rounding
    if (!(rest_.norm() <= rounding * b_.norm())) return Outcome::None;
    y_.noalias() += null_ * rest_;
    C_.noalias() = inverse * C * inverse;
    const double size = C_.diagonal().maxCoeff();  // the limit does not depend on it
    C_ /= size;
    k_.noalias() = inverse * k;
    k_ /= size;
    across_.noalias() = C_.transpose() * null_;
    B_.noalias() += null_ * across_.transpose();
    y_.noalias() -= null_ * (null_.transpose() * k_);
  }
  lu_.compute(B_);
  constexpr double singular = 1e-12;  // of the largest pivot
  const auto pivots = lu_.matrixLU().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > singular * pivots.maxCoeff()))
    return redundancy_ > 0 ? Outcome::Several : Outcome::None;
  b_ = y_;
  y_ = lu_.solve(b_);
  rest_.noalias() = b_ - B_ * y_;
  y_ += lu_.solve(rest_);
  y.noalias() = inverse * y_;
  return y.allFinite() ? (redundancy_ > 0 ? Outcome::Shared : Outcome::Unique) : Outcome::Several;
}

void VanishingCompliance::first_order(const Matrix& C, const Vector& k, const Vector& scale, const Vector& y,
                                      Vector& y_1) {
  if (y.size() == 0) return y_1.resize(0);
  b_.noalias() = C * y;
  b_ += k;
  b_ = -b_.cwiseQuotient(scale);
  y_1 = lu_.solve(b_);
  y_1 = y_1.cwiseQuotient(scale).eval();
}

}  // namespace perp
