// Reading, writing and moving states: the only place that knows how a body's kind lays out q and nu.
#include "perp/model/state.hpp"

#include <cmath>
#include <numbers>

#include "perp/core/errors.hpp"
#include "perp/model/model.hpp"

namespace perp {
namespace {

Quaternion orientation(const Vector& q, int q0) { return {q[q0 + 3], q[q0 + 4], q[q0 + 5], q[q0 + 6]}; }

void set(Vector& q, int q0, const Quaternion& r) { q.segment<4>(q0 + 3) << r.w(), r.x(), r.y(), r.z(); }

constexpr double quarter_turn = std::numbers::pi / 2;

double about_z(const Quaternion& q) { return 2 * std::atan2(q.z(), q.w()); }

[[noreturn]] void immovable(const char* where, const Body& body) {
  refuse(where, "body", body.name, "has no such coordinate");
}

void need_finite(const char* where, const char* argument, const Vector3& v) {
  for (const double x : v)
    if (!std::isfinite(x)) refuse(where, argument, x, "needs finite entries");
}

}  // namespace

State Model::rest() const {
  State x{.t = 0, .q = Vector::Zero(nq_), .nu = Vector::Zero(nv_), .winding = Vector::Zero(windings_)};
  for (const Body& b : bodies_) {
    if (b.kind == BodyKind::Planar) x.q.segment<3>(b.q0) << b.rest.p.x(), b.rest.p.y(), about_z(b.rest.q);
    if (b.kind == BodyKind::Particle || b.kind == BodyKind::Spatial) x.q.segment<3>(b.q0) = b.rest.p;
    if (b.kind == BodyKind::Spatial) set(x.q, b.q0, b.rest.q);
  }
  return x;
}

void Model::set_position(State& x, BodyId id, const Vector3& p) const {
  const Body& b = body(id);
  need_finite("set_position", "p", p);
  if (b.nv == 0 || b.kind == BodyKind::Generalized || (b.kind == BodyKind::Planar && p.z() != 0))
    immovable("set_position", b);
  x.q.segment(b.q0, b.kind == BodyKind::Planar ? 2 : 3) = p.head(b.kind == BodyKind::Planar ? 2 : 3);
}

void Model::set_orientation(State& x, BodyId id, const Quaternion& q) const {
  const Body& b = body(id);
  const double norm = q.norm();
  if (!(norm > 0) || !std::isfinite(norm)) refuse("set_orientation", "q", norm, "needs a finite length");
  if (b.kind == BodyKind::Spatial) {
    set(x.q, b.q0, unit(q));
  } else if (b.kind == BodyKind::Planar && q.x() == 0 && q.y() == 0) {
    x.q[b.q0 + 2] = about_z(q);
  } else {
    immovable("set_orientation", b);
  }
}

void Model::set_velocity(State& x, BodyId id, const Vector3& v, const Vector3& w) const {
  const Body& b = body(id);
  need_finite("set_velocity", "v", v);
  need_finite("set_velocity", "w", w);
  switch (b.kind) {
    case BodyKind::Spatial:
      x.nu.segment<3>(b.v0) = v;
      x.nu.segment<3>(b.v0 + 3) = orientation(x.q, b.q0).conjugate() * w;
      return;
    case BodyKind::Planar:
      if (v.z() != 0 || w.x() != 0 || w.y() != 0) break;
      x.nu.segment<3>(b.v0) << v.x(), v.y(), w.z();
      return;
    case BodyKind::Particle:
      if (!w.isZero(0)) break;
      x.nu.segment<3>(b.v0) = v;
      return;
    default:
      break;
  }
  immovable("set_velocity", b);
}

Pose Model::pose(const State& x, BodyId id) const {
  const Body& b = body(id);
  switch (b.kind) {
    case BodyKind::Spatial:
      return {x.q.segment<3>(b.q0), orientation(x.q, b.q0)};
    case BodyKind::Planar: {
      const double half = 0.5 * x.q[b.q0 + 2];
      return {{x.q[b.q0], x.q[b.q0 + 1], 0}, {std::cos(half), 0, 0, std::sin(half)}};
    }
    case BodyKind::Particle:
      return {x.q.segment<3>(b.q0), Quaternion::Identity()};
    case BodyKind::Prescribed:
      return b.motion.pose(x.t);
    case BodyKind::Ground:
    case BodyKind::Generalized:
      break;
  }
  return {};
}

Twist Model::twist(const State& x, BodyId id) const {
  const Body& b = body(id);
  switch (b.kind) {
    case BodyKind::Spatial:
      return {x.nu.segment<3>(b.v0), orientation(x.q, b.q0) * Vector3(x.nu.segment<3>(b.v0 + 3))};
    case BodyKind::Planar:
      return {{x.nu[b.v0], x.nu[b.v0 + 1], 0}, {0, 0, x.nu[b.v0 + 2]}};
    case BodyKind::Particle:
      return {x.nu.segment<3>(b.v0), Vector3::Zero()};
    case BodyKind::Prescribed:
      return b.motion.twist(x.t);
    case BodyKind::Ground:
    case BodyKind::Generalized:
      break;
  }
  return {};
}

void Model::set_coordinates(State& x, BodyId id, const Vector& q, const Vector& nu) const {
  const Body& b = body(id);
  if (b.kind != BodyKind::Generalized)
    refuse("set_coordinates", "generalized", b.name, "needs to be a generalized body");
  for (const auto& [argument, v] : {std::pair("q", &q), std::pair("nu", &nu)})
    if (v->size() != b.nv || !v->allFinite())
      refuse("set_coordinates", argument, static_cast<double>(v->size()),
             "needs " + std::to_string(b.nv) + " finite entries");
  x.q.segment(b.q0, b.nq) = q;
  x.nu.segment(b.v0, b.nv) = nu;
}

double Model::angle(const State& x, BodyId id) const {
  const Body& b = body(id);
  if (b.kind != BodyKind::Planar) refuse("angle", "body", b.name, "needs to be a planar body");
  return x.q[b.q0 + 2];
}

JointRowValue Model::evaluate(const State& x, const JointGeometry& j, const JointRow& row) const {
  return evaluate(x, j, row, pose(x, j.a), pose(x, j.b));
}

JointRowValue Model::evaluate(const State& x, const JointGeometry& j, const JointRow& row, const Pose& X_WA,
                              const Pose& X_WB) const {
  double near[2] = {0, 0};
  if (row.winding >= 0 && x.winding.size() == windings_) {
    for (int i = 0; i < (row.kind == JointRow::Kind::Gear ? 2 : 1); ++i)
      near[i] = x.winding[row.winding + i] * quarter_turn;
  } else if (row.kind == JointRow::Kind::Angle || row.kind == JointRow::Kind::Gear) {
    const auto turned = [&](const Body& b) {
      return b.kind == BodyKind::Planar ? x.q[b.q0 + 2] - about_z(b.rest.q) : 0.0;
    };
    const double a = row.turn.axis.z() * turned(body(j.a));
    const bool gear = row.kind == JointRow::Kind::Gear;
    near[0] = gear ? a : row.turn.axis.z() * turned(body(j.b)) - a;
    near[1] = gear ? row.turn_b.axis.z() * turned(body(j.b)) : 0;
  }
  return perp::evaluate(row, j, X_WA, X_WB, near);
}

double Model::coordinate(const State& x, JointId id, int i) const {
  return evaluate(x, joint(id), need_coordinate("coordinate", id, i).row).psi;
}

double Model::coordinate_rate(const State& x, JointId id, int i) const {
  const JointGeometry& j = joint(id);
  const JointRowValue row = evaluate(x, j, need_coordinate("coordinate_rate", id, i).row);
  const Vector3 c = pose(x, j.b) * j.anchor_b;
  const Twist a = twist(x, j.a), b = twist(x, j.b);
  return row.linear.dot(b.at(c - position(x, j.b)) - a.at(c - position(x, j.a))) + row.angular_b.dot(b.w) -
         row.angular_a.dot(a.w);
}

void Model::follow_turns(State& x) const {
  if (windings_ == 0) return;
  if (x.winding.size() != windings_) x.winding.setZero(windings_);
  const auto follow = [&](const JointGeometry& j, const JointRow& row) {
    if (row.winding < 0) return;
    const JointRowValue now = evaluate(x, j, row);
    for (int i = 0; i < (row.kind == JointRow::Kind::Gear ? 2 : 1); ++i)
      x.winding[row.winding + i] = std::round(now.angles[i] / quarter_turn);
  };
  for (const JointGeometry& j : joints_) {
    for (const JointRow& row : j.rows) follow(j, row);
    for (const JointCoordinate& c : j.coordinates) follow(j, c.row);
  }
}

double Model::kinetic_energy(const State& x) const {
  double energy = 0;
  for (const Body& b : bodies_) {
    const auto nu = x.nu.segment(b.v0, b.nv);
    if (b.kind == BodyKind::Spatial) {
      const Vector3 w = nu.tail<3>();
      energy += 0.5 * (b.mass * nu.head<3>().squaredNorm() + w.dot(b.J * w));
    } else if (b.kind == BodyKind::Planar) {
      energy += 0.5 * (b.mass * nu.head<2>().squaredNorm() + b.J(2, 2) * nu[2] * nu[2]);
    } else if (b.kind == BodyKind::Particle) {
      energy += 0.5 * b.mass * nu.squaredNorm();
    } else if (b.kind == BodyKind::Generalized) {
      energy += 0.5 * nu.dot(b.system.mass(x.q.segment(b.q0, b.nq)) * nu);
    }
  }
  return energy;
}

double Model::energy(const State& x) const {
  double energy = kinetic_energy(x);
  for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) {
    const Body& b = bodies_[static_cast<std::size_t>(i)];
    if (b.kind == BodyKind::Generalized) {
      if (b.system.potential) energy += b.system.potential(x.q.segment(b.q0, b.nq));
    } else if (b.nv > 0) {
      energy -= b.mass * gravity_.dot(position(x, {i}));
    }
  }
  for (const Spring& s : springs_) {
    const double stretch = (pose(x, s.b) * s.point_b - pose(x, s.a) * s.point_a).norm() - s.length;
    energy += 0.5 * s.stiffness * stretch * stretch;
  }
  for (const JointSpring& s : joint_springs_) {
    const double stretch = coordinate(x, s.joint, s.coordinate) - s.rest;
    energy += 0.5 * s.stiffness * stretch * stretch;
  }
  return energy;
}

