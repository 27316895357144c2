#include "perp/model/joint.hpp"

#include <cmath>
#include <numbers>

#include "model/time_slope.hpp"
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
Joint cylindrical(BodyId a, BodyId b, JointOptions options) {
  return {JointKind::Cylindrical, a, b, std::move(options)};
}
Joint universal(BodyId a, BodyId b, JointOptions options) {
  return {JointKind::Universal, a, b, std::move(options)};
}
Joint planar(BodyId a, BodyId b, JointOptions options) {
  return {JointKind::Planar, a, b, std::move(options)};
}
Joint screw(BodyId a, BodyId b, JointOptions options) { return {JointKind::Screw, a, b, std::move(options)}; }
Joint rod(BodyId a, BodyId b, JointOptions options) { return {JointKind::Rod, a, b, std::move(options)}; }
Joint gear(BodyId a, BodyId b, JointOptions options) { return {JointKind::Gear, a, b, std::move(options)}; }

namespace {

using Kind = JointRow::Kind;

/// Which relative motions a joint forbids one by one, in its own frame (axis, side t, side o = axis x t).
struct Forbidden {
  bool along_axis, across_axis;  // translations
  bool about_axis, tilting;      // rotations
};

Forbidden forbidden(JointKind kind) {
  switch (kind) {
    case JointKind::Fixed:
      return {true, true, true, true};
    case JointKind::Ball:
    case JointKind::Universal:  // and its axes stay perpendicular
      return {true, true, false, false};
    case JointKind::Revolute:
      return {true, true, false, true};
    case JointKind::Prismatic:
      return {false, true, true, true};
    case JointKind::Cylindrical:
    case JointKind::Screw:  // and it slides as it turns
      return {false, true, false, true};
    case JointKind::Planar:
      return {true, false, false, true};
    case JointKind::Rod:
    case JointKind::Gear:
      break;
  }
  return {false, false, false, false};
}

bool one_freedom(JointKind kind) {
  return kind == JointKind::Revolute || kind == JointKind::Prismatic || kind == JointKind::Screw;
}

Vector3 direction(const std::string& where, const char* argument, const Vector3& v) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length)) refuse(where, argument, length, "needs a direction");
  return v / length;
}

void check_options(const std::string& where, const Joint& joint) {
  const JointOptions& options = joint.options;
  if (joint.a == joint.b) refuse(where, "b", "the body that a is too", "a joint needs two bodies");
  if (!options.point.allFinite()) refuse(where, "point", "not finite", "needs finite entries [m]");
  if (!options.point_b.allFinite()) refuse(where, "point_b", "not finite", "needs finite entries [m]");
  if (!(options.friction >= 0) || !std::isfinite(options.friction))
    refuse(where, "friction", options.friction, "needs to be >= 0 and finite [N m or N]");
  if (options.friction > 0 && !one_freedom(joint.kind))
    refuse(where, "friction", options.friction,
           "needs a joint with one degree of freedom; of several coordinates frictions has each");
  for (const double friction : options.frictions)
    if (!(friction >= 0) || !std::isfinite(friction))
      refuse(where, "frictions", friction, "needs to be >= 0 and finite [N m or N]");
  if (options.friction > 0 && !options.frictions.empty())
    refuse(where, "frictions", "given", "needs friction or frictions, not both");
  if (joint.kind == JointKind::Screw && (!std::isfinite(options.lead) || options.lead == 0))
    refuse(where, "lead", options.lead, "a screw needs its advance per angle [m/rad]");
  if (joint.kind == JointKind::Gear && (!std::isfinite(options.ratio) || options.ratio == 0))
    refuse(where, "ratio", options.ratio, "a gear needs the turns of b per turn of a");
}

