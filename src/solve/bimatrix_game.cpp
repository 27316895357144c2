#include <cmath>
#include <Eigen/LU>
#include <vector>

#include "lcp_ways.hpp"

namespace perp {

void try_bimatrix_game(const Lcp&, const LcpOptions&, LcpSolution&) {}

}  // namespace perp
