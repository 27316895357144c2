// Which contacts are closed and which slide: the sets that the instantaneous model goes by.
#pragma once

#include <vector>

#include "perp/instant/instant.hpp"

namespace perp {

/// A contact with psi_n = 0 and u_n = 0.
struct ClosedContact {
  int point = 0;                        ///< among all points of the model
  bool slides = false;                  ///< u_f != 0
  Vector3 direction = Vector3::Zero();  ///< of u_f, unit, world axes, if it slides
};

/// Which contacts are closed and what slides, by velocity: the sets S and R of (3), (4).
struct Modes {
  std::vector<ClosedContact> contacts;  ///< ascending by point
  std::vector<int> joints;              ///< of each joint friction: sign of its rate, 0 at rest

  const ClosedContact* find(int point) const;
};

/// What lengths, speeds and accelerations of a system are measured by: the same in all units.
struct Scales {
  double length = 1;        ///< largest of positions and lever arms [m]
  double speed = 0;         ///< largest of velocities, and of sqrt(acceleration length) [m/s]
  double acceleration = 0;  ///< largest of loads over masses, as accelerations of contact points [m/s^2]

  void widen(const Scales& other);  ///< to the larger of both: of a run that comes to rest

  double small_gap() const { return 1e-10 * length; }
  double small_speed() const { return 1e-9 * speed; }
  double small_rate(JointFreedom freedom) const {
    return freedom == JointFreedom::Rotation ? small_speed() / length : small_speed();
  }
};
/// Whether a joint's friction is against turning or sliding.
[[nodiscard]] JointFreedom freedom_of(const Model& model, const JointRowInstant& friction);

[[nodiscard]] Scales scales_of(const Model& model, const State& x, const Instant& instant);

/// Closed are contacts with psi_n and u_n small, and the points in `closing`, whatever their u_n; those whose |u_f|, and joints
/// whose rate, is not small slide.
[[nodiscard]] Modes modes_by_velocity(const Model& model, const State& x, const Instant& instant,
                                      const Scales& scales, const std::vector<int>& closing = {});

}  // namespace perp
