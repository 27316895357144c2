#include "instant/scales.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"

namespace perp {
Scales scales_of(const Model& model, const State& x, const Instant& instant) {
  Scales s{.length = 0};
  Vector free;
  solve_mass(model, instant, instant.k, free);
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    const int linear = b.kind == BodyKind::Generalized ? b.nv : b.kind == BodyKind::Planar ? 2 : 3;
    s.length = std::max(s.length, x.q.segment(b.q0, linear).cwiseAbs().maxCoeff());
    s.speed = std::max(s.speed, x.nu.segment(b.v0, linear).cwiseAbs().maxCoeff());
    s.acceleration = std::max(s.acceleration, free.segment(b.v0, linear).cwiseAbs().maxCoeff());
  }
  const auto add = [&](const auto& W, const Vector3& position) {
    for (const int body : {W.a, W.b})
      if (model.bodies()[at(body)].nv > 0)
        s.length = std::max(s.length, (position - instant.X[at(body)].p).norm());
  };
  for (const ContactInstant& c : instant.contacts) {
    add(c.W, c.position);
    s.speed = std::max(s.speed, c.velocity(x.nu).cwiseAbs().maxCoeff());
    s.acceleration = std::max(s.acceleration, c.W.velocity(free).cwiseAbs().maxCoeff());
  }
  for (const JointGeometry& j : model.joints())
    s.length = std::max({s.length, j.anchor_a.norm(), j.anchor_b.norm()});
  for (const JointRowInstant& row : instant.joint_frictions)
    s.speed = std::max(s.speed, std::abs(row.velocity(x.nu)));
  if (s.length == 0)
    for (const Body& b : model.bodies())
      if (b.mass > 0) s.length = std::max(s.length, std::sqrt(b.J.trace() / b.mass));
  if (s.length == 0) s.length = s.acceleration > 0 && s.speed > 0 ? s.speed * s.speed / s.acceleration : 1;
  if (s.speed == 0)  // what turns about where it is
    for (const Twist& V : instant.V) s.speed = std::max(s.speed, s.length * V.w.norm());
  s.acceleration = std::max(s.acceleration, s.speed * s.speed / s.length);
  s.speed = std::max(s.speed, std::sqrt(s.acceleration * s.length));
  return s;
}

void Scales::widen(const Scales& other) {
  length = std::max(length, other.length);
  speed = std::max(speed, other.speed);
  acceleration = std::max(acceleration, other.acceleration);
}

}  // namespace perp