void check_planar(const std::string& where, JointKind kind, const Vector3& axis, const Vector3& axis_b) {
  const auto turns = [](const Vector3& d) { return std::abs(d.z()) > 1 - 1e-12; };
  switch (kind) {
    case JointKind::Revolute:
      if (!turns(axis)) refuse(where, "axis", "not the z axis", "a planar revolute joint turns about z");
      return;
    case JointKind::Prismatic:
      if (std::abs(axis.z()) > 1e-12)
        refuse(where, "axis", "not in the xy plane", "a planar prismatic joint slides in the xy plane");
      return;
    case JointKind::Gear:
      if (!turns(axis) || !turns(axis_b))
        refuse(where, "axis", "not the z axis", "gears of planar bodies turn about z");
      return;
    case JointKind::Cylindrical:
    case JointKind::Universal:
    case JointKind::Planar:
    case JointKind::Screw:
      refuse(where, "kind", "of spatial bodies",
             "planar bodies can have fixed, ball, revolute, prismatic, rod, gear");
    default:
      return;
  }
}

/// Of the angles that differ by whole turns, that nearest to `near`.
double unwrapped(double angle, double near) {
  return near + std::remainder(angle - near, 2 * std::numbers::pi);
}

/// Angle within half a turn of zero, and its gradient g in world axes.
struct TurnValue {
  double angle;
  Vector3 gradient;
};

TurnValue value(const JointTurn& turn, const Quaternion& of_axis, const Quaternion& of_hand) {
  const Vector3 axis = of_axis * turn.axis, zero = of_axis * turn.zero, hand = of_hand * turn.hand;
  const Vector3 s = hand - axis * axis.dot(hand);
  return {std::atan2(axis.dot(zero.cross(s)), zero.dot(s)), axis - s * (hand.dot(axis) / s.squaredNorm())};
}

}  // namespace

double JointMotion::acceleration_at(double t) const {
  if (acceleration) return acceleration(t);
  return time_slope<1>([this](double s) { return Eigen::Matrix<double, 1, 1>(rate(s)); }, t)[0];
}

JointGeometry joint_geometry(const Joint& joint, const Pose& X_WA, const Pose& X_WB, bool planar) {
  const JointOptions& options = joint.options;
  const std::string where = "joint '" + options.name + "'";
  check_options(where, joint);
  const Matrix3 frame = contact_frame(direction(where, "axis", options.axis));  // axis, t, o in world axes
  const Vector3 axis = frame.col(0), t = frame.col(1), o = frame.col(2);
  const bool two_axes = joint.kind == JointKind::Universal || joint.kind == JointKind::Gear;
  const Vector3 axis_b = two_axes && !options.axis_b.isZero(0) ? direction(where, "axis_b", options.axis_b)
                         : joint.kind == JointKind::Universal  ? t
                                                               : axis;
  if (planar) check_planar(where, joint.kind, axis, axis_b);

  const auto in_a = [&](const Vector3& d) -> Vector3 { return X_WA.q.conjugate() * d; };
  const auto in_b = [&](const Vector3& d) -> Vector3 { return X_WB.q.conjugate() * d; };
  JointGeometry g;
  g.kind = joint.kind;
  g.name = options.name;
  g.a = joint.a;
  g.b = joint.b;
  g.asked = options;
  g.anchor_a = X_WA.inverse() * options.point;
  g.anchor_b = X_WB.inverse() * (joint.kind == JointKind::Rod ? options.point_b : options.point);

  // in the plane only motions along x, y and about z exist
  const auto point = [&](const Vector3& d) {
    if (!planar || std::abs(d.z()) < 0.5) g.rows.push_back({.kind = Kind::Point, .in_a = in_a(d)});
  };
  const auto perpendicular = [&](const Vector3& u, const Vector3& w) {
    if (!planar || std::abs(u.cross(w).z()) > 0.5)
      g.rows.push_back({.kind = Kind::Perpendicular, .in_a = in_a(u), .in_b = in_b(w)});
  };
  const Forbidden no = forbidden(joint.kind);
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

  const auto slide = [&](std::string_view name, const Vector3& d) {
    g.coordinates.push_back({name, JointFreedom::Translation, {.kind = Kind::Point, .in_a = in_a(d)}});
  };
  const JointTurn turn{in_a(axis), in_a(t), in_b(t)};
  const auto angle = [&](std::string_view name) {
    g.coordinates.push_back({name, JointFreedom::Rotation, {.kind = Kind::Angle, .turn = turn}});
  };
  switch (joint.kind) {
    case JointKind::Revolute:
      angle("angle");
      break;
    case JointKind::Prismatic:
      slide("slide", axis);
      break;
    case JointKind::Cylindrical:
      angle("angle");
      slide("slide", axis);
      break;
    case JointKind::Planar:
      slide("x", t);
      slide("y", o);
      angle("angle");
      break;
    case JointKind::Universal: {
      if (std::abs(axis.dot(axis_b)) > 1e-9)
        refuse(where, "axis_b", "not across axis", "the two axes of a universal joint are perpendicular");
      perpendicular(axis, axis_b);
      g.coordinates.push_back({"angle_a",
                               JointFreedom::Rotation,
                               {.kind = Kind::Angle, .turn = {in_a(axis), in_a(axis_b), in_b(axis_b)}}});
      g.coordinates.push_back({"angle_b",
                               JointFreedom::Rotation,
                               {.kind = Kind::AngleBack, .turn = {in_b(axis_b), in_b(axis), in_a(axis)}}});
      break;
    }
    case JointKind::Screw:
      g.rows.push_back({.kind = Kind::Screw, .in_a = in_a(axis), .number = options.lead, .turn = turn});
      angle("angle");
      break;
    case JointKind::Rod: {
      const double length = (options.point_b - options.point).norm();
      if (!(length > 0)) refuse(where, "point_b", "where point is", "a rod needs a length");
      g.rows.push_back({.kind = Kind::Distance, .number = length});
      break;
    }
    case JointKind::Gear: {
      const Vector3 t_b = contact_frame(axis_b).col(1);
      g.rows.push_back({.kind = Kind::Gear,
                        .number = options.ratio,
                        .turn = {axis, t, in_a(t)},
                        .turn_b = {axis_b, t_b, in_b(t_b)}});
      break;
    }
    default:
      break;
  }
  g.motions.resize(g.coordinates.size());
  g.frictions = options.frictions;
  if (options.friction > 0) g.frictions = {options.friction};
  if (!g.frictions.empty() && g.frictions.size() != g.coordinates.size())
    refuse(where, "frictions", static_cast<double>(g.frictions.size()),
           "numbers: needs one for each of its " + std::to_string(g.coordinates.size()) + " coordinates");
  return g;
}

