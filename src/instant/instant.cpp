#include "perp/instant/instant.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>

#include "instant/load_fault.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// A force and moment (or the velocities conjugate to them) in a body's own velocity coordinates.
Vector6 coordinates(const Body& body, const Matrix3& R, const Vector3& linear, const Vector3& angular) {
  Vector6 f = Vector6::Zero();
  switch (body.kind) {
    case BodyKind::Spatial:
      f << linear, R.transpose() * angular;
      break;
    case BodyKind::Planar:
      f.head<3>() << linear.x(), linear.y(), angular.z();
      break;
    case BodyKind::Particle:
      f.head<3>() = linear;
      break;
    default:
      break;
  }
  return f;
}

void add(const Body& body, const Matrix3& R, const Wrench& wrench, Vector& k) {
  k.segment(body.v0, body.nv) += coordinates(body, R, wrench.force, wrench.moment).head(body.nv);
}

/// Force F on the point x of a body whose centre of mass is p.
Wrench acting_at(const Vector3& force, const Vector3& x, const Vector3& p) {
  return {force, (x - p).cross(force)};
}

void evaluate_generalized(const Body& body, int index, const State& x, Instant& s) {
  const Vector q = x.q.segment(body.q0, body.nq), nu = x.nu.segment(body.v0, body.nv);
  Instant::GeneralizedMass& mass = s.masses.emplace_back();
  mass.body = index;
  mass.M = body.system.mass(q);
  const Vector force = body.system.force(q, nu, x.t);
  const Eigen::LLT<Matrix> llt(mass.M);
  if (mass.M.rows() != body.nv || mass.M.cols() != body.nv || force.size() != body.nv ||
      llt.info() != Eigen::Success) {
    s.fault = "mass or force of '" + body.name +
              "' does not fit, or its mass is not positive definite, at t = " + shortest(x.t);
    mass.M = mass.inverse = Matrix::Identity(body.nv, body.nv);
    return;
  }
  mass.inverse = llt.solve(Matrix::Identity(body.nv, body.nv));
  s.k.segment(body.v0, body.nv) += force;
}

/// A gap of a generalized body's own: it gives its columns itself. False if there is no such point now.
bool evaluate_own(const Model& model, const State& x, const Contact& contact, Instant& s, ContactInstant& c) {
  const Body& body = model.body(contact.b);
  const GeneralizedPoint p = contact.own(x.q.segment(body.q0, body.nq), x.t);
  if (p.gap == infinity) return false;
  const bool slides = contact.tangents > 0;
  const auto fits = [&](const Vector& column) { return column.size() == body.nv && column.allFinite(); };
  if (!std::isfinite(p.gap) || !fits(p.normal) || (slides && !fits(p.tangent))) {
    s.fault = "gap, normal or tangent of contact '" + contact.name +
              "' does not fit or is not finite at t = " + shortest(x.t);
    return false;
  }
  c.psi_n = p.gap;
  c.tangents = contact.tangents;
  c.mu = contact.mu;
  c.bias = {p.gap_t, p.tangent_t, 0};
  c.W.connect(model, contact.a, contact.b);
  c.W.B.col(0).head(body.nv) = p.normal;
  if (slides) c.W.B.col(1).head(body.nv) = p.tangent;
  return true;
}

void evaluate_bodies(const Model& model, const State& x, Instant& s) {
  const std::size_t n = model.bodies().size();
  s.X.resize(n);
  s.R.resize(n);
  s.V.resize(n);
  s.k.setZero(model.nv());
  const bool loads = !model.forces().empty() || !model.springs().empty() || !model.joint_springs().empty();
  s.k_load.setZero(loads ? model.nv() : 0);
  s.k_motor.setZero(model.motors().empty() ? 0 : model.nv());
  s.masses.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Body& body = model.bodies()[i];
    const BodyId id{static_cast<int>(i)};
    s.X[i] = model.pose(x, id);
    s.R[i] = s.X[i].R();
    s.V[i] = model.twist(x, id);
    if (body.nv == 0) continue;
    if (body.kind == BodyKind::Generalized) {
      evaluate_generalized(body, static_cast<int>(i), x, s);
      continue;
    }
    s.k.segment(body.v0, std::min(body.nv, body.kind == BodyKind::Planar ? 2 : 3)) +=
        body.mass * model.gravity().head(body.kind == BodyKind::Planar ? 2 : 3);
    if (body.kind == BodyKind::Spatial) {  // -w x J w, body axes
      const Vector3 w = x.nu.segment<3>(body.v0 + 3);
      s.k.segment<3>(body.v0 + 3) -= w.cross(body.J * w);
    }
  }
}

