// How a contact's frame and a moving surface change: what derivatives and accelerations share.
#pragma once

#include "instant/pair_side.hpp"

namespace perp {

/// d(t) and d(o) from d(n), t the projection of a fixed `wish` across n (in the plane t = n x z).
template <class Derived>
void turn_frame(const ContactInstant& c, const Eigen::MatrixBase<Derived>& dn, Derived& dt, Derived& d_o) {
  const Vector3 n = c.frame.col(0), t = c.frame.col(1);
  if (c.tangents == 1) {
    dt = -skew(Vector3::UnitZ()) * dn;
  } else {
    const double along = n.dot(c.wish);
    const Matrix3 across = (Matrix3::Identity() - t * t.transpose()) / (c.wish - along * n).norm();
    dt = -across * (along * Matrix3::Identity() + n * c.wish.transpose()) * dn;
  }
  d_o = -skew(t) * dn + skew(n) * dt;
}

/// motion.surface at a contact's point with its derivatives, by central differences: it is a velocity field that its maker gave as
/// values alone.
struct SurfaceSlope {
  Vector3 value, by_t;
  Matrix3 by_point;
};
[[nodiscard]] SurfaceSlope surface_slope(const Model& model, const Instant& s, const ContactInstant& c,
                                         const PrescribedMotion& motion, double t);

/// acceleration_bias of a gap of a generalized body's own, by differences along the motion.
[[nodiscard]] Vector3 own_bias(const Model& model, const State& x, const ContactInstant& c);

}  // namespace perp
