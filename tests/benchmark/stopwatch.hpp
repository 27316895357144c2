// Times beside a fixed kernel of the same run, since machines and their load differ.
#pragma once

#include <algorithm>
#include <chrono>
#include <perp/perp.hpp>

namespace perp {

/// Seconds of the best of some runs of `work`, each of which does it `count` times; per time.
template <class Work>
double best(int count, Work work) {
  double least = infinity;
  for (int repeat = 0; repeat < 7; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    work(count);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    least = std::min(least, taken.count() / count);
  }
  return least;
}

/// The kernel: a dense 32 by 32 matrix product, 65536 operations.
inline double kernel() {
  const Matrix A = Matrix::Constant(32, 32, 1.0 / 32);
  Matrix B = Matrix::Identity(32, 32), C;
  return best(2000, [&](int count) {
    for (int i = 0; i < count; ++i) {
      C.noalias() = A * B;
      B.swap(C);
    }
  });
}

}  // namespace perp
