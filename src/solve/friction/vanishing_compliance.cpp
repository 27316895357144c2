#include "solve/friction/vanishing_compliance.hpp"

#include <cmath>

namespace perp {

/// B dy = rest.
void VanishingCompliance::correct(const Vector& rest, Vector& dy) { dy = lu_.solve(rest); }

VanishingCompliance::Outcome VanishingCompliance::solve(const Matrix& A, const Vector& b, const Matrix& C,
                                                        const Vector& k, const Vector& scale, Vector& y) {
  constexpr double slight = 1e-8;   // eps C beside A's unit entries: halfway, as digits go, to rounding [-]
  constexpr double nothing = 1e-6;  // of eps C: pivots below say that what gives does not tell y either [-]
  constexpr double enough = 1e-15, most_left = 1e-11;  // of b and y
  constexpr int most_corrections = 8, most_returns = 3;
  y.resize(b.size());
  y_1_.setZero(b.size());
  if (b.size() == 0) return Outcome::Found;
  inverse_ = scale.cwiseInverse();
  A_ = inverse_.asDiagonal() * A * inverse_.asDiagonal();
  C_ = inverse_.asDiagonal() * C * inverse_.asDiagonal();
  b_ = inverse_.cwiseProduct(b);
  k_ = inverse_.cwiseProduct(k);
  double logarithms = 0;
  int count = 0;
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    const double c = C_.row(i).lpNorm<Eigen::Infinity>();
    if (c > 0) logarithms += std::log(c), ++count;
  }
  const double eps = count == 0 ? 0 : slight * std::exp(-logarithms / count);
  C_ *= eps;
  k_ *= eps;
  B_ = A_ + C_;
  lu_.compute(B_);
  if (!(lu_.matrixLU().diagonal().cwiseAbs().minCoeff() > nothing * slight)) return Outcome::Several;

  // A y + b = 0, from y(eps)
  rest_ = -b_ - k_;
  correct(rest_, y_);
  const double of_b = b_.lpNorm<Eigen::Infinity>();
  double left = infinity;
  for (int i = 0; i < most_corrections; ++i) {
    rest_ = -b_;
    rest_.noalias() -= A_ * y_;
    const double before = left;
    left = rest_.lpNorm<Eigen::Infinity>();
    if (left <= enough * of_b || !(left < 0.5 * before)) break;
    correct(rest_, dy_);
    y_ += dy_;
  }
  if (!(left <= most_left * (of_b + y_.lpNorm<Eigen::Infinity>()))) return Outcome::None;

  // (2), and back to A y + b = 0:  A dy = -eps (C (y + dy) + k), then A back = eps (C (y + dy) + k)
  const auto what_gives = [&](const Vector& at) {
    give_ = k_;
    give_.noalias() += C_ * at;
  };
  what_gives(y_);
  correct(give_, dy_);
  y_ -= dy_;
  what_gives(y_);
  correct(give_, back_);
  for (int i = 0; i < most_returns; ++i) {
    dy_ = y_ + back_;
    what_gives(dy_);
    correct(give_, back_);
  }
  y_ += back_;
  if (eps > 0) y_1_ = inverse_.cwiseProduct(back_) / -eps;
  y = inverse_.cwiseProduct(y_);
  return y.allFinite() ? Outcome::Found : Outcome::Several;
}

}  // namespace perp
