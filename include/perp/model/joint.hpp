// Permanent joints: which relative motions of two bodies they forbid, and dry friction along the one they leave.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "perp/model/body.hpp"

namespace perp {

/// Handle of a joint in the Model that made it.
struct JointId {
  int index = 0;
  friend bool operator==(JointId, JointId) = default;
};

struct JointOptions {
  Vector3 point = Vector3::Zero();  ///< a point of the joint in world axes, bodies at rest() [m]
  Vector3 axis = Vector3::UnitZ();  ///< its axis in world axes, bodies at rest(); made a unit vector
  double friction = 0;              ///< c_max of (16): dry friction of constant bound [N m] or [N]; 0: none
  std::string name = {};            ///< "joint N" if empty
};

enum class JointKind { Fixed, Ball, Revolute, Prismatic };

/// A joint as the user asks for it; Model::add_joint turns it into constraint rows.
struct Joint {
  JointKind kind = JointKind::Fixed;
  BodyId a, b;
  JointOptions options;
};

/// a and b in this order: coordinates, rates and friction are of b relative to a; zero in Model::rest().
[[nodiscard]] Joint fixed(BodyId a, BodyId b, JointOptions options = {});  ///< no relative motion
[[nodiscard]] Joint ball(BodyId a, BodyId b, JointOptions options = {});   ///< turns about `point`
[[nodiscard]] Joint revolute(BodyId a, BodyId b,
                             JointOptions options = {});  ///< turns about `axis` through `point`
[[nodiscard]] Joint prismatic(BodyId a, BodyId b, JointOptions options = {});  ///< slides along `axis`

/// One scalar equation psi_b = 0 of a joint. Every joint is made of two kinds (u, d fixed in A; w fixed in B):
///   Point:         psi_b = d . (c_B - c_A)   the anchor of B does not leave that of A along d          [m]
///   Perpendicular: psi_b = u . w             two directions stay perpendicular                         [rad]
struct JointRow {
  enum class Kind { Point, Perpendicular } kind = Kind::Point;
  Vector3 in_a;  ///< d or u, unit, A's axes
  Vector3 in_b;  ///< w, unit, B's axes; unused by Point
};

/// The motion that a one-degree-of-freedom joint leaves, along which friction acts.
enum class JointFreedom { None, Rotation, Translation };

/// A joint in the model's terms: anchors, axis and rows in the axes of its two bodies.
struct JointGeometry {
  JointKind kind = JointKind::Fixed;
  std::string name;
  BodyId a, b;
  Vector3 point, axis;         ///< as asked for: world axes, bodies at rest()
  Vector3 anchor_a, anchor_b;  ///< c_A in A's axes, c_B in B's axes [m]
  Vector3 axis_a;              ///< unit, A's axes
  Vector3 side_a, side_b;  ///< unit, across the axis, parallel at rest: the angle is measured between them
  JointFreedom freedom = JointFreedom::None;
  double friction = 0;         ///< c_max [N m] or [N]
  std::vector<JointRow> rows;  ///< linearly independent on their own
};

/// The rows of `joint` between bodies that stand at X_WA and X_WB. With `planar` both bodies stay in the xy plane, and rows
/// that they cannot violate are left out: a planar revolute joint has 2 rows, not 5.
/// Throws std::invalid_argument for a = b, an axis without direction, friction that is negative, not finite, or in a
/// joint without exactly one freedom; with `planar`, for an axis that leaves no motion in the plane.
[[nodiscard]] JointGeometry joint_geometry(const Joint& joint, const Pose& X_WA, const Pose& X_WB,
                                           bool planar);

}  // namespace perp
