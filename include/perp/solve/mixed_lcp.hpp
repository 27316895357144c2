// Complementarity beside equations: the mixed linear complementarity problem.
#pragma once

#include "perp/solve/lcp.hpp"

namespace perp {

/// Find u, of any sign, and v with
///   A u + C v + a = 0,                                                                               (1)
///   0 <= v ⟂ w = D u + B v + b >= 0.                                                                 (2)
struct MixedLcp {
  Matrix A;  ///< (n, n), may be singular
  Matrix C;  ///< (n, m)
  Matrix D;  ///< (m, n)
  Matrix B;  ///< (m, m)
  Vector a;  ///< (n)
  Vector b;  ///< (m), same unit as w
};

struct MixedLcpSolution {
  LcpStatus status = LcpStatus::PivotLimit;
  Vector u{};  ///< (n); of several that go with v one with few entries other than zero
  Vector v{};  ///< (m) >= 0; u and v are zero unless solved() or Inaccurate
  int pivots = 0;
  double residual = not_set;  ///< mixed_lcp_residual of u and v, from the data
  std::string_view stage =
      "";  ///< "elimination": (1) solved for u; "exchange": where A is singular, equations
           ///< exchanged with pairs of (2); "split": neither could, u = u⁺ - u⁻
  bool solved() const { return status == LcpStatus::Solved; }
};

/// Solves (1), (2): the equations are pivoted away, first against u, then, where A is singular, against a v_i
/// whose w_i takes in a u that is left over; what remains is an LCP in the pairs of (2). An equation that nothing
/// is left of is redundant, or says that there is no solution (NoSolution). Where pairs cannot take the equations in,
/// u = u⁺ - u⁻ with -(A u + C v + a) complementary to u⁻. The answer is corrected once more from the data.
/// Throws std::invalid_argument if shapes disagree or an entry is not finite.
[[nodiscard]] MixedLcpSolution solve_mixed_lcp(const MixedLcp& problem, const LcpOptions& options = {});

/// max(‖A u + C v + a‖∞, ‖min(v, D u + B v + b)‖∞), zero at solutions of (1), (2) alone.
[[nodiscard]] double mixed_lcp_residual(const MixedLcp& problem, const Vector& u, const Vector& v);

/// The same over the largest term of (1), (2): max of |A| |u| + |C| |v| + |a| and of |D| |u| + |B| |v| + |b| [-].
[[nodiscard]] double mixed_lcp_relative_residual(const MixedLcp& problem, const Vector& u, const Vector& v);

}  // namespace perp
