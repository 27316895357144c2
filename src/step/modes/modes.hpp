// Which contacts are closed and which slide: the sets that the instantaneous model goes by.
#pragma once

#include <vector>

#include "instant/scales.hpp"

namespace perp {

/// A contact with psi_n = 0 and u_n = 0.
struct ClosedContact {
  int point = 0;        ///< among all points of the model
  bool slides = false;  ///< u_f != 0, or it spins against torsion
  Vector3 direction =
      Vector3::Zero();  ///< of u_f, unit, world axes, if it slides; with torsion that of slip_of
  bool rolls = false;   ///< against rolling friction
  Vector3 rolling = Vector3::Zero();  ///< direction of roll_of, unit, world axes, if it does
  double lever = 1;                   ///< of a contact with moments: what angular velocities count by [m]
};

/// Which contacts are closed and what slides, by velocity: the sets S and R of (3), (4).
struct Modes {
  std::vector<ClosedContact> contacts;  ///< ascending by point
  std::vector<int> joints;              ///< of each joint friction: sign of its rate, 0 at rest

  const ClosedContact* find(int point) const;
};

/// Whether a joint's friction is against turning or sliding.
[[nodiscard]] JointFreedom freedom_of(const Model& model, const JointRowInstant& friction);

/// Closed are contacts with psi_n and u_n small, and the points in `closing`, whatever their u_n; those whose |u_f|, and joints
/// whose rate, is not small slide.
[[nodiscard]] Modes modes_by_velocity(const Model& model, const State& x, const Instant& instant,
                                      const Scales& scales, const std::vector<int>& closing = {});

}  // namespace perp
