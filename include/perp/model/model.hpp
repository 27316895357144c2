// The system: bodies, joints, contacts, loads. Physics only; no step size, no number of polygon edges.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "perp/model/body.hpp"
#include "perp/model/body_shapes.hpp"
#include "perp/model/force.hpp"
#include "perp/model/gap.hpp"
#include "perp/model/gap_ref.hpp"
#include "perp/model/inertia.hpp"
#include "perp/model/joint.hpp"
#include "perp/model/point_names.hpp"
#include "perp/model/state.hpp"

namespace perp {

struct BodyOptions {
  Pose pose = {};         ///< in Model::rest(); joints are defined at these poses
  std::string name = {};  ///< "body N" if empty; unique; letters, digits, '_', '-' in files
};

/// Handle of a contact (all its points) in the Model that made it.
struct ContactId {
  int index = 0;
  friend bool operator==(ContactId, ContactId) = default;
};

/// Friction that depends on where it slides: |(p_t/mu_t, p_o/mu_o)| <= p_n, t and o = n x t fixed to one of the two bodies.
struct FrictionAxes {
  Vector2 mu = Vector2::Zero();  ///< mu_t, mu_o [-]
  enum class Of { A, B } of = Of::A;
  Vector3 t = Vector3::UnitX();  ///< in that body's axes; t of the contact frame is its part across n
};

struct ContactOptions {
  double mu = 0;  ///< Coulomb friction: |p_f| <= mu p_n, the circular cone (12); 0: none
  double torsion =
      0;  ///< gamma of |p_f|^2/mu^2 + tau^2/gamma^2 <= p_n^2, tau the moment along n [m]; 0: none
  double rolling = 0;                              ///< |m| <= rolling p_n, m the moment across n [m]; 0: none
  std::optional<FrictionAxes> friction_axes = {};  ///< in place of mu and tangent
  double e = 0;                                    ///< Newton's restitution, in [0, 1]
  std::string name = {};                           ///< "contact N" if empty; unique
  Vector3 tangent =
      Vector3::Zero();    ///< wish for t of the contact frame, world axes; zero: contact_frame's choice
  double compliance = 1;  ///< how much each point gives beside others, where reactions are redundant [-]; > 0
};

/// Bodies a and b that may touch where `gap` says.
struct Contact {
  std::string name;
  BodyId a, b;
  Gap gap;
  double mu = 0, torsion = 0, rolling = 0, e = 0, compliance = 1;
  std::optional<FrictionAxes> friction_axes = {};  ///< mu is then its first
  Vector3 tangent;
  int first_point = 0;  ///< of its points among all points of the model
  int tangents = 2;     ///< directions of friction: 2 in space, 1 in the plane, 0 without friction
  /// Of a joint's stop: gap = side (coordinate - limit), side = 1 below and -1 above; `gap` then has no point.
  struct Stop {
    int joint = -1;  ///< in Model::joints(); -1: no stop, `gap` counts
    int coordinate = 0;
    double side = 1, limit = 0;
  } stop = {};
  GeneralizedGap own = {};  ///< of a generalized body b with the ground: counts in place of `gap`

  bool has_moments() const { return torsion > 0 || rolling > 0; }
  /// Whether friction is more than the circular cone: moments, or axes.
  bool has_ellipse() const { return has_moments() || friction_axes; }
};

/// A contact by its number: a listed one, or that of two shapes.
struct ContactView {
  const Contact&
      law;  ///< friction, restitution, ...: of a listed one all that it is, of shapes what their materials decide
  BodyId a, b;
  GapRef gap;
  int first_point;
};

struct Momentum {
  Vector3 linear = Vector3::Zero();   ///< [kg m/s]
  Vector3 angular = Vector3::Zero();  ///< about the world's origin [kg m^2/s]
};

/// A value type that is built once and then only read: one const Model may serve many threads, each with a Stepper of its
/// own. Every add_* throws std::invalid_argument naming the argument that it cannot take, and then adds nothing.
class Model {
 public:
  Model();

  BodyId add_body(const Inertia& inertia, BodyOptions options = {});  ///< spatial, 6 velocities
  BodyId add_planar_body(double mass, double J,
                         BodyOptions options = {});            ///< kg, kg m^2 about z; in the xy plane
  BodyId add_particle(double mass, BodyOptions options = {});  ///< 3 velocities
  BodyId add_prescribed(PrescribedMotion motion, BodyOptions options = {});  ///< no unknowns

  /// `n` coordinates, 1 to 6; q and nu start at zero.
  BodyId add_generalized(int n, GeneralizedSystem system, std::string name = {});

