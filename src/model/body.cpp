#include "perp/model/body.hpp"

#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {

PrescribedMotion PrescribedMotion::shaker(const Vector3& amplitude, double rate, double phase,
                                          const Pose& pose) {
  return {.pose =
              [=](double t) {
                return Pose{pose.p + std::sin(rate * t + phase) * amplitude, pose.q};
              },
          .twist =
              [=](double t) {
                return Twist{rate * std::cos(rate * t + phase) * amplitude, Vector3::Zero()};
              },
          .surface = {}};
}

PrescribedMotion PrescribedMotion::turntable(const Vector3& axis, double rate, const Pose& pose) {
  if (!(axis.norm() > 0)) refuse("PrescribedMotion::turntable", "axis", axis.norm(), "needs a direction");
  const Vector3 w = rate * axis.normalized();
  return {.pose =
              [=](double t) {
                return Pose{pose.p, rotation(t * w) * pose.q};
              },
          .twist =
              [=](double) {
                return Twist{Vector3::Zero(), w};
              },
          .surface = {}};
}

PrescribedMotion PrescribedMotion::belt(const Vector3& velocity, const Pose& pose) {
  return {.pose = [=](double) { return pose; },
          .twist = [](double) { return Twist{}; },
          .surface = [=](double, const Vector3&) { return velocity; }};
}

}  // namespace perp