void add_loads(const Model& model, const State& x, Instant& s) {
  const auto index = [](BodyId b) { return static_cast<std::size_t>(b.index); };
  for (const Spring& spring : model.springs()) {
    const std::size_t a = index(spring.a), b = index(spring.b);
    const Vector3 x_a = s.X[a] * spring.point_a, x_b = s.X[b] * spring.point_b;
    const Vector3 d = x_b - x_a;
    const double l = d.norm();
    Vector3 force = -spring.stiffness * d;  // on B, of an unstretched length of 0
    if (l > 0) {
      const Vector3 e = d / l;
      const double rate = e.dot(s.V[b].at(x_b - s.X[b].p) - s.V[a].at(x_a - s.X[a].p));
      force += (spring.stiffness * spring.length - spring.damping * rate) * e;
      if (spring.damping > 0) {
        const Vector3 damping = -spring.damping * rate * e;
        add(model.body(spring.a), s.R[a], acting_at(-damping, x_a, s.X[a].p), s.k_load);
        add(model.body(spring.b), s.R[b], acting_at(damping, x_b, s.X[b].p), s.k_load);
      }
    }
    add(model.body(spring.a), s.R[a], acting_at(-force, x_a, s.X[a].p), s.k);
    add(model.body(spring.b), s.R[b], acting_at(force, x_b, s.X[b].p), s.k);
  }
  for (const BodyForce& load : model.forces()) {
    const Wrench wrench = load.wrench(model, x);
    add(model.body(load.body), s.R[index(load.body)], wrench, s.k_load);
    add(model.body(load.body), s.R[index(load.body)], wrench, s.k);
  }
}

/// A row of a joint, with what it is to each of the two bodies.
JointRowInstant joint_row(const Model& model, const State& x, const Instant& s, int index,
                          const JointRow& from) {
  const JointGeometry& joint = model.joints()[static_cast<std::size_t>(index)];
  const auto a = static_cast<std::size_t>(joint.a.index), b = static_cast<std::size_t>(joint.b.index);
  JointRowInstant row;
  row.joint = index;
  row.world = model.evaluate(x, joint, from, s.X[a], s.X[b]);
  row.psi_b = row.world.psi;
  row.point = s.X[b] * joint.anchor_b;
  row.W.connect(model, joint.a, joint.b);
  const auto side = [&](std::size_t i, double sign, const Vector3& angular, WrenchMap<1>::Block& block) {
    const Body& body = model.bodies()[i];
    const Vector3 moment = (row.point - s.X[i].p).cross(row.world.linear) + angular;
    if (body.nv > 0) block = sign * coordinates(body, s.R[i], row.world.linear, moment);
    if (body.kind == BodyKind::Prescribed)
      row.psi_b_t += sign * (row.world.linear.dot(s.V[i].v) + moment.dot(s.V[i].w));
  };
  side(a, -1, row.world.angular_a, row.W.A);
  side(b, +1, row.world.angular_b, row.W.B);
  return row;
}

void evaluate_joints(const Model& model, const State& x, Instant& s) {
  s.joint_rows.clear();
  s.joint_frictions.clear();
  s.joint_coordinates.clear();
  s.first_coordinate.clear();
  for (int i = 0; i < static_cast<int>(model.joints().size()); ++i) {
    const JointGeometry& joint = model.joint({i});
    for (int k = 0; k < static_cast<int>(joint.rows.size()); ++k) {
      s.joint_rows.push_back(joint_row(model, x, s, i, joint.rows[static_cast<std::size_t>(k)]));
      s.joint_rows.back().row = k;
    }
    s.first_coordinate.push_back(static_cast<int>(s.joint_coordinates.size()));
    for (int k = 0; k < static_cast<int>(joint.coordinates.size()); ++k) {
      JointRowInstant row = joint_row(model, x, s, i, joint.coordinates[static_cast<std::size_t>(k)].row);
      row.coordinate = k;
      s.joint_coordinates.push_back(row);
      if (!joint.frictions.empty() && joint.frictions[static_cast<std::size_t>(k)] > 0) {
        row.friction = joint.frictions[static_cast<std::size_t>(k)];
        s.joint_frictions.push_back(row);
      }
      if (const auto& motion = joint.motions[static_cast<std::size_t>(k)]) {
        row.psi_b -= motion->position(x.t);
        row.psi_b_t -= motion->rate(x.t);
        row.prescribed = true;
        s.joint_rows.push_back(row);
      }
    }
  }
}