  /// Spatial or planar as the shape is, mass and inertia by its density; the body's origin is the shape's.
  BodyId add_body(const Shape& shape, ShapeBodyOptions options);
  /// Gives a body (the ground too) a shape. Shapes on different bodies, one of which moves, touch wherever they meet, unless a joint joins
  /// these or no_contact names them: their contact is called BODY.SHAPE|BODY.SHAPE, the body of lower number in front, its points that and
  /// |NUMBER of the feature (nothing where there is one). A pair that perp has no gap for is refused. Costs nothing for each pair.
  ShapeId add_shape(BodyId body, const Shape& shape, ShapeOptions options = {});
  /// Friction and restitution of shapes of two materials on each other, in either order; without it they have neither.
  void set_friction(const std::string& material_a, const std::string& material_b, const MaterialPair& pair);
  void no_contact(BodyId a, BodyId b);
  void no_contact(ShapeId a, ShapeId b);
  /// Likewise for the pairs of shapes that overlap at x, and only these; returns their contacts' names.
  std::vector<std::string> leave_out_overlapping(const State& x);

  ContactId add_contact(BodyId a, BodyId b, Gap gap, ContactOptions options = {});
  ContactId add_contact(BodyId generalized, GeneralizedGap gap, ContactOptions options = {});
  JointId add_joint(const Joint& joint);
  void add_limit(JointId joint, const JointLimit& limit);
  void add_motion(JointId joint, JointMotion motion,
                  int coordinate = 0);  ///< one a coordinate; not where friction is
  void add_motor(JointMotor motor);
  void add_joint_spring(const JointSpring& spring);
  void add_spring(const Spring& spring);
  void add_force(BodyId body, std::function<Wrench(const Model&, const State&)> wrench, Recipe recipe = {});
  void set_gravity(const Vector3& g);  ///< [m/s^2], world axes; (0, 0, -9.81) by default

  const std::vector<Body>& bodies() const { return bodies_; }         ///< [0] is the ground
  const std::vector<Contact>& contacts() const { return contacts_; }  ///< those that were added
  /// Numbers of contacts: those added, in their order, then pairs of shapes, those of later shapes later; some of these may never touch.
  int contact_count() const { return static_cast<int>(contacts_.size()) + pairs_.pairs(); }
  ContactView contact(int number) const;
  std::string contact_name(int number) const;
  /// Whether shapes i and j may touch, and the number of their contact.
  bool may_touch(ShapeId i, ShapeId j) const;
  int contact_of(ShapeId i, ShapeId j) const {
    return static_cast<int>(contacts_.size()) +
           PairNumbers::pair(std::min(i.index, j.index), std::max(i.index, j.index));
  }
  /// take(number) of every contact that may touch, ascending: without many shapes, which are better asked where they are (BroadPhase).
  template <class Take>
  void each_contact(Take take) const {
    for (int i = 0; i < static_cast<int>(contacts_.size()); ++i) take(i);
    if (few_pairs()) {
      for (const int pair : touching_pairs_) take(static_cast<int>(contacts_.size()) + pair);
      return;
    }
    for (int j = 0; j < pairs_.shapes(); ++j)
      for (int i = 0; i < j; ++i)
        if (may_touch({i}, {j})) take(contact_of({i}, {j}));
  }
  /// take(number) of every point of these.
  template <class Take>
  void each_point(Take take) const {
    each_contact([&](int i) {
      const ContactView c = contact(i);
      for (int k = 0; k < c.gap.points(); ++k) take(c.first_point + k);
    });
  }
  int contact_of_point(int point) const;
  /// How many contacts these are; of many shapes at most so many.
  std::size_t touching_contacts() const {
    return few_pairs() ? contacts_.size() + touching_pairs_.size()
                       : static_cast<std::size_t>(contact_count());
  }
  const std::vector<BodyShape>& shapes() const { return shapes_; }
  const std::map<std::pair<std::string, std::string>, MaterialPair>& materials() const { return materials_; }
  const std::set<std::pair<int, int>>& bodies_apart() const { return bodies_apart_; }  ///< by no_contact
  const std::set<std::pair<int, int>>& shapes_apart() const { return shapes_apart_; }  ///< likewise
  const std::vector<JointGeometry>& joints() const { return joints_; }
  const std::vector<Spring>& springs() const { return springs_; }
  const std::vector<BodyForce>& forces() const { return forces_; }
  const std::vector<JointSpring>& joint_springs() const { return joint_springs_; }
  const std::vector<JointMotor>& motors() const { return motors_; }
  const Vector3& gravity() const { return gravity_; }
  const Body& body(BodyId b) const { return bodies_[static_cast<std::size_t>(b.index)]; }
  const JointGeometry& joint(JointId j) const { return joints_[static_cast<std::size_t>(j.index)]; }
  int nq() const { return nq_; }
  int nv() const { return nv_; }
  int contact_points() const { return points_ + pairs_.points(); }  ///< numbers of points of all contacts
  /// The first contact, or law of two materials, that has_ellipse(); null if there is none.
  const Contact* contact_with_moments() const {
    if (with_moments_ >= 0) return &contacts_[static_cast<std::size_t>(with_moments_)];
    return law_with_moments_ < 0 ? nullptr : &laws_[static_cast<std::size_t>(law_with_moments_)];
  }
  int windings() const { return windings_; }  ///< size of State::winding

  BodyId find_body(std::string_view name) const;        ///< throws std::invalid_argument if there is none
  ContactId find_contact(std::string_view name) const;  ///< likewise
  JointId find_joint(std::string_view name) const;      ///< likewise
  ShapeId find_shape(BodyId body, std::string_view name) const;  ///< likewise

