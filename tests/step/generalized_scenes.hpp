// Scenes of joints written once more in coordinates of their own.
#pragma once

#include <cmath>

#include "perp/study/scene.hpp"

namespace perp {

/// The exact motion of `joints` in the angles of two of its planar bodies (or of one).
inline std::function<State(double)> by_angles(const Scene& joints, const State& start,
                                              std::vector<std::string> names) {
  return [joints, start, names](double t) {
    const State full = joints.exact(t);
    State x = start;
    x.t = t;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const BodyId body = joints.model.find_body(names[i]);
      x.q[static_cast<Eigen::Index>(i)] = joints.model.angle(full, body);
      x.nu[static_cast<Eigen::Index>(i)] = joints.model.angular_velocity(full, body).z();
    }
    return x;
  };
}

/// Unit masses on unit strings, angles from straight down:
///   2 a1'' + c a2'' = -s a2'^2 - 2 g sin a1,   c a1'' + a2'' = s a1'^2 - g sin a2,   c, s of a1 - a2.
inline Scene double_pendulum_of_angles() {
  constexpr double g = 9.81;
  const Scene joints = scene("double-pendulum");
  Scene s;
  s.name = "double-pendulum";
  s.t_end = 1;
  const auto mass = [](const Vector& a) -> Matrix {
    const double c = std::cos(a[0] - a[1]);
    return Eigen::Matrix2d{{2, c}, {c, 1}};
  };
  const auto force = [](const Vector& a, const Vector& w, double) -> Vector {
    const double sn = std::sin(a[0] - a[1]);
    return Vector2(-sn * w[1] * w[1] - 2 * g * std::sin(a[0]), sn * w[0] * w[0] - g * std::sin(a[1]));
  };
  const auto potential = [](const Vector& a) { return -g * (2 * std::cos(a[0]) + std::cos(a[1])); };
  s.model.add_generalized(2, {.mass = mass, .force = force, .potential = potential}, "arms");
  s.start = s.model.rest();
  s.exact = by_angles(joints, s.start, {"upper", "lower"});
  s.start = s.exact(0);
  return s;
}

/// The slider-crank of spatial bodies and revolute joints about z: 20 equations, three more than they need.
inline Scene spatial_slider_crank() {
  const Scene planar = scene("slider-crank");
  Scene s;
  s.model.set_gravity(Vector3::Zero());
  std::vector<BodyId> bodies{ground};
  for (const Body& b : planar.model.bodies())
    if (b.nv > 0) {
      const double J = b.J(2, 2);
      bodies.push_back(s.model.add_body(Inertia::principal(b.mass, {0.6 * J, 0.7 * J, J}),
                                        {.pose = b.rest, .name = b.name}));
    }
  for (const JointGeometry& j : planar.model.joints())
    s.model.add_joint({j.kind, bodies[static_cast<std::size_t>(j.a.index)],
                       bodies[static_cast<std::size_t>(j.b.index)], j.asked});
  s.start = s.model.rest();
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const BodyId id{static_cast<int>(i)};
    s.model.set_velocity(s.start, bodies[i], planar.model.velocity(planar.start, id),
                         planar.model.angular_velocity(planar.start, id));
  }
  return s;
}

/// A slider-crank in the crank's angle: I(a) a'' + I'/2 a'^2 = -0.2 N m, while it turns forwards.
inline Scene slider_crank_of_one_angle() {
  const Scene joints = scene("slider-crank");
  const auto slope = [](double a) {  // of the slider's place by the angle, and of the slope
    constexpr double r = 0.15, l = 0.4;
    const double s = std::sin(a), c = std::cos(a), root = std::sqrt(l * l - r * r * s * s);
    const double root_1 = -r * r * s * c / root;
    return std::pair(-r * s - r * r * s * c / root,
                     -r * c - r * r * ((c * c - s * s) / root - s * c * root_1 / (root * root)));
  };
  Scene s;
  s.name = "slider-crank";
  s.t_end = 0.3;
  const auto mass = [=](const Vector& a) {
    return Matrix(Matrix::Constant(1, 1, 0.01 + 0.5 * std::pow(slope(a[0]).first, 2)));
  };
  const auto force = [=](const Vector& a, const Vector& w, double) -> Vector {
    const auto [first, second] = slope(a[0]);
    return Vector::Constant(1, -0.5 * first * second * w[0] * w[0] - 0.2);
  };
  s.model.add_generalized(1, {.mass = mass, .force = force}, "crank");
  s.start = s.model.rest();
  s.exact = by_angles(joints, s.start, {"crank"});
  s.start = s.exact(0);
  return s;
}

}  // namespace perp
