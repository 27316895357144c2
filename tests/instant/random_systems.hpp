// Systems at random for tests: chains and loops of bodies of every kind, with joints and contacts.
#pragma once

#include <random>

#include "perp/model/gaps.hpp"
#include "perp/model/model.hpp"

namespace perp::testing {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double number(double scale = 1) { return std::uniform_real_distribution<double>(-scale, scale)(engine_); }
  double positive() { return std::uniform_real_distribution<double>(0.5, 2)(engine_); }
  Vector3 vector(double scale = 1) { return {number(scale), number(scale), number(scale)}; }
  Quaternion orientation() { return rotation(vector(2)); }
  Inertia inertia() {
    const Matrix3 R = orientation().toRotationMatrix();
    const double a = positive(), b = positive(), c = std::abs(a - b) + 0.9 * (a + b - std::abs(a - b));
    return {positive(), R * Vector3(a, b, c).asDiagonal() * R.transpose()};
  }

 private:
  std::mt19937 engine_;
};

/// Two spatial bodies, a planar one, a particle, a shaker and a turntable, with contacts between many of them.
inline Model all_kinds(Random& random) {
  Model model;
  const BodyId a = model.add_body(random.inertia(), {.pose = {{0, 0, 2}, random.orientation()}});
  const BodyId b = model.add_body(random.inertia(), {.pose = {{1, 0.5, 3}, random.orientation()}});
  const BodyId plate =
      model.add_planar_body(random.positive(), random.positive(), {.pose = {{0, 3, 0}, {1, 0, 0, 0}}});
  const BodyId bead = model.add_particle(random.positive(), {.pose = {{0.2, 0.3, 0}, {1, 0, 0, 0}}});
  const BodyId shaker = model.add_prescribed(PrescribedMotion::shaker({0.1, 0.2, 0.3}, 3));
  const BodyId table =
      model.add_prescribed(PrescribedMotion::turntable({0.1, 0.2, 1}, 2, {{0.5, 0, 0}, {1, 0, 0, 0}}));
  model.add_contact(ground, a, box_on_plane({1, 1.2, 0.8}), {.mu = 0.3});
  model.add_contact(a, b, sphere_on_sphere(0.5, 0.4), {.mu = 0.2, .tangent = {0, 1, 0}});
  model.add_contact(shaker, b, capsule_on_plane(0.2, 0.5), {.mu = 0.1});
  model.add_contact(b, table, sphere_on_sphere(0.5, 0.4), {.mu = 0.1});
  model.add_contact(table, bead, sphere_on_plane(0.1), {.mu = 0.5});
  model.add_contact(shaker, plate, box_on_line(1, 2), {.mu = 0.5});
  model.add_contact(ground, plate, disc_on_line(0.5));
  return model;
}

/// Spatial bodies a, b, a turntable, planar bodies c, d, and every kind of joint between them at random places.
inline Model with_all_joints(Random& random) {
  Model model;
  const BodyId table =
      model.add_prescribed(PrescribedMotion::turntable({0.3, 1, 0.2}, 2, {{0, 0, 1}, {1, 0, 0, 0}}));
  const BodyId a = model.add_body(random.inertia(), {.pose = {random.vector(), random.orientation()}});
  const BodyId b = model.add_body(random.inertia(), {.pose = {random.vector(), random.orientation()}});
  const BodyId c = model.add_planar_body(1, 1, {.pose = {{1, 0, 0}, rotation({0, 0, random.number()})}});
  const BodyId d = model.add_planar_body(1, 1, {.pose = {{0, 1, 0}, rotation({0, 0, random.number()})}});
  const BodyId p = model.add_particle(1, {.pose = {random.vector(), {1, 0, 0, 0}}});
  const auto options = [&] { return JointOptions{.point = random.vector(), .axis = random.vector()}; };
  const auto spatial = [&](Joint (*make)(BodyId, BodyId, JointOptions), JointOptions with) {
    model.add_joint(make(a, b, with));
    model.add_joint(make(table, a, with));
  };
  spatial(fixed, options());
  spatial(ball, options());
  spatial(revolute, options());
  spatial(prismatic, options());
  spatial(cylindrical, options());
  spatial(planar, options());
  JointOptions crossed = options();
  crossed.axis_b = contact_frame(crossed.axis.normalized()) * Vector3(0, 0.6, 0.8);
  spatial(universal, crossed);
  JointOptions special = options();
  special.axis_b = random.vector();
  special.point_b = random.vector();
  special.lead = 0.3;
  special.ratio = -1.7;
  spatial(screw, special);
  spatial(rod, special);
  spatial(gear, special);
  model.add_joint(rod(p, b, special));
  special.axis = Vector3::UnitZ();
  special.axis_b = -Vector3::UnitZ();
  special.point.z() = special.point_b.z() = 0;
  for (const auto make : {fixed, ball, revolute, rod, gear}) model.add_joint(make(c, d, special));
  model.add_joint(prismatic(c, d, {.point = {1, 2, 0}, .axis = {1, 0.5, 0}}));
  model.add_joint(revolute(a, c, options()));  // a planar body on a spatial one
  return model;
}

/// A state near rest with all coordinates and velocities disturbed (joints need not hold in it).
inline State disturbed(const Model& model, Random& random, double scale) {
  State x = model.rest();
  x.t = random.number();
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    const BodyId id{static_cast<int>(i)};
    if (b.nv == 0) continue;
    for (int j = 0; j < b.nv; ++j) x.nu[b.v0 + j] = random.number();
    Vector3 p = b.rest.p + random.vector(scale);
    if (b.kind == BodyKind::Planar) p.z() = 0;
    if (b.kind == BodyKind::Generalized)
      for (int j = 0; j < b.nq; ++j) x.q[b.q0 + j] = random.number(scale);
    else
      model.set_position(x, id, p);
    if (b.kind == BodyKind::Spatial) model.set_orientation(x, id, b.rest.q * rotation(random.vector(scale)));
    if (b.kind == BodyKind::Planar) model.set_orientation(x, id, rotation({0, 0, random.number(scale)}));
  }
  return x;
}

/// x after the time h at the velocities nu, and t with it.
inline State moved(const Model& model, const State& x, double h) {
  State y = x;
  y.t += h;
  move(model, x.nu, h, y.q);
  return y;
}

}  // namespace perp::testing