JointRowValue evaluate(const JointRow& row, const JointGeometry& joint, const Pose& X_WA, const Pose& X_WB,
                       const double (&near)[2]) {
  JointRowValue v;
  const auto apart = [&]() -> Vector3 { return X_WB * joint.anchor_b - X_WA * joint.anchor_a; };
  switch (row.kind) {
    case Kind::Point:
      v.linear = X_WA.q * row.in_a;
      v.psi = v.linear.dot(apart());
      break;
    case Kind::Perpendicular: {
      const Vector3 u = X_WA.q * row.in_a, w = X_WB.q * row.in_b;
      v.psi = u.dot(w);
      v.angular_a = v.angular_b = w.cross(u);
      break;
    }
    case Kind::Distance: {
      const Vector3 d = apart();
      const double length = d.norm();
      v.psi = length - row.number;
      v.linear = d / length;
      break;
    }
    case Kind::Angle: {
      const TurnValue turn = value(row.turn, X_WA.q, X_WB.q);
      v.psi = v.angles[0] = unwrapped(turn.angle, near[0]);
      v.angular_a = v.angular_b = turn.gradient;
      break;
    }
    case Kind::AngleBack: {
      const TurnValue turn = value(row.turn, X_WB.q, X_WA.q);
      v.psi = v.angles[0] = unwrapped(-turn.angle, near[0]);
      v.angular_a = v.angular_b = turn.gradient;
      break;
    }
    case Kind::Screw: {
      const TurnValue turn = value(row.turn, X_WA.q, X_WB.q);
      v.linear = X_WA.q * row.in_a;
      const double slide = v.linear.dot(apart());
      v.angles[0] = unwrapped(turn.angle, slide / row.number);
      v.psi = slide - row.number * v.angles[0];
      v.angular_a = v.angular_b = -row.number * turn.gradient;
      break;
    }
    case Kind::Gear: {
      const TurnValue a = value(row.turn, Quaternion::Identity(), X_WA.q),
                      b = value(row.turn_b, Quaternion::Identity(), X_WB.q);
      v.angles[0] = unwrapped(a.angle, near[0]);
      v.angles[1] = unwrapped(b.angle, near[1]);
      v.psi = v.angles[1] - row.number * v.angles[0];
      v.angular_a = row.number * a.gradient;
      v.angular_b = b.gradient;
      break;
    }
  }
  return v;
}

