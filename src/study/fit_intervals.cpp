#include "study/fit_intervals.hpp"

#include <cmath>
#include <Eigen/Eigenvalues>

namespace perp {
namespace {

constexpr double mark = 1.96 * 1.96;  // of chi^2 with one degree of freedom, 95 %
constexpr double cancels = 1e-8;      // columns of J parallel to 1e-4: as far as differences can tell
constexpr double belongs =
    0.03;  // an entry of a unit vector that belongs to it; below, rounding of the differences

}  // namespace

Curvature curvature(const Matrix& H, const Vector& scale) {
  const Eigen::Index n = H.rows();
  const Matrix S = scale.asDiagonal(), A = S * H * S;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A);
  Curvature result{.covariance = Matrix::Zero(n, n), .flat = {}, .identifiable = {}};
  result.identifiable.assign(static_cast<std::size_t>(n), true);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Vector v = eigen.eigenvectors().col(k);
    const double value = eigen.eigenvalues()[k], alone = v.cwiseAbs2().dot(A.diagonal());
    if (value > mark && value > cancels * alone) {
      result.covariance += (1 / value) * v * v.transpose();
      continue;
    }
    result.flat.push_back({v});
    for (Eigen::Index i = 0; i < n; ++i)
      if (std::abs(v[i]) > belongs) result.identifiable[static_cast<std::size_t>(i)] = false;
  }
  result.covariance = S * result.covariance * S;
  return result;
}

}  // namespace perp
