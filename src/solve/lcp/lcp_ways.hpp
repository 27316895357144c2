// The ways by which solve_lcp goes on where Lemke's path ended on a ray; each takes a problem whose rows and unknowns
// are scaled, and leaves in `out` a solution, a proof that there is none, or what was there before.
#pragma once

#include "perp/solve/lcp.hpp"

namespace perp {

/// From an `out` that is Inaccurate: Newton's method on min(z, w) inside the proximal point method, to round-off. A of about unit
/// diagonal.
void try_polish(const Lcp& lcp, const LcpOptions& options, LcpSolution& out);

/// Lemke's method along other covering vectors, drawn by a seed of its own.
void try_covering_vectors(const Lcp& lcp, const LcpOptions& options, LcpSolution& out);

/// Depth first over the choices z_i = 0 or w_i = 0, where the linear relaxation of a choice is infeasible cutting
/// off all below it. Finite, exponential at worst: after max_nodes `out` stays as it was. When the choices run
/// out first: Exhausted.
void try_branches(const Lcp& lcp, const LcpOptions& options, int max_nodes, LcpSolution& out);

}  // namespace perp
