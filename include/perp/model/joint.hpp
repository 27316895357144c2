// Permanent joints: which relative motions of two bodies they forbid, which they leave, and dry friction along these.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "perp/model/body.hpp"

namespace perp {

/// Handle of a joint in the Model that made it.
struct JointId {
  int index = 0;
  friend bool operator==(JointId, JointId) = default;
};

struct JointOptions {
  Vector3 point =
      Vector3::Zero();  ///< a point of the joint in world axes, bodies at rest() [m]; of a rod its end on a
  Vector3 axis = Vector3::UnitZ();  ///< its axis in world axes, bodies at rest(); made a unit vector
  Vector3 axis_b = Vector3::
      Zero();  ///< universal: the axis fixed in b, across `axis`; gear: of b; zero: perp's choice, `axis`
  Vector3 point_b = Vector3::Zero();  ///< rod: its end on b, as `point` [m]
  double lead = not_set;              ///< screw: advance along the axis per angle [m/rad]
  double ratio = not_set;  ///< gear: turns of b per turn of a; negative where they turn against each other
  /// c_max of (16): dry friction of constant bound [N m] or [N], of joints with one freedom; of a ball joint |tau| <= c_max; 0: none.
  double friction = 0;
  /// Of joints with several coordinates, c_max of each in their order, [N m] of angles and [N] of slides; empty: none.
  std::vector<double> frictions = {};
  std::string name = {};  ///< "joint N" if empty
};

/// kind         freedoms  coordinates (of b relative to a)       what it leaves
/// Fixed        0         none                                   nothing: a weld
/// Ball         3         none                                   turning about `point`
/// Revolute     1         angle                                  turning about `axis` through `point`
/// Prismatic    1         slide                                  sliding along `axis`
/// Cylindrical  2         angle, slide                           both
/// Universal    2         angle_a about `axis`, angle_b about `axis_b`     turning about two crossed axes
/// Planar       3         x, y, angle                            sliding in the plane across `axis`, turning about it
/// Screw        1         angle                                  turning about `axis` with slide = lead angle
/// Rod          5         none                                   all but the distance of `point` on a and `point_b` on b
/// Gear         5         none                                   all but angle of b = ratio (angle of a), each about its own
///                                                               axis and relative to the world
enum class JointKind { Fixed, Ball, Revolute, Prismatic, Cylindrical, Universal, Planar, Screw, Rod, Gear };

/// A joint as the user asks for it; Model::add_joint turns it into constraint rows.
struct Joint {
  JointKind kind = JointKind::Fixed;
  BodyId a, b;
  JointOptions options;
};

/// a and b in this order: coordinates, rates and friction are of b relative to a; zero in Model::rest().
[[nodiscard]] Joint fixed(BodyId a, BodyId b, JointOptions options = {});
[[nodiscard]] Joint ball(BodyId a, BodyId b, JointOptions options = {});
[[nodiscard]] Joint revolute(BodyId a, BodyId b, JointOptions options = {});
[[nodiscard]] Joint prismatic(BodyId a, BodyId b, JointOptions options = {});
[[nodiscard]] Joint cylindrical(BodyId a, BodyId b, JointOptions options = {});
[[nodiscard]] Joint universal(BodyId a, BodyId b, JointOptions options = {});
[[nodiscard]] Joint planar(BodyId a, BodyId b, JointOptions options = {});
[[nodiscard]] Joint screw(BodyId a, BodyId b, JointOptions options = {});  ///< needs `lead`
[[nodiscard]] Joint rod(BodyId a, BodyId b, JointOptions options = {});    ///< needs `point` and `point_b`
[[nodiscard]] Joint gear(BodyId a, BodyId b, JointOptions options = {});   ///< needs `ratio`

/// The angle by which `hand`, fixed in one frame, has turned from `zero` about `axis`, both fixed in another: unit vectors,
/// zero ⟂ axis. With s the part of `hand` across the axis,
///   angle = atan2(axis . (zero x s), zero . s),   angle' = g . (w of hand - w of axis),   g = axis - s (hand . axis)/|s|^2:
/// the rate along the axis where the hand is across it, and the exact derivative where it is not.
struct JointTurn {
  Vector3 axis = Vector3::UnitZ(), zero = Vector3::UnitX();
  Vector3 hand = Vector3::UnitX();
};

/// One scalar function psi of two bodies' poses: an equation of a joint, or one of its coordinates. With anchors c_A, c_B, and
/// angles as JointTurn has them, continuous (turn counts: State::winding):
///   Point          d . (c_B - c_A)                        d fixed in A                                     [m]
///   Perpendicular  u . w                                  u fixed in A, w in B                             [rad]
///   Distance       |c_B - c_A| - number                                                                    [m]
///   Angle          of B relative to A, hand in B          axis fixed in A                                  [rad]
///   AngleBack      the same, hand in A                    axis fixed in B; counted from A to B             [rad]
///   Screw          d . (c_B - c_A) - number angle         d the axis, fixed in A; angle that nearest to
///                                                         d . (c_B - c_A)/number                           [m]
///   Gear           angle of B - number (angle of A)       each relative to the world                       [rad]
struct JointRow {
  enum class Kind { Point, Perpendicular, Distance, Angle, AngleBack, Screw, Gear } kind = Kind::Point;
  Vector3 in_a = Vector3::Zero();    ///< d or u, unit, A's axes
  Vector3 in_b = Vector3::Zero();    ///< w, unit, B's axes
  double number = 0;                 ///< length [m], lead [m/rad] or ratio [-]
  JointTurn turn = {}, turn_b = {};  ///< of angles; of a gear those of A and of B
  int winding =
      -1;  ///< first of its entries in State::winding; -1: none, the angles of planar bodies count their turns
};

enum class JointFreedom { Rotation, Translation };

/// A relative motion that a joint leaves, measured: zero in Model::rest().
struct JointCoordinate {
  std::string_view name;  ///< "angle", "slide", ...
  JointFreedom freedom = JointFreedom::Rotation;
  JointRow row;
};

/// Stops of a coordinate, unilateral contacts of the names JOINT.lower and JOINT.upper (JOINT.COORDINATE.lower, ... where the
/// joint has several): gap = coordinate - lower and upper - coordinate [rad, m], without friction.
struct JointLimit {
  double lower = -infinity, upper = infinity;  ///< infinite: no such stop
  double e = 0;                                ///< Newton's restitution, in [0, 1]
  int coordinate = 0;                          ///< which of the joint's
};

/// A prescribed motion of a joint's coordinate: the rheonomic equation coordinate - position(t) = 0. They belong together.
struct JointMotion {
  std::function<double(double t)> position;      ///< [rad, m]
  std::function<double(double t)> rate;          ///< its derivative
  std::function<double(double t)> acceleration;  ///< and the next; empty: by differences of rate
  Recipe recipe = {};

