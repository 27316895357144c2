#include "perp/model/joint.hpp"

#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/model/gap.hpp"

namespace perp {

Joint fixed(BodyId a, BodyId b, JointOptions options) { return {JointKind::Fixed, a, b, std::move(options)}; }
Joint ball(BodyId a, BodyId b, JointOptions options) { return {JointKind::Ball, a, b, std::move(options)}; }
Joint revolute(BodyId a, BodyId b, JointOptions options) {
  return {JointKind::Revolute, a, b, std::move(options)};
}
Joint prismatic(BodyId a, BodyId b, JointOptions options) {
  return {JointKind::Prismatic, a, b, std::move(options)};
}

namespace {

/// Which relative motions a joint forbids, in its own frame (axis, side t, side o = axis x t).
struct Forbidden {
  bool along_axis, across_axis;  // translations
  bool about_axis, tilting;      // rotations
  JointFreedom freedom;
};

Forbidden forbidden(JointKind kind) {
  switch (kind) {
    case JointKind::Fixed:
      return {true, true, true, true, JointFreedom::None};
    case JointKind::Ball:
      return {true, true, false, false, JointFreedom::None};
    case JointKind::Revolute:
      return {true, true, false, true, JointFreedom::Rotation};
    case JointKind::Prismatic:
      return {false, true, true, true, JointFreedom::Translation};
  }
  return {};
}

}  // namespace

JointGeometry joint_geometry(const Joint& joint, const Pose& X_WA, const Pose& X_WB, bool planar) {
  const JointOptions& options = joint.options;
  const std::string where = "joint '" + options.name + "'";
  if (joint.a == joint.b) refuse(where, "b", "the body that a is too", "a joint needs two bodies");
  if (!options.point.allFinite()) refuse(where, "point", "not finite", "needs finite entries [m]");
  const double length = options.axis.norm();
  if (!(length > 0) || !std::isfinite(length)) refuse(where, "axis", length, "needs a direction");
  if (!(options.friction >= 0) || !std::isfinite(options.friction))
    refuse(where, "friction", options.friction, "needs to be >= 0 and finite [N m or N]");

  const Forbidden no = forbidden(joint.kind);
  if (options.friction > 0 && no.freedom == JointFreedom::None)
    refuse(where, "friction", options.friction, "needs a joint with one degree of freedom");

  const Matrix3 frame = contact_frame(options.axis / length);  // axis, t, o in world axes
  const Vector3 axis = frame.col(0), t = frame.col(1), o = frame.col(2);
  const auto in_a = [&](const Vector3& d) -> Vector3 { return X_WA.q.conjugate() * d; };
  const auto in_b = [&](const Vector3& d) -> Vector3 { return X_WB.q.conjugate() * d; };

  if (planar) {
    const bool turns = std::abs(axis.z()) > 1 - 1e-12, lies = std::abs(axis.z()) < 1e-12;
    if (joint.kind == JointKind::Revolute && !turns)
      refuse(where, "axis", "not the z axis", "a planar revolute joint turns about z");
    if (joint.kind == JointKind::Prismatic && !lies)
      refuse(where, "axis", "not in the xy plane", "a planar prismatic joint slides in the xy plane");
  }

  JointGeometry g;
  g.kind = joint.kind;
  g.name = options.name;
  g.a = joint.a;
  g.b = joint.b;
  g.point = options.point;
  g.axis = options.axis;
  g.anchor_a = X_WA.inverse() * options.point;
  g.anchor_b = X_WB.inverse() * options.point;
  g.axis_a = in_a(axis);
  g.side_a = in_a(t);
  g.side_b = in_b(t);
  g.freedom = no.freedom;
  g.friction = options.friction;

  // in the plane only motions along x, y and about z exist
  const auto point = [&](const Vector3& d) {
    if (!planar || std::abs(d.z()) < 0.5) g.rows.push_back({JointRow::Kind::Point, in_a(d), Vector3::Zero()});
  };
  const auto perpendicular = [&](const Vector3& u, const Vector3& w) {
    if (!planar || std::abs(u.cross(w).z()) > 0.5)
      g.rows.push_back({JointRow::Kind::Perpendicular, in_a(u), in_b(w)});
  };
  if (no.across_axis) {
    point(t);
    point(o);
  }
  if (no.along_axis) point(axis);
  if (no.tilting) {
    perpendicular(t, axis);
    perpendicular(o, axis);
  }
  if (no.about_axis) perpendicular(o, t);
  return g;
}

}  // namespace perp
