#include "solve/linear/equilibrate.hpp"

#include <cmath>

namespace perp {

Scaling equilibrate(const Matrix& A, bool symmetric) {
  constexpr int rounds = 6;
  const auto n = A.rows();
  Scaling scaling{Vector::Ones(n), Vector::Ones(n)};
  const auto inverse_root = [](double x) { return x > 0 ? 1 / std::sqrt(x) : 1.0; };
  for (int k = 0; k < rounds && n > 0; ++k) {
    const Matrix size = scaling.apply(A).cwiseAbs();
    Vector row = size.rowwise().maxCoeff(), col = size.colwise().maxCoeff().transpose();
    if (symmetric) row = row.cwiseMax(col), col = row;
    scaling.r.array() *= row.unaryExpr(inverse_root).array();
    scaling.c.array() *= col.unaryExpr(inverse_root).array();
  }
  const auto power_of_two = [](double x) { return std::exp2(std::round(std::log2(x))); };
  scaling.r = scaling.r.unaryExpr(power_of_two).eval();
  scaling.c = scaling.c.unaryExpr(power_of_two).eval();
  return scaling;
}

}  // namespace perp
