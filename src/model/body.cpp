#include "perp/model/body.hpp"

#include <cmath>

#include "model/time_slope.hpp"
#include "perp/core/errors.hpp"
#include "perp/model/timing.hpp"

namespace perp {
namespace {

/// The numbers of a maker that ends in a pose.
std::vector<double> numbers(std::initializer_list<double> first, const Pose& pose) {
  std::vector<double> all(first);
  for (const double x : pose.p) all.push_back(x);
  for (const double x : {pose.q.w(), pose.q.x(), pose.q.y(), pose.q.z()}) all.push_back(x);
  return all;
}

}  // namespace

Twist PrescribedMotion::acceleration_at(double t) const {
  if (acceleration) return acceleration(t);
  const auto values = [this](double s) {
    const Twist V = twist(s);
    Eigen::Matrix<double, 6, 1> all;
    all << V.v, V.w;
    return all;
  };
  const Eigen::Matrix<double, 6, 1> a = time_slope<6>(values, t);
  return {a.head<3>(), a.tail<3>()};
}

using TimedTwist = Timed<Twist(double)>;

PrescribedMotion PrescribedMotion::shaker(const Vector3& amplitude, double rate, double phase,
                                          const Pose& pose) {
  return {
      .pose =
          [=](double t) {
            return Pose{pose.p + std::sin(rate * t + phase) * amplitude, pose.q};
          },
      .twist = TimedTwist(
          [=](double t) {
            return Twist{rate * std::cos(rate * t + phase) * amplitude, Vector3::Zero()};
          },
          {}),
      .surface = {},
      .acceleration =
          [=](double t) {
            return Twist{-rate * rate * std::sin(rate * t + phase) * amplitude, Vector3::Zero()};
          },
      .recipe = {"shaker", numbers({amplitude.x(), amplitude.y(), amplitude.z(), rate, phase}, pose), {}}};
}

PrescribedMotion PrescribedMotion::turntable(const Vector3& axis, double rate, const Pose& pose) {
  if (!(axis.norm() > 0)) refuse("PrescribedMotion::turntable", "axis", axis.norm(), "needs a direction");
  const Vector3 w = rate * axis.normalized();
  return {.pose =
              [=](double t) {
                return Pose{pose.p, rotation(t * w) * pose.q};
              },
          .twist = TimedTwist(
              [=](double) {
                return Twist{Vector3::Zero(), w};
              },
              {.steady = true}),
          .surface = {},
          .acceleration = [](double) { return Twist{}; },
          .recipe = {"turntable", numbers({axis.x(), axis.y(), axis.z(), rate}, pose), {}}};
}

PrescribedMotion PrescribedMotion::belt(const Vector3& velocity, const Pose& pose) {
  return {.pose = [=](double) { return pose; },
          .twist = TimedTwist([](double) { return Twist{}; }, {.steady = true}),
          .surface = [=](double, const Vector3&) { return velocity; },
          .acceleration = [](double) { return Twist{}; },
          .recipe = {"belt", numbers({velocity.x(), velocity.y(), velocity.z()}, pose), {}}};
}

}  // namespace perp
