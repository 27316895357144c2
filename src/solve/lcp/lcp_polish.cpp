#include <algorithm>
#include <Eigen/LU>
#include <vector>

#include "solve/lcp/lcp_ways.hpp"

namespace perp {
namespace {

using Indices = std::vector<Eigen::Index>;

/// The i with z_i > w_i: where w_i = 0 is to hold.
Indices active_set(const Vector& z, const Vector& w) {
  Indices active;
  for (Eigen::Index i = 0; i < z.size(); ++i)
    if (z[i] > w[i]) active.push_back(i);
  return active;
}

/// Newton's method on min(z, (A + s I) z + c) = 0 from z, until the active set stays as it is.
void newton(const Matrix& A, double s, const Vector& c, Vector& z) {
  constexpr int most = 20;
  Indices active, before;
  for (int k = 0; k < most; ++k) {
    std::swap(active, before);
    active = active_set(z, A * z + s * z + c);
    if (k > 0 && active == before) return;
    Matrix A_II = A(active, active);
    A_II.diagonal().array() += s;
    const Vector z_I = A_II.partialPivLu().solve(Vector(-c(active)));
    z.setZero();
    z(active) = z_I;
  }
}

}  // namespace

// The proximal point method, z <- solution of LCP(A + s I, b - s z), each by Newton's method from the last z. A + s I is regular
// where contacts are redundant, and at a fixed point the term drops out: what is left is s |change of z|.
void try_polish(const Lcp& lcp, const LcpOptions& options, LcpSolution& out) {
  constexpr int most = 10;
  if (out.status != LcpStatus::Inaccurate) return;
  double best = infinity;
  for (const double s : {1e-4, 1e-6, 1e-8}) {
    Vector z = out.z;
    for (int k = 0; k < most; ++k) {
      newton(lcp.A, s, lcp.b - s * z, z);
      const Vector kept = z.cwiseMax(0.0);
      const double residual = lcp_relative_residual(lcp.A, lcp.b, kept);
      if (!(residual < 0.5 * best)) break;
      best = residual;
      out.z = kept;
    }
    if (best <= options.tolerance) break;
  }
  if (!(best <= options.tolerance)) return;
  out.status = LcpStatus::Solved;
  out.stage = "polish";
}

}  // namespace perp
