// Ipopt on a nonlinear complementarity problem.
#pragma once

#include "perp/solve/ncp.hpp"

namespace perp {

/// z of min t over (z, w, t) with w = F(z), z, w, t >= 0, z_i w_i <= t, from z0; NaN where Ipopt gave none or the
/// library is without it. Its iterations are added to `iterations`.
Vector ncp_by_ipopt(const NcpFunction& F, const NcpJacobian& J, const Vector& z0, int& iterations);

}  // namespace perp
