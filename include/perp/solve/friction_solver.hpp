// One call that answers contact problems with exact cones: a chain of methods, each standing in for the one before.
//
//   newton          Alart-Curnier semismooth Newton from the given start (or zero), globalised
//   interior-point  homotopy on the exact problem, polished by Newton; then from other starts
//   proximal        Newton on a sequence of problems with W + alpha I
//   gauss-seidel    sweeps over the contacts: first of all while they pay, and polished last
//   ipopt           a mathematical program with relaxed complementarity, polished
// The first that reaches the tolerance answers. doc/methods/friction.md has the mathematics.
#pragma once

#include <string_view>

#include "perp/solve/friction_residual.hpp"

namespace perp {

/// How a solve ended.
enum class FrictionStatus {
  Solved,      ///< residuals.relative <= tolerance, residuals.absolute + residuals.round_off <= 100 tolerance
  NoSolution,  ///< proved by FrictionSolution::certificate
  BestFound,   ///< the best point met; the residual says how good; nothing is proved
};

/// What is known about solutions, whether or not one was found.
enum class FrictionExistence {
  Exists,   ///< one was found, or FrictionSolution::certificate proves it
  None,     ///< FrictionSolution::certificate proves that there is none
  Unknown,  ///< neither
};

/// The method that gave the answer.
enum class FrictionStage { None, Newton, InteriorPoint, Restart, Proximal, GaussSeidel, Ipopt };

/// Which methods may be used.
enum class FrictionMethod { Chain, Newton, InteriorPoint, Proximal, GaussSeidel, Ipopt };

enum class Reactions {
  Any,          ///< those that the solver comes to; not unique if contacts are redundant
  MinimumNorm,  ///< among the reactions with the same velocity and modes, those of least Euclidean norm; not of blocks with moments or mu_o
};

struct FrictionOptions {
  double tolerance = 1e-10;  ///< pass mark, see Solved; Newton goes on to round-off when it can [-]
  FrictionMethod method = FrictionMethod::Chain;
  Reactions reactions = Reactions::Any;
  Vector start{};                ///< (m) reactions to start from, such as the last step's; empty: zero
  int max_iterations = 0;        ///< over all stages; 0: each stage's own limit
  int stage_iterations = 0;      ///< of each stage but ipopt; 0: its own limit
  double time_limit = infinity;  ///< [s]; what is found by then depends on the machine's speed
  bool use_ipopt = true;         ///< in the chain, if the library has it
};

struct FrictionSolution {
  FrictionStatus status = FrictionStatus::BestFound;
  FrictionStage stage = FrictionStage::None;
  Vector r;                    ///< (m)
  Vector u;                    ///< (m)
  Vector v;                    ///< (n) global form only
  Vector lambda;               ///< (k) global form only
  double residual = infinity;  ///< residuals.relative
  FrictionResidual residuals;  ///< recomputed from the problem's own data
  int iterations = 0;          ///< Newton and interior-point iterations, sweeps, Ipopt's iterations, in all
  FrictionExistence existence = FrictionExistence::Unknown;
  /// (m) if NoSolution: y >= 0 on normal rows, 0 elsewhere, Wᵀ y = 0, qᵀ y < 0. If BestFound and a solution exists: u in
  /// the range of Hᵀ, plus w (local form: of W, plus q), with u_N > |A u| + |B u| at every contact [ACLM11].
  Vector certificate;
  bool solved() const { return status == FrictionStatus::Solved; }
};

/// Solves (1)-(3) of FrictionProblem. Deterministic unless time_limit is set. Never throws for a numerical outcome;
/// throws std::invalid_argument for data that check() refuses or options out of range.
[[nodiscard]] FrictionSolution solve_friction(const FrictionProblem& problem,
                                              const FrictionOptions& options = {});

/// Whether the library was built with Ipopt; without it the stage `ipopt` finds nothing and the others work.
bool has_ipopt();

std::string_view to_string(FrictionStatus status);        ///< solved, no-solution, best-found
std::string_view to_string(FrictionExistence existence);  ///< exists, none, unknown
std::string_view to_string(FrictionStage stage);          ///< newton, interior-point, restart, ...

}  // namespace perp
