#include "instant/load_fault.hpp"

#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

std::string spelled(const Vector3& v) {
  return "(" + shortest(v.x()) + ", " + shortest(v.y()) + ", " + shortest(v.z()) + ")";
}

std::string quoted_name(const Model& model, BodyId b) { return "'" + model.body(b).name + "'"; }

/// Forces are told apart by their number among those of their body, from 1, as they stand in the scene.
std::string force_fault(const Model& model, const State& x) {
  std::vector<int> number(model.bodies().size(), 0);
  for (const BodyForce& load : model.forces()) {
    const int k = ++number[at(load.body.index)];
    const Wrench w = load.wrench(model, x);
    const std::string name =
        "force " + std::to_string(k) + " on body " + quoted_name(model, load.body) + ", ";
    if (!w.force.allFinite()) return name + spelled(w.force) + " N,";
    if (!w.moment.allFinite()) return name + "its moment " + spelled(w.moment) + " N m,";
  }
  return {};
}

std::string spring_fault(const Model& model, const Instant& s) {
  for (const Spring& spring : model.springs()) {
    const auto end = [&](BodyId b, const Vector3& point) {
      const Vector3 p = s.X[at(b.index)] * point;
      return Vector3(p + s.V[at(b.index)].at(p - s.X[at(b.index)].p));
    };
    const Vector3 across = end(spring.b, spring.point_b) - end(spring.a, spring.point_a);
    if (!(std::isfinite((spring.stiffness + spring.damping) * across.norm())))
      return "the spring between " + quoted_name(model, spring.a) + " and " + quoted_name(model, spring.b);
  }
  return {};
}

std::string joint_fault(const Model& model, const State& x, const Instant& s) {
  for (const JointMotor& motor : model.motors()) {
    const JointRowInstant& c = s.coordinate(motor.joint, motor.coordinate);
    const double effort = motor.effort(model, x, c.psi_b, c.velocity(x.nu));
    if (!std::isfinite(effort))
      return "the motor of joint '" + model.joint(motor.joint).name + "', " + shortest(effort) + ",";
  }
  for (const JointSpring& spring : model.joint_springs())
    if (!std::isfinite(spring.stiffness * s.coordinate(spring.joint, spring.coordinate).psi_b))
      return "the spring of joint '" + model.joint(spring.joint).name + "'";
  return {};
}

}  // namespace

std::string load_fault(const Model& model, const State& x, const Instant& instant) {
  if (std::string fault = force_fault(model, x); !fault.empty()) return fault;
  if (std::string fault = spring_fault(model, instant); !fault.empty()) return fault;
  if (std::string fault = joint_fault(model, x, instant); !fault.empty()) return fault;
  for (const Body& body : model.bodies())
    if (body.nv > 0 && !instant.k.segment(body.v0, body.nv).allFinite())
      return (body.kind == BodyKind::Generalized ? "the force of body '" : "the load on body '") + body.name +
             "'";
  return "a load";
}

}  // namespace perp
