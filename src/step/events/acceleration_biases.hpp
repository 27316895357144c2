// What relative velocities gain besides W^T nu': the last term of (19), (20) and of their tangential counterparts.
#pragma once

#include <span>
#include <vector>

#include "perp/instant/derivatives.hpp"

namespace perp {

/// b of d/dt (W^T nu + explicit part) = W^T nu' + b, in the order of an Instant's contacts, joint rows and joint frictions
/// [m/s^2, rad/s^2]. Contacts that are not asked for keep zero.
struct AccelerationBiases {
  std::vector<Vector3> contacts;
  std::vector<Vector3> moments;  ///< of their angular velocities, as Instant::moments [rad/s^2]
  std::vector<double> joint_rows, joint_frictions;

  /// Of the system at x, of which `instant` is, for the contacts numbered in `asked`.
  void evaluate(const Model& model, const State& x, const Instant& instant, std::span<const int> asked);

 private:
  std::vector<ContactDerivative> points_;  // of one contact
};

}  // namespace perp