/// Moments and forces along joint coordinates.
void evaluate_joint_loads(const Model& model, const State& x, Instant& s) {
  for (const JointSpring& spring : model.joint_springs()) {
    const JointRowInstant& c = s.coordinate(spring.joint, spring.coordinate);
    const double damping = -spring.damping * c.velocity(x.nu);
    const double effort = -spring.stiffness * (c.psi_b - spring.rest) + damping;
    c.W.add_impulse(WrenchMap<1>::Columns(effort), s.k);
    c.W.add_impulse(WrenchMap<1>::Columns(damping), s.k_load);
  }
  for (const JointMotor& motor : model.motors()) {
    const JointRowInstant& c = s.coordinate(motor.joint, motor.coordinate);
    const WrenchMap<1>::Columns effort(motor.effort(model, x, c.psi_b, c.velocity(x.nu)));
    c.W.add_impulse(effort, s.k);
    c.W.add_impulse(effort, s.k_motor);
  }
}

/// A joint's stop, as a contact along its coordinate: a force or a moment along the row's own direction.
void evaluate_stop(const Contact& contact, Instant& s, ContactInstant& c) {
  const Contact::Stop& stop = contact.stop;
  const JointRowInstant& row = s.coordinate({stop.joint}, stop.coordinate);
  c.psi_n = stop.side * (row.psi_b - stop.limit);
  c.position = row.point;
  const bool slides = row.world.angular_b.isZero(0);
  c.frame = contact_frame((stop.side * (slides ? row.world.linear : row.world.angular_b)).normalized());
  c.bias = {stop.side * row.psi_b_t, 0, 0};
  c.W.a = row.W.a, c.W.va = row.W.va, c.W.na = row.W.na;
  c.W.b = row.W.b, c.W.vb = row.W.vb, c.W.nb = row.W.nb;
  c.W.A.col(0) = stop.side * row.W.A;
  c.W.B.col(0) = stop.side * row.W.B;
}

/// The directions' columns of one body's block, and the explicit velocity that a prescribed body adds.
void fill_body(const Body& body, const Pose& X, const Matrix3& R, const Twist& V, double sign, double t,
               ContactInstant& c, WrenchMap<3>::Block& block) {
  const Vector3 r = c.position - X.p;
  if (body.nv > 0) {
    for (int j = 0; j <= c.tangents; ++j)
      block.col(j) = sign * coordinates(body, R, c.frame.col(j), r.cross(c.frame.col(j)));
  } else if (body.kind == BodyKind::Prescribed) {
    c.bias += sign * (c.frame.transpose() * V.at(r));
    if (body.motion.surface)
      c.bias.tail<2>() += sign * (c.frame.transpose() * body.motion.surface(t, c.position)).tail<2>();
  }
}

/// The moments' columns about the contact's axes.
void evaluate_moments(const Model& model, const ContactView& contact, Instant& s, ContactInstant& c) {
  c.moments = static_cast<int>(s.moments.size());
  MomentInstant& m = s.moments.emplace_back();
  m.mu_o = contact.law.friction_axes ? contact.law.friction_axes->mu.y() : contact.law.mu;
  m.torsion = contact.law.torsion;
  m.rolling = contact.law.rolling;
  m.W.connect(model, contact.a, contact.b);
  const auto fill = [&](BodyId id, double sign, WrenchMap<3>::Block& block) {
    const auto i = static_cast<std::size_t>(id.index);
    const Body& body = model.body(id);
    for (int j = 0; j < 3; ++j) {
      const bool used = j == 0 ? m.torsion > 0 : m.rolling > 0 && (j == 2 || c.tangents == 2);
      if (!used) continue;
      if (body.nv > 0) block.col(j) = sign * coordinates(body, s.R[i], Vector3::Zero(), c.frame.col(j));
      if (body.kind == BodyKind::Prescribed) m.bias[j] += sign * c.frame.col(j).dot(s.V[i].w);
    }
  };
  fill(contact.a, -1, m.W.A);
  fill(contact.b, +1, m.W.B);
}

