// The linear system of a Newton iteration on a step's equations.
#pragma once

#include <array>
#include <vector>

#include "solve/linear/block_lu.hpp"
#include "step/implicit/step_problem.hpp"

namespace perp {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A reaction's law F = p - projection(p - rho u/w) = 0, linearised.
struct LinearizedReaction {
  Vector3 F;
  Matrix3 P;  ///< generalised Jacobian of the projection
  /// Of a contact with moments, the Jacobian of it and of the next reaction together: they are eliminated as one. Else null.
  const Matrix6* whole = nullptr;
  double rho = 1;  ///< [-]
  double eps = 0;  ///< regularisation [-]
  bool even =
      false;  ///< p + dp is to be the limit of rows that give rho eps p, eps in the ratios of all that are even
};

/// Solves
///   K dnu - sum W dp = -R,     (I - P + eps P) dp + rho P/w G dnu = -F   for every reaction
/// for dp first, which leaves a system of 6x6 blocks over the bodies, as sparse as the graph of contacts and couplings. eps makes
/// redundant reactions regular; what the factors miss is refined; `thorough`, by generalised conjugate residuals [EES83] with the factors as
/// preconditioner, which takes a direction for each group of reactions that are nearly redundant, where refinement creeps.
///
/// Reactions that are `even` have eps in the factors alone, and are refined from p + dp = 0: corrections by the factors leave the
/// rule of VanishingCompliance as it is, and rounding is taken out of it at last, as there.
class LinearizedStep {
 public:
  Vector dnu;
  std::vector<Vector3> dp;

  /// dnu, dp; `R` is without the reactions' impulses, misses are measured by M of `instant`. False if the system is singular.
  bool solve(const Model& model, const Instant& instant, const std::vector<Coupling>& K,
             const std::vector<Reaction>& reactions, const std::vector<LinearizedReaction>& rows,
             const Vector& R, bool thorough);

 private:
  void analyze(const Model& model, const std::vector<Coupling>& K, const std::vector<Reaction>& reactions);
  bool factor(const Model& model, const std::vector<Coupling>& K, const std::vector<Reaction>& reactions,
              const std::vector<LinearizedReaction>& rows);
  void factor_whole(const std::vector<Reaction>& reactions, const std::vector<LinearizedReaction>& rows,
                    std::size_t i);
  /// Of (dnu, dp), or of what the two equations miss.
  struct Pair {
    Vector first;
    std::vector<Vector3> second;
    void add(double t, const Pair& other);
  };
  double product(const Model& model, const Instant& instant, const std::vector<Reaction>& reactions,
                 const Pair& a, const Pair& b);
  void precondition(const Model& model, const std::vector<Reaction>& reactions,
                    const std::vector<LinearizedReaction>& rows, const Pair& misses, Pair& step);
  void apply(const Model& model, const std::vector<Coupling>& K, const std::vector<Reaction>& reactions,
             const std::vector<LinearizedReaction>& rows, const Pair& step, Pair& out) const;
  bool begin(const Model& model, const std::vector<Coupling>& K, const std::vector<Reaction>& reactions,
             const std::vector<LinearizedReaction>& rows, const Vector& R);
  void even_out(const Model& model, const std::vector<Reaction>& reactions,
                const std::vector<LinearizedReaction>& rows);

  static constexpr std::size_t most_directions = 8;
  Pair missed_;
  std::array<Pair, most_directions> directions_, images_;
  Vector scratch_;
  std::vector<Matrix3> inverse_;  // (I - P + eps P)^-1
  std::vector<Matrix6> wholes_;   // of contacts with moments, six rows each; empty without any
  std::vector<int> block_;        // of bodies: row of blocks, -1 without velocities
  std::vector<std::array<int, 2>> pairs_, analyzed_pairs_;
  std::vector<int> analyzed_blocks_;
  BlockLu<6> lu_;
  BlockPattern pattern_;
  std::vector<Matrix6> values_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> rhs_;
};

}  // namespace perp
