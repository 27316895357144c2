// Ipopt on the contact problem as a mathematical program with relaxed complementarity.
#pragma once

#include "friction_stages.hpp"

namespace perp {

/// min t over (r, u, s, t) with u = W r + q, r_N, u_N, s, t >= 0,
///   r_N u_N <= t,  s (mu² r_N² - |r_T|²) <= t,  |r_T|² <= mu² r_N²,  mu r_N u_T + s r_T = 0:
/// at t = 0 these are Signorini's and Coulomb's conditions. Starts from r_N = s = `start` (scaled). Leaves `best` as
/// it is if nothing better came out.
void solve_by_ipopt(const ContactSystem& system, double start, Budget& budget, Iterate& best);

}  // namespace perp
