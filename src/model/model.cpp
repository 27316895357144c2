#include "perp/model/model.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

std::uint64_t next_revision() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

bool moves(BodyKind kind) { return kind != BodyKind::Ground && kind != BodyKind::Prescribed; }
bool in_plane(BodyKind kind) { return kind == BodyKind::Planar || !moves(kind); }

void need_finite(std::string_view where, std::string_view argument, const Vector3& v) {
  for (const double x : v)
    if (!std::isfinite(x)) refuse(where, argument, x, "needs finite entries");
}

void need_index(std::string_view where, std::string_view argument, int index, std::size_t size) {
  if (index < 0 || static_cast<std::size_t>(index) >= size)
    refuse(where, argument, index, "is not of this model");
}

/// Friction axes need a body that they are fixed to and a plane to lie in; mu becomes that along t.
void take_axes(const std::string& where, Contact& contact, BodyKind a, BodyKind b) {
  const FrictionAxes& axes = *contact.friction_axes;
  for (const double mu : axes.mu)
    if (!(mu >= 0) || !std::isfinite(mu))
      refuse(where, "friction_axes.mu", mu, "needs two coefficients >= 0 and finite");
  if (contact.mu != 0)
    refuse(where, "mu", contact.mu, "needs to be left out where friction_axes has its own");
  need_finite(where, "friction_axes.t", axes.t);
  if (axes.t.isZero(0)) refuse(where, "friction_axes.t", "zero", "needs a direction");
  if (!contact.tangent.isZero(0))
    refuse(where, "tangent", "given", "needs to be left out where friction_axes has its own direction");
  const BodyKind own = axes.of == FrictionAxes::Of::A ? a : b;
  if (own == BodyKind::Particle || contact.own)
    refuse(where, "friction_axes.of", "a body without an orientation", "needs a body that has one");
  if (in_plane(a) && in_plane(b) && (a == BodyKind::Planar || b == BodyKind::Planar))
    refuse(where, "friction_axes", "given",
           "needs spatial bodies: in the plane there is one direction of slip");
  contact.mu = axes.mu.x();
}

/// Moments of friction act between bodies that can turn against each other about their axes.
void need_orientations(const std::string& where, const Contact& contact, BodyKind a, BodyKind b) {
  const char* key = contact.torsion > 0 ? "torsion" : "rolling";
  const double value = contact.torsion > 0 ? contact.torsion : contact.rolling;
  if (a == BodyKind::Particle || b == BodyKind::Particle)
    refuse(where, key, value, "needs bodies that turn, and a particle has no orientation");
  if (contact.own) refuse(where, key, value, "needs bodies with a pose, which a generalized body has not");
  if (contact.torsion > 0 && in_plane(a) && in_plane(b))
    refuse(where, "torsion", contact.torsion, "is about the normal, about which planar bodies do not turn");
}

using Names = std::vector<std::string>;

/// A list that a report or a copy of the model may be reading: that one stays as it is.
template <class List>
List& own(std::shared_ptr<List>& names) {
  if (names.use_count() > 1) names = std::make_shared<List>(*names);
  return *names;
}

void add_name(std::shared_ptr<Names>& names, std::string name) { own(names).push_back(std::move(name)); }

}  // namespace

Model::Model() : point_names_(std::make_shared<PointNames>()), joint_names_(std::make_shared<Names>()) {
  bodies_.push_back({.name = "ground"});
  revision_ = next_revision();
}

void Model::changed() { revision_ = next_revision(); }