namespace {

using Columns = JointRowDerivative::Columns;

/// Of JointTurn's gradient g = axis - s k/m, k = hand . axis, m = |s|^2 = 1 - k^2. First columns of the turning of axis and of
/// hand; none (-1) of what stands still.
Columns turning(const JointTurn& turn, const Quaternion& of_axis, const Quaternion& of_hand, int axis_column,
                int hand_column) {
  const Vector3 axis = of_axis * turn.axis, hand = of_hand * turn.hand;
  Columns d_axis = Columns::Zero(), d_hand = Columns::Zero();
  if (axis_column >= 0) d_axis.middleCols<3>(axis_column) = -skew(axis);
  d_hand.middleCols<3>(hand_column) = -skew(hand);
  const double k = hand.dot(axis);
  const Vector3 s = hand - k * axis;
  const double m = s.squaredNorm();
  const Eigen::Matrix<double, 1, 12> dk = axis.transpose() * d_hand + hand.transpose() * d_axis;
  const Columns ds = d_hand - k * d_axis - axis * dk;
  const Eigen::Matrix<double, 1, 12> dm = 2 * s.transpose() * ds;
  return d_axis - (k / m) * ds - s * (dk / m - (k / (m * m)) * dm);
}

}  // namespace

JointRowDerivative differentiate(const JointRow& row, const JointGeometry& joint, const Pose& X_WA,
                                 const Pose& X_WB) {
  constexpr int w_A = 3, w_B = 9;  // columns of turning
  JointRowDerivative d;
  switch (row.kind) {
    case Kind::Point:
      d.linear.middleCols<3>(w_A) = -skew(X_WA.q * row.in_a);
      break;
    case Kind::Perpendicular: {  // d(w x u) = (w_B x w) x u + w x (w_A x u)
      const Vector3 u = X_WA.q * row.in_a, w = X_WB.q * row.in_b;
      d.angular_a.middleCols<3>(w_A) = -skew(w) * skew(u);
      d.angular_a.middleCols<3>(w_B) = skew(u) * skew(w);
      d.angular_b = d.angular_a;
      break;
    }
    case Kind::Distance: {  // of e = (c_B - c_A)/length
      const Vector3 r_A = X_WA.q * joint.anchor_a, r_B = X_WB.q * joint.anchor_b;
      const Vector3 apart = X_WB.p + r_B - X_WA.p - r_A;
      const double length = apart.norm();
      const Vector3 e = apart / length;
      Columns moved;
      moved << -Matrix3::Identity(), skew(r_A), Matrix3::Identity(), -skew(r_B);
      d.linear = (Matrix3::Identity() - e * e.transpose()) / length * moved;
      break;
    }
    case Kind::Angle:
      d.angular_a = d.angular_b = turning(row.turn, X_WA.q, X_WB.q, w_A, w_B);
      break;
    case Kind::AngleBack:
      d.angular_a = d.angular_b = turning(row.turn, X_WB.q, X_WA.q, w_B, w_A);
      break;
    case Kind::Screw:
      d.linear.middleCols<3>(w_A) = -skew(X_WA.q * row.in_a);
      d.angular_a = d.angular_b = -row.number * turning(row.turn, X_WA.q, X_WB.q, w_A, w_B);
      break;
    case Kind::Gear:
      d.angular_a = row.number * turning(row.turn, Quaternion::Identity(), X_WA.q, -1, w_A);
      d.angular_b = turning(row.turn_b, Quaternion::Identity(), X_WB.q, -1, w_B);
      break;
  }
  return d;
}

}  // namespace perp