Momentum Model::momentum(const State& x) const {
  Momentum sum;
  for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) {
    const Body& b = bodies_[static_cast<std::size_t>(i)];
    if (b.nv == 0 || b.kind == BodyKind::Generalized) continue;
    const Pose X = pose(x, {i});
    const Twist V = twist(x, {i});
    sum.linear += b.mass * V.v;
    sum.angular += b.mass * X.p.cross(V.v) + X.q * Vector3(b.J * (X.q.conjugate() * V.w));
  }
  return sum;
}

void Model::check(std::string_view where, const State& x) const {
  const auto check = [&](const char* argument, const Vector& v, int size) {
    if (v.size() != size)
      refuse(where, argument, "of size " + std::to_string(v.size()),
             "this model needs size " + std::to_string(size));
    for (const double entry : v)
      if (!std::isfinite(entry)) refuse(where, argument, entry, "needs finite entries");
  };
  if (!std::isfinite(x.t)) refuse(where, "x.t", x.t, "needs to be finite [s]");
  check("x.q", x.q, nq_);
  check("x.nu", x.nu, nv_);
  if (x.winding.size() > 0) check("x.winding", x.winding, windings_);
}

void move(const Model& model, const Vector& nu, double h, Vector& q) {
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    if (b.kind == BodyKind::Generalized) {
      q.segment(b.q0, b.nq) += h * nu.segment(b.v0, b.nv);
      continue;
    }
    q.segment<3>(b.q0) += h * nu.segment<3>(b.v0);
    if (b.kind == BodyKind::Spatial)
      set(q, b.q0, (orientation(q, b.q0) * rotation(h * nu.segment<3>(b.v0 + 3))).normalized());
  }
}

}  // namespace perp
