// Scaling a matrix so that the largest entry of every row and column is near 1.
#pragma once

#include "perp/core/types.hpp"

namespace perp {

/// R A C with R = diag(r), C = diag(c) powers of two, so that scaling rounds nothing: with z = C z',
/// A z + b becomes R A C z' + R b.
struct Scaling {
  Vector r, c;
  Matrix apply(const Matrix& A) const { return r.asDiagonal() * A * c.asDiagonal(); }
};

/// By repeated square roots of the largest entries [Ruiz01]. Symmetric means R = C, which keeps definiteness and
/// copositivity; otherwise rows and columns each by their own. A (n, n).
[[nodiscard]] Scaling equilibrate(const Matrix& A, bool symmetric);

}  // namespace perp
