// The derivative by time of a function that comes without one.
#pragma once

#include <algorithm>
#include <array>

#include "perp/core/types.hpp"

namespace perp {

/// f'(t) of f: double -> Eigen::Matrix<double, N, 1>, smooth about t: central differences over steps that are halved, extrapolated to
/// zero until rounding takes over (Ridders's method). The first steps, of 1, 1/2 and 1/4 ms, are always taken: what changes within less
/// than a quarter of a millisecond is not seen, and slower motions lose no digit, as rounding over steps of that size is 1e-12 of f a
/// second.
template <int N, class F>
Eigen::Matrix<double, N, 1> time_slope(const F& f, double t) {
  using Value = Eigen::Matrix<double, N, 1>;
  constexpr int least = 3, most = 8;
  constexpr double rounding = 64 * 2.3e-16;
  std::array<Value, most> row, last;
  Value best = Value::Zero();
  double error = infinity, h = 1e-3;  // [s]
  for (int i = 0; i < most; ++i, h /= 2) {
    const Value after = f(t + h), before = f(t - h);
    row[0] = (after - before) / (2 * h);
    double factor = 1;
    for (int j = 1; j <= i; ++j) {
      const auto k = static_cast<std::size_t>(j);
      factor *= 4;
      row[k] = (factor * row[k - 1] - last[k - 1]) / (factor - 1);
      const double off = std::max((row[k] - row[k - 1]).template lpNorm<Eigen::Infinity>(),
                                  (row[k] - last[k - 1]).template lpNorm<Eigen::Infinity>());
      if (!(off <= error)) continue;
      error = off;
      best = row[k];
    }
    const double size =
        std::max(after.template lpNorm<Eigen::Infinity>(), before.template lpNorm<Eigen::Infinity>());
    if (i + 1 >= least && !(error > rounding * size / h)) break;
    const auto n = static_cast<std::size_t>(i);
    if (i + 1 > least && (row[n] - last[n - 1]).template lpNorm<Eigen::Infinity>() > 2 * error) break;
    last = row;
  }
  return best;
}

}  // namespace perp
