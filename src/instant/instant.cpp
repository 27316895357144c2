#include "perp/instant/instant.hpp"

#include <algorithm>
#include <cmath>

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
Wrench at(const Vector3& force, const Vector3& x, const Vector3& p) { return {force, (x - p).cross(force)}; }

void evaluate_bodies(const Model& model, const State& x, Instant& s) {
  const std::size_t n = model.bodies().size();
  s.X.resize(n);
  s.R.resize(n);
  s.V.resize(n);
  s.k.setZero(model.nv());
  for (std::size_t i = 0; i < n; ++i) {
    const Body& body = model.bodies()[i];
    const BodyId id{static_cast<int>(i)};
    s.X[i] = model.pose(x, id);
    s.R[i] = s.X[i].R();
    s.V[i] = model.twist(x, id);
    if (body.nv == 0) continue;
    s.k.segment(body.v0, std::min(body.nv, body.kind == BodyKind::Planar ? 2 : 3)) +=
        body.mass * model.gravity().head(body.kind == BodyKind::Planar ? 2 : 3);
    if (body.kind == BodyKind::Spatial) {  // -w x J w, body axes
      const Vector3 w = x.nu.segment<3>(body.v0 + 3);
      s.k.segment<3>(body.v0 + 3) -= w.cross(body.J * w);
    }
  }
}

void evaluate_loads(const Model& model, const State& x, Instant& s) {
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
    }
    add(model.body(spring.a), s.R[a], at(-force, x_a, s.X[a].p), s.k);
    add(model.body(spring.b), s.R[b], at(force, x_b, s.X[b].p), s.k);
  }
  for (const BodyForce& load : model.forces())
    add(model.body(load.body), s.R[index(load.body)], load.wrench(model, x), s.k);
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

bool finite(const ContactPoint& p) {
  return std::isfinite(p.gap) && p.normal.allFinite() && p.point.allFinite() && std::isfinite(p.gap_t);
}

void evaluate_contacts(const Model& model, const State& x, Instant& s, const Instant* like) {
  s.contacts.clear();
  s.contact_of_point.assign(static_cast<std::size_t>(model.contact_points()), -1);
  for (std::size_t i = 0; i < model.contacts().size(); ++i) {
    const Contact& contact = model.contacts()[i];
    const auto a = static_cast<std::size_t>(contact.a.index), b = static_cast<std::size_t>(contact.b.index);
    const auto count = static_cast<std::size_t>(contact.gap.points());
    if (s.points.size() < count) s.points.resize(count);
    const std::span<ContactPoint> points(s.points.data(), count);
    contact.gap(s.X[a], s.X[b], x.t, points);

    for (std::size_t j = 0; j < count; ++j) {
      const ContactPoint& p = points[j];
      if (p.gap == infinity) continue;
      if (!finite(p)) {
        s.fault = (std::isfinite(p.gap) ? "normal, point or gap_t of contact '" : "gap of contact '") +
                  contact.name + "' is not finite at t = " + shortest(x.t);
        return;
      }
      const Body &body_a = model.bodies()[a], &body_b = model.bodies()[b];
      ContactInstant& c = s.contacts.emplace_back();
      c.contact = static_cast<int>(i);
      c.point = contact.first_point + static_cast<int>(j);
      s.contact_of_point[static_cast<std::size_t>(c.point)] = static_cast<int>(s.contacts.size()) - 1;
      c.psi_n = p.gap;
      c.position = p.point;
      c.tangents = contact.tangents;
      c.wish = contact.tangent;
      if (contact.tangents == 1) c.wish = p.normal.cross(Vector3::UnitZ());  // the plane's one direction
      if (contact.tangents == 2 && like != nullptr)
        if (const int before = like->contact_of_point[static_cast<std::size_t>(c.point)]; before >= 0)
          c.wish = like->contacts[static_cast<std::size_t>(before)].frame.col(1);
      c.wish = tangent_wish(p.normal, c.wish);
      c.frame = contact_frame(p.normal, c.wish);
      c.mu = contact.mu;
      c.e = contact.e;
      c.bias = {p.gap_t, 0, 0};
      c.W.connect(model, contact.a, contact.b);
      fill_body(body_a, s.X[a], s.R[a], s.V[a], -1, x.t, c, c.W.A);
      fill_body(body_b, s.X[b], s.R[b], s.V[b], +1, x.t, c, c.W.B);
    }
  }
}

