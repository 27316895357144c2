// Where the system is: a value, apart from the model.
#pragma once

#include "perp/core/types.hpp"

namespace perp {

/// Time, coordinates and velocities of all bodies, in the order in which they were added (layout: BodyKind).
struct State {
  double t = 0;  ///< [s]
  Vector q;      ///< [m, -, rad]
  Vector nu;     ///< [m/s, rad/s]; q' = G(q) nu, the seed's (6)
  /// Where the angles of joints between spatial bodies were last, to the quarter turn, so that they go on past pi: orientations
  /// alone do not count turns. Steps keep it (Model::follow_turns); empty means near zero.
  Vector winding = {};
};

}  // namespace perp