bool finite(const ContactPoint& p) {
  return std::isfinite(p.gap) && p.normal.allFinite() && p.point.allFinite() && std::isfinite(p.gap_t);
}

/// What is there of contact `number` but its points: false if it has none of its own to look for.
bool evaluate_without_points(const Model& model, const State& x, const ContactView& contact, int number,
                             Instant& s) {
  if (contact.law.stop.joint < 0 && !contact.law.own) return false;
  ContactInstant c;
  c.contact = number;
  c.point = contact.first_point;
  c.e = contact.law.e;
  if (contact.law.own && !evaluate_own(model, x, contact.law, s, c)) return true;
  if (!contact.law.own) evaluate_stop(contact.law, s, c);
  s.contact_of_point.set(c.point, static_cast<int>(s.contacts.size()));
  s.contacts.push_back(c);
  return true;
}

void add_point(const Model& model, const State& x, const ContactView& contact, const ContactPoint& p,
               const Instant* like, ContactInstant& c, Instant& s) {
  const auto a = static_cast<std::size_t>(contact.a.index), b = static_cast<std::size_t>(contact.b.index);
  c.point = contact.first_point + c.slot;
  s.contact_of_point.set(c.point, static_cast<int>(s.contacts.size()) - 1);
  c.psi_n = p.gap;
  c.position = p.point;
  c.tangents = contact.law.tangents;
  c.wish = contact.law.tangent;
  if (c.tangents == 1) c.wish = p.normal.cross(Vector3::UnitZ());  // the plane's one direction
  if (const std::optional<FrictionAxes>& axes = contact.law.friction_axes)
    c.wish = s.R[axes->of == FrictionAxes::Of::A ? a : b] * axes->t;
  else if (c.tangents == 2 && like != nullptr)
    if (const int before = like->contact_of_point[static_cast<std::size_t>(c.point)]; before >= 0)
      c.wish = like->contacts[static_cast<std::size_t>(before)].frame.col(1);
  c.wish = tangent_wish(p.normal, c.wish);
  c.frame = contact_frame(p.normal, c.wish);
  c.mu = contact.law.mu;
  c.e = contact.law.e;
  c.bias = {p.gap_t, 0, 0};
  c.W.connect(model, contact.a, contact.b);
  fill_body(model.bodies()[a], s.X[a], s.R[a], s.V[a], -1, x.t, c, c.W.A);
  fill_body(model.bodies()[b], s.X[b], s.R[b], s.V[b], +1, x.t, c, c.W.B);
  if (contact.law.has_ellipse()) evaluate_moments(model, contact, s, c);
}

void evaluate_contact(const Model& model, const State& x, int number, const Instant* like, Instant& s) {
  const ContactView contact = model.contact(number);
  if (!s.fault.empty() || evaluate_without_points(model, x, contact, number, s)) return;
  const auto count = static_cast<std::size_t>(contact.gap.points());
  if (s.points.size() < count) s.points.resize(count);
  const std::span<ContactPoint> points(s.points.data(), count);
  contact.gap(s.X[static_cast<std::size_t>(contact.a.index)], s.X[static_cast<std::size_t>(contact.b.index)],
              x.t, points);
  for (std::size_t j = 0; j < count; ++j) {
    const ContactPoint& p = points[j];
    if (p.gap == infinity) continue;
    if (!finite(p)) {
      s.fault = (std::isfinite(p.gap) ? "normal, point or gap_t of contact '" : "gap of contact '") +
                model.contact_name(number) + "' is not finite at t = " + shortest(x.t);
      return;
    }
    ContactInstant& c = s.contacts.emplace_back();
    c.contact = number;
    c.slot = static_cast<int>(j);
    add_point(model, x, contact, p, like, c, s);
  }
}

void evaluate_contacts(const Model& model, const State& x, Instant& s, const Instant* like,
                       const std::vector<int>* only) {
  s.contact_of_point.reset(model.contact_points());
  s.contacts.clear();
  s.moments.clear();
  if (only == nullptr)
    model.each_contact([&](int number) { evaluate_contact(model, x, number, like, s); });
  else
    for (const int number : *only) evaluate_contact(model, x, number, like, s);
}

}  // namespace

