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