/// psi' = linear . (velocities of the anchor c_B as a point of B and of A) + angular . (w_B - w_A).
JointRowInstant joint_row(const Model& model, const Instant& s, const JointGeometry& joint,
                          const Vector3& c_B, const Vector3& linear, const Vector3& angular) {
  const auto a = static_cast<std::size_t>(joint.a.index), b = static_cast<std::size_t>(joint.b.index);
  const Body &body_a = model.bodies()[a], &body_b = model.bodies()[b];
  JointRowInstant row;
  row.W.connect(model, joint.a, joint.b);
  const auto side = [&](const Body& body, std::size_t i, double sign, WrenchMap<1>::Block& block) {
    const Vector3 moment = (c_B - s.X[i].p).cross(linear) + angular;
    if (body.nv > 0) block = sign * coordinates(body, s.R[i], linear, moment);
    if (body.kind == BodyKind::Prescribed)
      row.psi_b_t += sign * (linear.dot(s.V[i].v) + moment.dot(s.V[i].w));
  };
  side(body_a, a, -1, row.W.A);
  side(body_b, b, +1, row.W.B);
  return row;
}

void evaluate_joints(const Model& model, Instant& s) {
  s.joint_rows.clear();
  s.joint_frictions.clear();
  for (std::size_t i = 0; i < model.joints().size(); ++i) {
    const JointGeometry& joint = model.joints()[i];
    const auto a = static_cast<std::size_t>(joint.a.index), b = static_cast<std::size_t>(joint.b.index);
    const Vector3 c_A = s.X[a] * joint.anchor_a, c_B = s.X[b] * joint.anchor_b;
    const Vector3 none = Vector3::Zero();
    for (std::size_t r = 0; r < joint.rows.size(); ++r) {
      const JointRow& row = joint.rows[r];
      const Vector3 u = s.R[a] * row.in_a;
      const bool point = row.kind == JointRow::Kind::Point;
      const Vector3 w = point ? none : Vector3(s.R[b] * row.in_b);
      s.joint_rows.push_back(point ? joint_row(model, s, joint, c_B, u, none)
                                   : joint_row(model, s, joint, c_B, none, w.cross(u)));
      s.joint_rows.back().joint = static_cast<int>(i);
      s.joint_rows.back().row = static_cast<int>(r);
      s.joint_rows.back().psi_b = point ? u.dot(c_B - c_A) : u.dot(w);
    }
    if (joint.friction > 0) {
      const Vector3 axis = s.R[a] * joint.axis_a;
      const Vector3 side_a = s.R[a] * joint.side_a, side_b = s.R[b] * joint.side_b;
      const bool turns = joint.freedom == JointFreedom::Rotation;
      s.joint_frictions.push_back(turns ? joint_row(model, s, joint, c_B, none, axis)
                                        : joint_row(model, s, joint, c_B, axis, none));
      JointRowInstant& row = s.joint_frictions.back();
      row.joint = static_cast<int>(i);
      row.friction = joint.friction;
      row.psi_b =
          turns ? std::atan2(axis.dot(side_a.cross(side_b)), side_a.dot(side_b)) : axis.dot(c_B - c_A);
    }
  }
}

}  // namespace

void evaluate(const Model& model, const State& x, Instant& instant, const Instant* like) {
  instant.t = x.t;
  instant.fault.clear();
  evaluate_bodies(model, x, instant);
  evaluate_loads(model, x, instant);
  evaluate_joints(model, instant);
  evaluate_contacts(model, x, instant, like);
  if (instant.fault.empty() && !instant.k.allFinite())
    instant.fault = "a load is not finite at t = " + shortest(x.t);
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

void solve_mass(const Body& body, const double* f, double* out) {
  using Map3 = Eigen::Map<const Vector3>;
  const double per_mass = 1 / body.mass;
  const int linear = body.kind == BodyKind::Planar ? 2 : 3;
  for (int i = 0; i < linear; ++i) out[i] = per_mass * f[i];
  if (body.kind == BodyKind::Planar) out[2] = body.J_inverse(2, 2) * f[2];
  if (body.kind == BodyKind::Spatial) Eigen::Map<Vector3>(out + 3).noalias() = body.J_inverse * Map3(f + 3);
}

void solve_mass(const Model& model, const Vector& f, Vector& out) {
  out.resize(f.size());
  for (const Body& body : model.bodies())
    if (body.nv > 0) solve_mass(body, f.data() + body.v0, out.data() + body.v0);
}

void multiply_mass(const Model& model, const Vector& nu, Vector& out) {
  out = nu;
  for (const Body& body : model.bodies()) {
    if (body.nv == 0) continue;
    out.segment(body.v0, body.kind == BodyKind::Planar ? 2 : 3) *= body.mass;
    if (body.kind == BodyKind::Planar) out[body.v0 + 2] *= body.J(2, 2);
    if (body.kind == BodyKind::Spatial)
      out.segment<3>(body.v0 + 3) = body.J * Vector3(nu.segment<3>(body.v0 + 3));
  }
}

}  // namespace perp
