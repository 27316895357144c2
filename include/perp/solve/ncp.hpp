// Nonlinear complementarity problems for any smooth function: the paper's Definition 1.
#pragma once

#include <functional>
#include <string_view>

#include "perp/core/types.hpp"

namespace perp {

/// Find z with 0 <= F(z) ⟂ z >= 0 [T03, Definition 1].
using NcpFunction = std::function<Vector(const Vector&)>;  ///< F: (n) -> (n)
using NcpJacobian = std::function<Matrix(const Vector&)>;  ///< dF/dz: (n) -> (n, n)

enum class NcpStatus {
  Solved,     ///< residual <= tolerance
  BestFound,  ///< nothing is proved; the residual says how good the best point is
};

struct NcpOptions {
  double tolerance = 1e-10;  ///< on the residual [unit of z and F, which the min map takes as one]
  int max_iterations = 100;  ///< of each Newton run
  int restarts = 30;         ///< from other starts, the same ones every time
  bool use_ipopt = true;     ///< as the last resort, if the library has it
};

struct NcpSolution {
  NcpStatus status = NcpStatus::BestFound;
  Vector z;
  Vector w;                    ///< F(z)
  double residual = infinity;  ///< ‖min(z, F(z))‖∞, recomputed at z
  int iterations = 0;          ///< over all runs
  std::string_view stage;      ///< min-map, fischer-burmeister, restart, ipopt: the method that gave z
  bool solved() const { return status == NcpStatus::Solved; }
};

/// Semismooth Newton on the min map, then on Fischer and Burmeister's function with a globally convergent search
/// [DFK96], then both from other starts: F's local minima of merit are no solutions. Last Ipopt on
///   min t: w = F(z), z, w >= 0, z_i w_i <= t,
/// and Newton from its answer. Where F or J is not finite the search draws back. Throws std::invalid_argument if z0 is not finite or F, J have the wrong size at z0.
[[nodiscard]] NcpSolution solve_ncp(const NcpFunction& F, const NcpJacobian& J, const Vector& z0,
                                    const NcpOptions& options = {});

}  // namespace perp