  /// All bodies at their BodyOptions::pose, at rest, t = 0.
  State rest() const;

  // Parts of a state, all in world axes; setters throw std::invalid_argument for a value that is not finite, and for a body
  // that has no such coordinate (the ground, a particle's orientation, a planar body's height).
  void set_position(State& x, BodyId b, const Vector3& p) const;
  void set_orientation(State& x, BodyId b, const Quaternion& q) const;  ///< normalised; planar: about z
  void set_velocity(State& x, BodyId b, const Vector3& v, const Vector3& w = Vector3::Zero()) const;
  void set_coordinates(State& x, BodyId generalized, const Vector& q, const Vector& nu) const;
  Pose pose(const State& x, BodyId b) const;    ///< X_WB; of a generalized body the ground's
  Twist twist(const State& x, BodyId b) const;  ///< of X_WB
  Vector3 position(const State& x, BodyId b) const { return pose(x, b).p; }
  Vector3 velocity(const State& x, BodyId b) const { return twist(x, b).v; }
  Vector3 angular_velocity(const State& x, BodyId b) const { return twist(x, b).w; }
  double angle(const State& x, BodyId planar) const;  ///< a planar body's, not wrapped [rad]

  /// A row of a joint at x: its equations and coordinates are JointGeometry's.
  JointRowValue evaluate(const State& x, const JointGeometry& joint, const JointRow& row) const;
  /// The same where the bodies' poses at x are known.
  JointRowValue evaluate(const State& x, const JointGeometry& joint, const JointRow& row, const Pose& X_WA,
                         const Pose& X_WB) const;
  double coordinate(const State& x, JointId joint, int i = 0) const;       ///< [rad, m], zero in rest()
  double coordinate_rate(const State& x, JointId joint, int i = 0) const;  ///< [rad/s, m/s]
  /// Brings x.winding up to where the angles of joints are now. Whoever moves a state by less than half a turn at a time and
  /// calls this after each move has angles that count turns; Stepper::step does.
  void follow_turns(State& x) const;

  /// Kinetic energy, and potential energy of gravity and springs (zero at the origin and unstretched) [J].
  double energy(const State& x) const;
  double kinetic_energy(const State& x) const;
  Momentum momentum(const State& x) const;

  /// Throws std::invalid_argument naming `where` unless x has this model's sizes and finite entries.
  void check(std::string_view where, const State& x) const;

  /// A number that differs between any two models that were not copied from each other unchanged.
  std::uint64_t revision() const { return revision_; }
  std::shared_ptr<const PointNames> point_names() const { return point_names_; }
  /// Names of all joints' coordinates: the joint's own, or JOINT.COORDINATE where it has several; its own also if it has none.
  std::shared_ptr<const std::vector<std::string>> joint_names() const { return joint_names_; }

 private:
  BodyId add(Body body, BodyOptions options, const char* where);
  ContactId add_contact(BodyId a, BodyId b, Gap gap, GeneralizedGap own, ContactOptions options);
  void add(Contact contact);
  int most_points(const BodyShape& with) const;
  void make_laws();
  void apart_changed();
  static constexpr int many_shapes = 90;  // whose pairs are not listed one by one: 4,005
  bool few_pairs() const { return pairs_.shapes() <= many_shapes; }
  const JointCoordinate& need_coordinate(std::string_view where, JointId joint, int coordinate) const;
  void changed();

  std::vector<Body> bodies_;
  std::vector<Contact> contacts_;
  std::vector<BodyShape> shapes_;
  std::map<std::pair<std::string, std::string>, MaterialPair> materials_;  // names ascending
  std::set<std::pair<int, int>> joined_, bodies_apart_, shapes_apart_;     // ascending
  std::vector<std::string> material_names_;                                // of shapes, each once
  std::vector<Contact> laws_;        // of materials i on j: planar, spatial; at 2 (i n + j) of n
  std::vector<int> kinds_of_shape_;  // the first shape of each kind that pairs tell from others
  std::vector<int> touching_pairs_;  // of few_pairs(), ascending
  PairNumbers pairs_;
  std::vector<JointGeometry> joints_;
  std::vector<Spring> springs_;
  std::vector<BodyForce> forces_;
  std::vector<JointSpring> joint_springs_;
  std::vector<JointMotor> motors_;
  Vector3 gravity_{0, 0, -9.81};
  int nq_ = 0, nv_ = 0, points_ = 0, windings_ = 0, with_moments_ = -1, law_with_moments_ = -1;
  std::uint64_t revision_ = 0;
  std::unordered_set<std::string> contact_names_;
  std::shared_ptr<PointNames> point_names_;
  std::shared_ptr<std::vector<std::string>> joint_names_;
};

/// q ⊕ h nu: the configuration after moving at the constant velocity nu for the time h. Positions move by h v, orientations
/// by the exponential map of h w, which is the seed's (26) with the quaternion kept at unit length (erratum 17).
void move(const Model& model, const Vector& nu, double h, Vector& q);

}  // namespace perp
