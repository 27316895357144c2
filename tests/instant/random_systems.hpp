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
