// States, and how they move.
#include <cmath>

#include "mechanics.hpp"

namespace checker {
namespace {

Quaterniond turn(const Vector3d& v) {
  const double angle = v.norm();
  if (angle == 0) return Quaterniond::Identity();
  return Quaterniond(Eigen::AngleAxisd(angle, v / angle));
}

/// The rotation vector of q; exact for small turns too.
Vector3d turned(Quaterniond q) {
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine == 0) return Vector3d::Zero();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

}  // namespace

void prescribe(const Scene& scene, State& x) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.moves()) continue;
    BodyState& s = x.bodies[i];
    s = {};
    s.at = body.rest;
    if (body.motion.kind == "shaker") {
      const double phase = body.motion.rate * x.t + body.motion.phase;
      s.at.p += std::sin(phase) * body.motion.vector;
      s.v = body.motion.rate * std::cos(phase) * body.motion.vector;
    }
    if (body.motion.kind == "turntable") {
      s.w = body.motion.rate * body.motion.vector.normalized();
      s.at.q = turn(x.t * s.w) * body.rest.q;
    }
  }
}

Vector3d surface_velocity(const Body& body) {
  return body.motion.kind == "belt" ? body.motion.vector : Vector3d::Zero();
}

State first_state(const Scene& scene) {
  State x;
  x.bodies.resize(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    x.bodies[i] = {body.first(), body.starts_elsewhere ? body.start_angle : body.rest_angle, body.v, body.w};
  }
  prescribe(scene, x);
  return x;
}

State moved(const Scene& scene, const State& x, const State& by, double h) {
  State y = x;
  y.t = x.t + h;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    BodyState& s = y.bodies[i];
    s.v = by.bodies[i].v;
    s.w = by.bodies[i].w;
    s.at.p += h * s.v;
    s.at.q = turn(h * s.w) * s.at.q;
    s.angle += h * s.w.z();
  }
  prescribe(scene, y);
  return y;
}

State between(const Scene& scene, const State& x, const State& y, double h) {
  State u = x;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (!body.moves()) continue;
    BodyState& s = u.bodies[i];
    s.v = (y.bodies[i].at.p - x.bodies[i].at.p) / h;
    s.w.setZero();
    if (body.kind == Kind::Planar) s.w.z() = (y.bodies[i].angle - x.bodies[i].angle) / h;
    if (body.kind == Kind::Spatial) s.w = turned(y.bodies[i].at.q * x.bodies[i].at.q.conjugate()) / h;
  }
  return u;
}

double kinetic_energy(const Scene& scene, const State& x) {
  double energy = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (!body.moves()) continue;
    const BodyState& s = x.bodies[i];
    const Vector3d w = s.at.q.conjugate() * s.w;
    energy += 0.5 * body.mass * s.v.squaredNorm() + 0.5 * w.dot(body.inertia() * w);
  }
  return energy;
}

}  // namespace checker