BodyId Model::add(Body body, BodyOptions options, const char* where) {
  need_finite(where, "pose.p", options.pose.p);
  const double norm = options.pose.q.norm();
  if (!(norm > 0) || !std::isfinite(norm))
    refuse(where, "pose.q", norm, "needs a quaternion of finite length");
  options.pose.q = unit(options.pose.q);
  body.name = options.name.empty() ? "body " + std::to_string(bodies_.size()) : std::move(options.name);
  for (const Body& other : bodies_)
    if (other.name == body.name) refuse(where, "name", body.name, "is taken already");
  body.rest = options.pose;
  body.q0 = nq_;
  body.v0 = nv_;
  nq_ += body.nq;
  nv_ += body.nv;
  bodies_.push_back(std::move(body));
  changed();
  return {static_cast<int>(bodies_.size()) - 1};
}

BodyId Model::add_body(const Inertia& inertia, BodyOptions options) {
  return add({.kind = BodyKind::Spatial,
              .mass = inertia.mass(),
              .J = inertia.tensor(),
              .J_inverse = inertia.tensor().inverse(),
              .nq = 7,
              .nv = 6},
             std::move(options), "add_body");
}

BodyId Model::add_planar_body(double mass, double J, BodyOptions options) {
  if (!(mass > 0) || !std::isfinite(mass))
    refuse("add_planar_body", "mass", mass, "needs to be positive [kg]");
  if (!(J > 0) || !std::isfinite(J)) refuse("add_planar_body", "J", J, "needs to be positive [kg m^2]");
  const Quaternion& q = options.pose.q;
  if (options.pose.p.z() != 0 || q.x() != 0 || q.y() != 0)
    refuse("add_planar_body", "pose", "out of the plane", "a planar body lies at z = 0 and turns about z");
  Body body{.kind = BodyKind::Planar, .mass = mass, .nq = 3, .nv = 3};
  body.J(2, 2) = J;
  body.J_inverse(2, 2) = 1 / J;
  return add(std::move(body), std::move(options), "add_planar_body");
}

BodyId Model::add_particle(double mass, BodyOptions options) {
  if (!(mass > 0) || !std::isfinite(mass)) refuse("add_particle", "mass", mass, "needs to be positive [kg]");
  return add({.kind = BodyKind::Particle, .mass = mass, .nq = 3, .nv = 3}, std::move(options),
             "add_particle");
}

BodyId Model::add_prescribed(PrescribedMotion motion, BodyOptions options) {
  if (!motion.pose || !motion.twist)
    refuse("add_prescribed", "motion", "without pose or twist", "needs both as functions of time");
  options.pose = motion.pose(0);
  return add({.kind = BodyKind::Prescribed, .motion = std::move(motion)}, std::move(options),
             "add_prescribed");
}

BodyId Model::add_generalized(int n, GeneralizedSystem system, std::string name) {
  if (n < 1 || n > 6) refuse("add_generalized", "n", n, "needs 1 to 6 coordinates");
  if (!system.mass || !system.force)
    refuse("add_generalized", "system", "without mass or force", "needs both as functions");
  Body body{.kind = BodyKind::Generalized, .nq = n, .nv = n};
  body.system = std::move(system);
  return add(std::move(body), {.name = std::move(name)}, "add_generalized");
}

ContactId Model::add_contact(BodyId id, GeneralizedGap gap, ContactOptions options) {
  need_index("add_contact", "generalized", id.index, bodies_.size());
  if (body(id).kind != BodyKind::Generalized)
    refuse("add_contact", "generalized", body(id).name, "needs to be a generalized body");
  if (!gap) refuse("add_contact", "gap", "empty", "needs a function");
  const Gap none([](const Pose&, const Pose&, double) { return ContactPoint{}; });
  return add_contact(ground, id, none, std::move(gap), std::move(options));
}

ContactId Model::add_contact(BodyId a, BodyId b, Gap gap, ContactOptions options) {
  return add_contact(a, b, std::move(gap), {}, std::move(options));
}

