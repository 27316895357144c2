// Lemke's method: complementary pivoting with a covering vector and lexicographic ties.
#pragma once

#include <vector>

#include "perp/solve/lcp.hpp"

namespace perp {

/// Options with defaults that need no touching.
struct LemkeOptions {
  int max_pivots = 0;              ///< of all paths together; 0 means 50 (n + 1)
  double pivot_tolerance = 1e-11;  ///< |pivot| <= this * max(1, max|column|) counts as zero [-]
  double tie_tolerance =
      1e-10;  ///< basic variables within this * max|b| of zero are zero: they leave as a tie [-]
  double tolerance = 1e-11;  ///< Solved needs lcp_relative_residual <= this [-]
  Vector covering{};         ///< d > 0, (n); empty means d = (1, ..., 1)
  int restarts = 0;          ///< after a ray that proves nothing: new starts, each over the basis of the ray
};

/// Lemke's method [CPS92, Ch. 4] for 0 <= z ⟂ w = A z + b >= 0: adds the artificial z0,
///   w = A z + d z0 + b,
/// starts where z0 is just large enough for w >= 0, and goes from vertex to vertex, keeping z_i w_i = 0, until z0
/// leaves the basis (Solved) or nothing stops the variable that grows (SecondaryRay; NoSolution if the ray is a
/// certificate). Ties are broken as if b were b + (s, s², ..., sⁿ) with s -> 0+, so that degenerate problems
/// do not cycle [CPS92, Ch. 4]. The answer is refined with A and b themselves; where the tableau's rounding has
/// grown it is set up again from them.
///
/// Keeps its workspace: after a first call, calls with the same or a smaller n and an `out` whose z has that size
/// allocate nothing on the heap while they solve. O(n²) a pivot. One solver per thread.
class LemkeSolver {
 public:
  explicit LemkeSolver(LemkeOptions options = {});

  /// A (n, n), b (n); rows and columns scaled so that entries and unknowns are of the order of 1 relative to b.
  /// Throws std::invalid_argument if sizes disagree; what is not finite is not looked for.
  void solve(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b, LcpSolution& out);

 private:
  // Variables: w_i is i, z_i is n + i, z0 is 2n. The dictionary has a row per basic variable,
  //   basic = entry(row, 0) + sum over slots of entry(row, 1 + slot) * nonbasic[slot].
  double* row(int r) { return dictionary_.data() + static_cast<size_t>(r) * stride_; }
  const double* row(int r) const { return dictionary_.data() + static_cast<size_t>(r) * stride_; }
  bool is_basic(int variable) const { return place_[static_cast<size_t>(variable)] < 0; }
  int row_of(int variable) const { return -1 - place_[static_cast<size_t>(variable)]; }
  int slot_of(int variable) const { return place_[static_cast<size_t>(variable)]; }

  void load(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b);
  void exchange(int r, int slot);
  bool start();
  int blocking_row(int slot);
  int first_in_lexicographic_order(int slot);
  LcpStatus follow(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b);
  bool refactorise(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b);
  void cover_basis(const Eigen::Ref<const Matrix>& A);
  bool drop_artificial();
  bool has_drifted(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b);
  double read_solution(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b, Vector& z);
  double evaluate(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b, const Vector& z);
  void read_ray(const Eigen::Ref<const Matrix>& A, const Eigen::Ref<const Vector>& b, LcpSolution& out);

  LemkeOptions options_;
  int n_ = 0;
  size_t stride_ = 0;
  int pivots_ = 0, max_pivots_ = 0, entering_ = 0;
  double b_scale_ = 0;                    // max|b|
  std::vector<double> dictionary_;        // row-major, n rows of stride_
  std::vector<double> cover_, w_, size_;  // d; A z + b; |A| |z| + |b|
  std::vector<int> basic_, nonbasic_;     // variable of a row, of a slot
  std::vector<int> place_;                // of a variable: its slot, or -1 - row
  std::vector<int> tied_;                 // rows
};

/// One solve of a problem of any scale: rows and unknowns are first scaled by powers of two to entries near 1.
/// Throws std::invalid_argument if A is not (n, n) for b of size n, an entry is not finite, or d is not positive.
[[nodiscard]] LcpSolution lemke(const Lcp& lcp, const LemkeOptions& options = {});

}  // namespace perp
