// A motion by as few rows as the eye needs, and a cubic between them.
#pragma once

#include <vector>

#include "perp/view/recorded_run.hpp"

namespace perp {

/// Between two rows (t_0, X_0, V_0), (t_1, X_1, V_1): the cubic Hermite polynomials of the positions with their velocities, and of the
/// quaternions with q' = (0, w) q/2, made a unit quaternion. Order 4 in t_1 - t_0 where the motion is smooth.
[[nodiscard]] Pose between(double t_0, const Moment& m_0, double t_1, const Moment& m_1, double t);

struct Keyframes {
  std::vector<int> rows;      ///< kept, ascending, the first and the last among them
  double position_error = 0;  ///< of `between` at the rows that are not kept, at most [m]
  double turning_error = 0;   ///< [rad]
};

/// Rows such that `between` is within `position` [m] and `turning` [rad] of all others. Both rows of an event, at one time, are kept
/// where velocities jump.
[[nodiscard]] Keyframes thinned(const std::vector<double>& t, const std::vector<Moment>& moments,
                                double position, double turning);

}  // namespace perp