ContactId Model::add_contact(BodyId a, BodyId b, Gap gap, GeneralizedGap own, ContactOptions options) {
  need_index("add_contact", "a", a.index, bodies_.size());
  need_index("add_contact", "b", b.index, bodies_.size());
  Contact contact{.name = std::move(options.name),
                  .a = a,
                  .b = b,
                  .gap = std::move(gap),
                  .mu = options.mu,
                  .torsion = options.torsion,
                  .rolling = options.rolling,
                  .e = options.e,
                  .compliance = options.compliance,
                  .friction_axes = options.friction_axes,
                  .tangent = options.tangent,
                  .first_point = points_};
  contact.own = std::move(own);
  if (contact.name.empty()) contact.name = "contact " + std::to_string(contacts_.size() + 1);
  const std::string where = "contact '" + contact.name + "'";
  if (a == b) refuse(where, "b", body(b).name, "a contact needs two different bodies");
  const BodyKind kind_a = body(a).kind, kind_b = body(b).kind;
  if (!contact.own && (kind_a == BodyKind::Generalized || kind_b == BodyKind::Generalized))
    refuse(where, "a or b", "a generalized body", "its gaps are functions of its coordinates");
  if (!moves(kind_a) && !moves(kind_b))
    refuse(where, "a and b", "immovable", "one of them needs to be able to move");
  if (!(contact.mu >= 0) || !std::isfinite(contact.mu))
    refuse(where, "mu", contact.mu, "needs to be >= 0 and finite");
  if (!(contact.torsion >= 0) || !std::isfinite(contact.torsion))
    refuse(where, "torsion", contact.torsion, "needs to be >= 0 and finite [m]");
  if (!(contact.rolling >= 0) || !std::isfinite(contact.rolling))
    refuse(where, "rolling", contact.rolling, "needs to be >= 0 and finite [m]");
  if (contact.friction_axes) take_axes(where, contact, kind_a, kind_b);
  if (contact.has_moments()) need_orientations(where, contact, kind_a, kind_b);
  if (!(contact.e >= 0 && contact.e <= 1)) refuse(where, "e", contact.e, "needs to be in [0, 1]");
  if (!(contact.compliance > 0) || !std::isfinite(contact.compliance))
    refuse(where, "compliance", contact.compliance, "needs to be > 0 and finite");
  need_finite(where, "tangent", contact.tangent);
  if (!contact_names_.insert(contact.name).second)
    refuse("add_contact", "name", contact.name, "is taken already");

  const bool rubs = contact.mu > 0 || contact.has_ellipse();  // moments are about the axes that friction has
  contact.tangents = !rubs ? 0 : in_plane(kind_a) && in_plane(kind_b) ? 1 : 2;
  if (contact.own) contact.tangents = contact.mu == 0 ? 0 : 1;
  add(std::move(contact));
  return {static_cast<int>(contacts_.size()) - 1};
}

void Model::add(Contact contact) {
  points_ += contact.gap.points();
  for (int i = 0; i < contact.gap.points(); ++i)
    own(point_names_)
        .listed_.push_back(contact.gap.points() == 1 ? contact.name : contact.name + "." + std::to_string(i));
  if (contact.has_ellipse() && with_moments_ < 0) with_moments_ = static_cast<int>(contacts_.size());
  contacts_.push_back(std::move(contact));
  changed();
}

