// Ipopt on the contact problem as a mathematical program with relaxed complementarity.
#pragma once

#include "solve/friction/friction_stages.hpp"

namespace perp {

/// min t over (r, u, s, t) with u = W r + q, r_N, u_N, s, t >= 0 and, of every group of rows with semi-axes A, the longest a,
///   r_N u_N <= t,  s room <= t,  room = a² r_N² - |a A^-1 r|² >= 0,  r_N A u + s a A^-1 r = 0:
/// at t = 0 these are Signorini's condition and maximum dissipation, with s = |A u|/a; of a disc A = mu. A bound of constant
/// size has 1 in the place of r_N. Starts from r_N = s = `start` (scaled). Leaves `best` as it is if nothing better came out.
template <int R>
void solve_by_ipopt(const ContactSystem<R>& system, double start, Budget& budget, Iterate<R>& best);

}  // namespace perp
