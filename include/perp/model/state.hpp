// Where the system is: a value, apart from the model.
#pragma once

#include "perp/core/types.hpp"

namespace perp {

/// Time, coordinates and velocities of all bodies, in the order in which they were added (layout: BodyKind).
struct State {
  double t = 0;  ///< [s]
  Vector q;      ///< [m, -, rad]
  Vector nu;     ///< [m/s, rad/s]; q' = G(q) nu, the seed's (6)
};

}  // namespace perp