JointId Model::add_joint(const Joint& joint) {
  need_index("add_joint", "a", joint.a.index, bodies_.size());
  need_index("add_joint", "b", joint.b.index, bodies_.size());
  const Body &a = body(joint.a), &b = body(joint.b);
  Joint named = joint;
  if (named.options.name.empty()) named.options.name = "joint " + std::to_string(joints_.size() + 1);
  const std::string where = "joint '" + named.options.name + "'";
  if (!moves(a.kind) && !moves(b.kind))
    refuse(where, "a and b", "immovable", "one of them needs to be able to move");
  if ((a.kind == BodyKind::Particle || b.kind == BodyKind::Particle) && joint.kind != JointKind::Ball &&
      joint.kind != JointKind::Rod)
    refuse(where, "a or b", "a particle", "a particle has no orientation: only a ball joint or a rod fits");
  if (a.kind == BodyKind::Generalized || b.kind == BodyKind::Generalized)
    refuse(where, "a or b", "a generalized body", "has no pose to joint");
  for (const JointGeometry& other : joints_)
    if (other.name == named.options.name) refuse("add_joint", "name", other.name, "is taken already");
  JointGeometry g = joint_geometry(named, a.rest, b.rest, in_plane(a.kind) && in_plane(b.kind));

  // the coordinates of planar bodies count turns, and a screw's slide does
  const auto counts = [](BodyKind kind) { return kind == BodyKind::Planar || kind == BodyKind::Ground; };
  const auto give_windings = [&](JointRow& row) {
    using Kind = JointRow::Kind;
    const int angles = row.kind == Kind::Angle || row.kind == Kind::AngleBack ? 1
                       : row.kind == Kind::Gear                               ? 2
                                                                              : 0;
    if (angles == 0 || (counts(a.kind) && counts(b.kind))) return;
    row.winding = windings_;
    windings_ += angles;
  };
  for (JointRow& row : g.rows) give_windings(row);
  for (JointCoordinate& c : g.coordinates) give_windings(c.row);
  if (g.coordinates.size() < 2)
    add_name(joint_names_, g.name);
  else
    for (const JointCoordinate& c : g.coordinates) add_name(joint_names_, g.name + "." + std::string(c.name));
  joints_.push_back(std::move(g));
  joined_.emplace(std::min(joint.a.index, joint.b.index), std::max(joint.a.index, joint.b.index));
  apart_changed();
  return {static_cast<int>(joints_.size()) - 1};
}

const JointCoordinate& Model::need_coordinate(std::string_view where, JointId id, int coordinate) const {
  need_index(where, "joint", id.index, joints_.size());
  if (coordinate < 0 || static_cast<std::size_t>(coordinate) >= joint(id).coordinates.size())
    refuse(where, "coordinate", coordinate,
           "joint '" + joint(id).name + "' has " + std::to_string(joint(id).coordinates.size()));
  return joint(id).coordinates[static_cast<std::size_t>(coordinate)];
}

void Model::add_limit(JointId id, const JointLimit& limit) {
  const JointCoordinate& coordinate = need_coordinate("add_limit", id, limit.coordinate);
  if (!(limit.lower <= limit.upper)) refuse("add_limit", "lower", limit.lower, "needs to be <= upper");
  if (!(limit.lower < infinity)) refuse("add_limit", "lower", limit.lower, "needs to be less than infinite");
  if (!(limit.upper > -infinity))
    refuse("add_limit", "upper", limit.upper, "needs to be more than -infinite");
  if (!(limit.e >= 0 && limit.e <= 1)) refuse("add_limit", "e", limit.e, "needs to be in [0, 1]");
  const JointGeometry& j = joint(id);
  const std::string name = j.coordinates.size() == 1 ? j.name : j.name + "." + std::string(coordinate.name);
  const std::string names[] = {name + ".lower", name + ".upper"};
  for (const std::string& stop : names)
    if (contact_names_.contains(stop)) refuse("add_limit", "name", stop, "is taken already");
  const Gap none([](const Pose&, const Pose&, double) { return ContactPoint{}; });
  for (const double side : {1.0, -1.0}) {
    const double at = side > 0 ? limit.lower : limit.upper;
    if (!std::isfinite(at)) continue;
    const std::string& stop = names[side > 0 ? 0 : 1];
    contact_names_.insert(stop);
    add(Contact{.name = stop,
                .a = j.a,
                .b = j.b,
                .gap = none,
                .e = limit.e,
                .tangent = Vector3::Zero(),
                .first_point = points_,
                .tangents = 0,
                .stop = {id.index, limit.coordinate, side, at}});
  }
}

