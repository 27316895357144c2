// Springs that a step's explicit loads cannot follow.
#pragma once

#include <string>

#include "perp/instant/instant.hpp"

namespace perp {

/// How a step of explicit loads takes dampers.
enum class Damping {
  Explicit,  ///< at the start: `lcp`, stable for h² k w + 2 h c w <= 4
  Midway     ///< at the step's own velocity: `ncp2`, stable for h² k w <= 4
};

/// A spring of stiffness k and damping c, w the inverse of the mass that it moves past the joints, makes an oscillation that a step of
/// size h lets grow if it is past its bound (Damping). Names the worst spring that is and moves at nu (|rate| above rounding of
/// `speed`), and the step that would do; empty if there is none. A lower bound of what is unstable: of springs that act together,
/// each is looked at alone.
std::string unstable_spring(const Model& model, const Instant& s, const Vector& nu, double h, Damping damping,
                            double speed);

}  // namespace perp