void evaluate_loads(const Model& model, const State& x, Instant& instant) {
  instant.t = x.t;
  instant.nu = x.nu;
  evaluate_bodies(model, x, instant);
  add_loads(model, x, instant);
  if (model.joint_springs().empty() && model.motors().empty()) return;
  evaluate_joints(model, x, instant);
  evaluate_joint_loads(model, x, instant);
}

void evaluate(const Model& model, const State& x, Instant& instant, const Instant* like,
              const std::vector<int>* only) {
  instant.fault.clear();
  evaluate_loads(model, x, instant);
  if (model.joint_springs().empty() && model.motors().empty()) evaluate_joints(model, x, instant);
  evaluate_contacts(model, x, instant, like, only);
  for (const auto* rows : {&instant.joint_rows, &instant.joint_coordinates})
    for (const JointRowInstant& row : *rows)
      if (instant.fault.empty() && !(std::isfinite(row.psi_b) && std::isfinite(row.psi_b_t) &&
                                     row.W.A.allFinite() && row.W.B.allFinite()))
        instant.fault =
            "a row of joint '" + model.joint({row.joint}).name + "' is not finite at t = " + shortest(x.t);
  if (instant.fault.empty() && !instant.k.allFinite())
    instant.fault = load_fault(model, x, instant) + " is not finite at t = " + shortest(x.t);
}

double Instant::gap_min() const {
  double least = infinity;
  for (const ContactInstant& c : contacts) least = std::min(least, c.psi_n);
  return least;
}

double Instant::joint_error() const {
  double largest = 0;
  for (const JointRowInstant& row : joint_rows) largest = std::max(largest, std::abs(row.psi_b));
  return largest;
}

namespace {

void solve_constant_mass(const Body& body, const double* f, double* out) {
  using Map3 = Eigen::Map<const Vector3>;
  const double per_mass = 1 / body.mass;
  const int linear = body.kind == BodyKind::Planar ? 2 : 3;
  for (int i = 0; i < linear; ++i) out[i] = per_mass * f[i];
  if (body.kind == BodyKind::Planar) out[2] = body.J_inverse(2, 2) * f[2];
  if (body.kind == BodyKind::Spatial) Eigen::Map<Vector3>(out + 3).noalias() = body.J_inverse * Map3(f + 3);
}

}  // namespace

void solve_mass(const Model& model, const Instant& instant, int body, const double* f, double* out) {
  const Body& b = model.bodies()[static_cast<std::size_t>(body)];
  if (b.kind != BodyKind::Generalized) return solve_constant_mass(b, f, out);
  for (const Instant::GeneralizedMass& mass : instant.masses)
    if (mass.body == body) Eigen::Map<Vector>(out, b.nv) = mass.inverse * Eigen::Map<const Vector>(f, b.nv);
}

void solve_mass(const Model& model, const Instant& instant, const Vector& f, Vector& out) {
  out.resize(f.size());
  for (const Body& b : model.bodies())
    if (b.nv > 0 && b.kind != BodyKind::Generalized)
      solve_constant_mass(b, f.data() + b.v0, out.data() + b.v0);
  for (const Instant::GeneralizedMass& mass : instant.masses) {
    const Body& b = model.bodies()[static_cast<std::size_t>(mass.body)];
    out.segment(b.v0, b.nv) = mass.inverse * f.segment(b.v0, b.nv);
  }
}

void multiply_mass(const Model& model, const Instant& instant, const Vector& nu, Vector& out) {
  out = nu;
  for (const Body& b : model.bodies()) {
    if (b.nv == 0 || b.kind == BodyKind::Generalized) continue;
    out.segment(b.v0, b.kind == BodyKind::Planar ? 2 : 3) *= b.mass;
    if (b.kind == BodyKind::Planar) out[b.v0 + 2] *= b.J(2, 2);
    if (b.kind == BodyKind::Spatial) out.segment<3>(b.v0 + 3) = b.J * Vector3(nu.segment<3>(b.v0 + 3));
  }
  for (const Instant::GeneralizedMass& mass : instant.masses) {
    const Body& b = model.bodies()[static_cast<std::size_t>(mass.body)];
    out.segment(b.v0, b.nv) = mass.M * nu.segment(b.v0, b.nv);
  }
}

}  // namespace perp
