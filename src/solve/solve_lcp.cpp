#include "perp/solve/lemke.hpp"

namespace perp {

LcpSolution solve_lcp(const Lcp& lcp, const LcpOptions& options) {
  return lemke(lcp, {.max_pivots = options.max_pivots, .tolerance = options.tolerance, .covering = {}});
}

}  // namespace perp
