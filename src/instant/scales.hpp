// What is large and what is small in a system as it is now.
#pragma once

#include "perp/instant/instant.hpp"

namespace perp {

/// What lengths, speeds and accelerations of a system are measured by: the same in all units.
struct Scales {
  double length = 1;        ///< largest of positions and lever arms; of none, of radii of gyration [m]
  double speed = 0;         ///< largest of velocities, and of sqrt(acceleration length) [m/s]
  double acceleration = 0;  ///< largest of loads over masses, as accelerations of contact points [m/s^2]

  void widen(const Scales& other);  ///< to the larger of both: of a run that comes to rest

  double small_gap() const { return 1e-10 * length; }
  double small_speed() const { return 1e-9 * speed; }
  double small_rate(JointFreedom freedom) const {
    return freedom == JointFreedom::Rotation ? small_speed() / length : small_speed();
  }
};

[[nodiscard]] Scales scales_of(const Model& model, const State& x, const Instant& instant);

}  // namespace perp
