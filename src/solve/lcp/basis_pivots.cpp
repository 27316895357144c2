#include "solve/lcp/basis_pivots.hpp"

#include <algorithm>
#include <cmath>

namespace perp {

/// z of the basis; false if A_II is singular to rounding.
bool BasisPivots::solve_basis(const Matrix& A, const Vector& b, const std::vector<char>& basic, Vector& z) {
  in_.clear();
  for (std::size_t i = 0; i < basic.size(); ++i)
    if (basic[i] != 0) in_.push_back(static_cast<int>(i));
  const auto n = static_cast<Eigen::Index>(in_.size());
  z.setZero(b.size());
  if (n == 0) return true;
  A_in_.resize(n, n);
  z_in_.resize(n);
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i)
      A_in_(i, j) = A(in_[static_cast<std::size_t>(i)], in_[static_cast<std::size_t>(j)]);
  b_in_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) b_in_[i] = b[in_[static_cast<std::size_t>(i)]];
  lu_.compute(A_in_);
  z_in_ = lu_.solve(-b_in_);
  b_in_.noalias() += A_in_ * z_in_;  // what is left: refined once, or the basis' condition stays in it
  z_in_ -= lu_.solve(b_in_);
  for (Eigen::Index i = 0; i < n; ++i) z[in_[static_cast<std::size_t>(i)]] = z_in_[i];
  return z_in_.allFinite();
}

/// Marks what is negative beyond rounding of a problem whose terms are of `size`; how many.
int BasisPivots::infeasible(const Vector& z, double size) {
  constexpr double rounding = 1e-12;
  const double zero_w = rounding * size, zero_z = rounding * z.cwiseAbs().maxCoeff();
  int count = 0;
  for (int i = 0; i < static_cast<int>(z.size()); ++i) {
    const bool wrong = z[i] != 0 ? z[i] < -zero_z : w_[i] < -zero_w;
    wrong_[static_cast<std::size_t>(i)] = static_cast<char>(wrong);
    count += wrong ? 1 : 0;
  }
  return count;
}

bool BasisPivots::solve(const Matrix& A, const Vector& b, std::vector<char>& basic, LcpSolution& out) {
  constexpr int most = 8;  // factorisations; what takes more is not near
  const std::size_t n = basic.size();
  if (static_cast<Eigen::Index>(n) != b.size() || n == 0) return false;
  wrong_.resize(n);
  out.pivots = 0;
  for (int k = 0, fewest = static_cast<int>(n) + 1; k < most; ++k) {
    ++out.pivots;
    if (!solve_basis(A, b, basic, out.z)) return false;
    w_ = b;
    for (const int j : in_) w_.noalias() += out.z[j] * A.col(j);
    const int wrong = infeasible(out.z, b.cwiseAbs().maxCoeff());
    out.z = out.z.cwiseMax(0.0);
    if (lcp_relative_residual(A, b, out.z) <= LcpOptions{}.tolerance) {
      out.residual = lcp_residual(A, b, out.z);
      out.status = LcpStatus::Solved;
      out.stage = "basis";
      if (out.certificate.size() > 0) out.certificate.resize(0);
      return true;
    }
    if (wrong == 0 || wrong >= fewest) return false;
    fewest = wrong;
    for (std::size_t i = 0; i < n; ++i)
      if (wrong_[i] != 0) basic[i] = static_cast<char>(basic[i] == 0);
  }
  return false;
}

void KeptBasis::keep(const std::vector<int>& problem, const Vector& z) {
  constexpr double rounding = 1e-12;  // of the largest: what a path's end leaves of zeros
  of = problem;
  const double zero = rounding * z.cwiseAbs().maxCoeff();
  basic.clear();
  for (const double z_i : z) basic.push_back(static_cast<char>(z_i > zero));
}

}  // namespace perp
