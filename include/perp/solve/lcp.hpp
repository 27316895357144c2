// The linear complementarity problem, what a solution of it is, and what proves that it has none.
#pragma once

#include <string_view>

#include "perp/core/types.hpp"

namespace perp {

/// Linear complementarity problem: find z with
///   0 <= z ⟂ w = A z + b >= 0.                                                                       (1)
/// A solution need not exist, nor be the only one.
struct Lcp {
  Matrix A;  ///< (n, n)
  Vector b;  ///< (n), same unit as w
};

/// How a solve ended. Each is a different fact about the problem or the search, not a grade.
enum class LcpStatus {
  Solved,        ///< z solves (1); LcpSolution::residual says how well
  NoSolution,    ///< LcpSolution::certificate proves that no z >= 0 has A z + b >= 0
  SecondaryRay,  ///< the path runs off without end; proves nothing unless A has more properties
  PivotLimit,    ///< gave up; says nothing about the problem
  Inaccurate,    ///< a complementary basis, but so near to singular that its z misses the tolerance
  Exhausted      ///< every way of choosing z_i = 0 or w_i = 0 was ruled out: no solution, to rounding
};

[[nodiscard]] std::string_view name_of(LcpStatus status);  ///< "solved", "secondary ray", ...

struct LcpSolution {
  LcpStatus status = LcpStatus::PivotLimit;
  Vector z;                     ///< (n) >= 0; zero unless solved() or Inaccurate
  int pivots = 0;               ///< of all that was tried
  double residual = not_set;    ///< lcp_residual(A, b, z) [unit of w]: from A and b, not from a tableau
  Vector certificate;           ///< (n) with proves_no_solution(A, b, certificate) if NoSolution, else empty
  std::string_view stage = "";  ///< the way that ended the search: "lemke", "branch", ...
  bool solved() const { return status == LcpStatus::Solved; }
};

struct LcpOptions {
  int max_pivots = 0;        ///< of one path of Lemke's method; 0 means 50 (n + 1)
  double tolerance = 1e-11;  ///< Solved needs lcp_relative_residual <= this [-]
};

/// Solves (1) by Lemke's method and, where its path ends on a ray, by other ways, until there is a solution, a proof
/// that none exists, or nothing left to try; doc/methods/lcp.md lists the ways in their order.
/// Throws std::invalid_argument if A is not (n, n) for b of size n, or an entry is not finite.
[[nodiscard]] LcpSolution solve_lcp(const Lcp& lcp, const LcpOptions& options = {});

/// ‖min(z, A z + b)‖∞ [unit of w]: zero at solutions of (1) alone. It compares z with w, so it depends on units.
[[nodiscard]] double lcp_residual(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b,
                                  const Eigen::Ref<const Vector>& z);

/// The same relative to the problem: max_i (|w_i| if z_i > 0, else the negative part of w_i) over
/// max_i (|A| |z| + |b|)_i [-], infinite if z has a negative entry; round-off is a few 1e-16. One number for all units
/// of z, and of w if all rows have the same.
[[nodiscard]] double lcp_relative_residual(const Eigen::Ref<const Matrix>& A,
                                           const Eigen::Ref<const Vector>& b,
                                           const Eigen::Ref<const Vector>& z);

/// Whether y >= 0, Aᵀ y <= 0 and bᵀ y < 0, each clear of rounding: then 0 <= yᵀ(A z + b) = (Aᵀ y)ᵀ z + bᵀ y < 0 has
/// no z >= 0, so (1) has no solution (Farkas). Entries of Aᵀ y count as <= 0 up to 1e-13 (|A|ᵀ y), bᵀ y as
/// negative below -1e-9 |b|ᵀ y.
[[nodiscard]] bool proves_no_solution(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b,
                                      const Eigen::Ref<const Vector>& y);

}  // namespace perp