void Model::add_motion(JointId id, JointMotion motion, int coordinate) {
  need_coordinate("add_motion", id, coordinate);
  if (!motion.position || !motion.rate)
    refuse("add_motion", "motion", "without position or rate", "needs both as functions of time");
  JointGeometry& j = joints_[static_cast<std::size_t>(id.index)];
  if (!j.frictions.empty() && j.frictions[static_cast<std::size_t>(coordinate)] > 0)
    refuse("add_motion", "joint", j.name, "has friction, which a prescribed motion leaves nothing to decide");
  std::optional<JointMotion>& place = j.motions[static_cast<std::size_t>(coordinate)];
  if (place) refuse("add_motion", "coordinate", coordinate, "is moved already");
  place = std::move(motion);
  changed();
}

void Model::add_motor(JointMotor motor) {
  need_coordinate("add_motor", motor.joint, motor.coordinate);
  if (!motor.effort) refuse("add_motor", "effort", "empty", "needs a function");
  motors_.push_back(std::move(motor));
  changed();
}

void Model::add_joint_spring(const JointSpring& spring) {
  need_coordinate("add_joint_spring", spring.joint, spring.coordinate);
  const auto need = [](const char* argument, double value) {
    if (!(value >= 0) || !std::isfinite(value))
      refuse("add_joint_spring", argument, value, "needs to be >= 0 and finite");
  };
  need("stiffness", spring.stiffness);
  need("damping", spring.damping);
  if (!std::isfinite(spring.rest)) refuse("add_joint_spring", "rest", spring.rest, "needs to be finite");
  joint_springs_.push_back(spring);
  changed();
}

void Model::add_spring(const Spring& spring) {
  need_index("add_spring", "a", spring.a.index, bodies_.size());
  need_index("add_spring", "b", spring.b.index, bodies_.size());
  const auto need = [](const char* argument, double value) {
    if (!(value >= 0) || !std::isfinite(value))
      refuse("add_spring", argument, value, "needs to be >= 0 and finite");
  };
  for (const BodyId id : {spring.a, spring.b})
    if (body(id).kind == BodyKind::Generalized)
      refuse("add_spring", "a or b", body(id).name, "a generalized body has forces of its own");
  need("stiffness", spring.stiffness);
  need("damping", spring.damping);
  need("length", spring.length);
  need_finite("add_spring", "point_a", spring.point_a);
  need_finite("add_spring", "point_b", spring.point_b);
  springs_.push_back(spring);
  changed();
}

void Model::add_force(BodyId body, std::function<Wrench(const Model&, const State&)> wrench, Recipe recipe) {
  need_index("add_force", "body", body.index, bodies_.size());
  if (!wrench) refuse("add_force", "wrench", "empty", "needs a function");
  if (this->body(body).kind == BodyKind::Generalized)
    refuse("add_force", "body", this->body(body).name, "a generalized body has forces of its own");
  forces_.push_back({body, std::move(wrench), std::move(recipe)});
  changed();
}

void Model::set_gravity(const Vector3& g) {
  need_finite("set_gravity", "g", g);
  gravity_ = g;
  changed();
}

namespace {

template <class Things>
int find(const Things& things, std::string_view name, const char* where) {
  const auto it =
      std::find_if(things.begin(), things.end(), [&](const auto& thing) { return thing.name == name; });
  if (it == things.end()) {
    std::string known;
    for (const auto& thing : things) known += (known.empty() ? "" : ", ") + thing.name;
    refuse(where, "name", name, "needs to be one of: " + known);
  }
  return static_cast<int>(it - things.begin());
}

}  // namespace

BodyId Model::find_body(std::string_view name) const { return {find(bodies_, name, "find_body")}; }
ContactId Model::find_contact(std::string_view name) const { return {find(contacts_, name, "find_contact")}; }
JointId Model::find_joint(std::string_view name) const { return {find(joints_, name, "find_joint")}; }

}  // namespace perp