  /// `acceleration`, or by differences of rate that are extrapolated.
  double acceleration_at(double t) const;
};

/// A joint in the model's terms: anchors, rows and coordinates in the axes of its two bodies.
struct JointGeometry {
  JointKind kind = JointKind::Fixed;
  std::string name;
  BodyId a, b;
  JointOptions asked;          ///< as asked for: world axes, bodies at rest()
  Vector3 anchor_a, anchor_b;  ///< c_A in A's axes, c_B in B's axes [m]
  std::vector<JointRow> rows;  ///< equations; linearly independent on their own
  std::vector<JointCoordinate> coordinates;
  std::vector<double> frictions;  ///< c_max along each coordinate [N m, N]; empty without
  std::vector<std::optional<JointMotion>>
      motions;  ///< of each coordinate: one more equation where there is one
};

/// The rows of `joint` between bodies that stand at X_WA and X_WB. With `planar` both bodies stay in the xy plane, and rows
/// that they cannot violate are left out: a planar revolute joint has 2 rows, not 5.
/// Throws std::invalid_argument for a = b, an axis without direction, friction that is negative, not finite, or in a
/// joint without exactly one freedom; a screw without lead, a gear without ratio, a rod without length; with `planar`, for an
/// axis that leaves no motion in the plane and for kinds that are spatial.
[[nodiscard]] JointGeometry joint_geometry(const Joint& joint, const Pose& X_WA, const Pose& X_WB,
                                           bool planar);

/// A JointRow at two poses:
///   psi' = linear . (velocity at c_B of B - that of A) + angular_b . w_B - angular_a . w_A,   all in world axes.
/// So an impulse p along it is the force p linear at c_B and the moment p angular_b on B, their opposite (with angular_a) on A.
struct JointRowValue {
  double psi = 0;
  Vector3 linear = Vector3::Zero(), angular_a = Vector3::Zero(), angular_b = Vector3::Zero();
  double angles[2] = {0, 0};  ///< those that enter it, continuous [rad]
};

/// `near`: where its angles were last: of those that differ by whole turns, the nearest to it.
[[nodiscard]] JointRowValue evaluate(const JointRow& row, const JointGeometry& joint, const Pose& X_WA,
                                     const Pose& X_WB, const double (&near)[2]);

/// How the directions of a JointRowValue turn: columns (v_A, w_A, v_B, w_B), velocities and turning of the two bodies in
/// world axes.
struct JointRowDerivative {
  using Columns = Eigen::Matrix<double, 3, 12>;
  Columns linear = Columns::Zero(), angular_a = Columns::Zero(), angular_b = Columns::Zero();
};
[[nodiscard]] JointRowDerivative differentiate(const JointRow& row, const JointGeometry& joint,
                                               const Pose& X_WA, const Pose& X_WB);

}  // namespace perp
