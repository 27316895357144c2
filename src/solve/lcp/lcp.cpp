#include "perp/solve/lcp.hpp"

#include <algorithm>
#include <cmath>

namespace perp {

std::string_view name_of(LcpStatus status) {
  switch (status) {
    case LcpStatus::Solved:
      return "solved";
    case LcpStatus::NoSolution:
      return "no solution";
    case LcpStatus::SecondaryRay:
      return "secondary ray";
    case LcpStatus::PivotLimit:
      return "pivot limit";
    case LcpStatus::Inaccurate:
      return "inaccurate";
    case LcpStatus::Exhausted:
      return "exhausted";
  }
  return "unknown";
}

double lcp_residual(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b,
                    const Eigen::Ref<const Vector>& z) {
  if (b.size() == 0) return 0;
  return (A * z + b).cwiseMin(z).lpNorm<Eigen::Infinity>();
}

double lcp_relative_residual(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b,
                             const Eigen::Ref<const Vector>& z) {
  if (!(z.array() >= 0).all()) return infinity;
  const Vector w = A * z + b;
  double miss = 0;
  for (Eigen::Index i = 0; i < b.size(); ++i)
    miss = std::max(miss, z[i] > 0 ? std::abs(w[i]) : std::max(0.0, -w[i]));
  if (miss == 0) return 0;
  return miss / (A.cwiseAbs() * z + b.cwiseAbs()).maxCoeff();
}

bool proves_no_solution(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b,
                        const Eigen::Ref<const Vector>& y) {
  constexpr double rounding = 1e-13, clearly = 1e-9;
  if (y.size() != b.size() || !(y.array() >= 0).all()) return false;
  const Vector slope = A.transpose() * y, slope_size = A.transpose().cwiseAbs() * y;
  return (slope.array() <= rounding * slope_size.array()).all() && b.dot(y) < -clearly * b.cwiseAbs().dot(y);
}

}  // namespace perp
