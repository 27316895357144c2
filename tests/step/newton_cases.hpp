// Bodies on curved gaps at starts of every kind: what Newton's method of the implicit steps is tried on.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "perp/model/differentiable_gap.hpp"
#include "perp/model/gaps.hpp"
#include "perp/model/model.hpp"
#include "perp/step/ncp2_stepper.hpp"

namespace perp::testing {

/// A sphere of radius r about the point c of B in a hollow cylinder of radius R about A's x axis.
inline Gap offset_sphere_in_cylinder(double R, double r, const Vector3& c) {
  return differentiable([=]<class S>(const PoseOf<S>& A, const PoseOf<S>& B, S) {
    using std::sqrt;
    using V = Eigen::Matrix<S, 3, 1>;
    const V centre = B * V(c.cast<S>()), axis = A.R.col(0), s = centre - A.p;
    const V d = s - axis * axis.dot(s);
    const S distance = sqrt(d.dot(d));
    ContactPointOf<S> point;
    point.normal = -d / distance;
    point.gap = R - r - distance;
    point.point = centre - r * point.normal;
    return point;
  });
}

/// An ellipsoid on a plane, or a rod with spheres at its ends in a hollow cylinder.
struct NewtonCase {
  std::string name;
  Model model;
  State x;
};

enum class Start { Rest, Sliding, Impact, Spin };
inline constexpr Start starts[] = {Start::Rest, Start::Sliding, Start::Impact, Start::Spin};

inline void set_out(NewtonCase& c, BodyId body, Start start, std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vector3(number(random), number(random), number(random)); };
  Vector3 v = Vector3::Zero(), w = Vector3::Zero();
  if (start == Start::Sliding) v = {1 + number(random), number(random), 0}, w = vector();
  if (start == Start::Impact) v = {number(random), 0, -2};
  if (start == Start::Spin) w = 5 * vector();  // less than a radian in the longest step tried
  c.model.set_velocity(c.x, body, v, w);
}

inline NewtonCase ellipsoid_case(Start start, double mu, std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  NewtonCase c;
  c.name = "ellipsoid on a plane";
  const Vector3 axes(0.3, 0.2, 0.1);
  const BodyId body = c.model.add_body(Inertia::solid_ellipsoid(1, axes));
  c.model.add_contact(ground, body, ellipsoid_on_plane(axes), {.mu = mu});
  c.x = c.model.rest();
  const Quaternion q = rotation({number(random), number(random), number(random)});
  c.model.set_orientation(c.x, body, q);
  const Vector3 m = q.conjugate() * Vector3::UnitZ();
  const double height = std::sqrt(m.dot(axes.cwiseAbs2().cwiseProduct(m)));
  c.model.set_position(c.x, body, {0, 0, height + (start == Start::Impact ? 1e-3 : 0)});
  set_out(c, body, start, random);
  return c;
}

inline NewtonCase rod_case(Start start, double mu, std::mt19937& random) {
  NewtonCase c;
  c.name = "rod with two spheres in a cylinder";
  const double R = 1, r = 0.1, half = 0.6;
  const BodyId body = c.model.add_body(Inertia::principal(1, {0.13, 0.13, 0.01}));
  for (const double side : {-1.0, 1.0})
    c.model.add_contact(ground, body, offset_sphere_in_cylinder(R, r, {0, 0, side * half}), {.mu = mu});
  c.x = c.model.rest();
  // the rod's z axis lies across the cylinder, both spheres on the wall
  std::uniform_real_distribution<double> number(-1, 1);
  const double tilt = 0.3 * number(random), reach = std::sqrt((R - r) * (R - r) - half * half);
  const Quaternion across = rotation({std::numbers::pi / 2 + tilt, 0, 0});
  const Vector3 low(0, std::sin(tilt) * reach, -std::cos(tilt) * reach);
  c.model.set_orientation(c.x, body, across);
  c.model.set_position(c.x, body, start == Start::Impact ? Vector3((1 - 1e-3) * low) : low);
  set_out(c, body, start, random);
  return c;
}

}  // namespace perp::testing
