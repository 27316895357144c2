// The numbers of a step that all parts of the judgement share.
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "judge.hpp"

namespace checker {
Step::Step(const Scene& scene_, const Run& run, std::size_t index_, const std::vector<double>& coordinates_,
           const std::string& method_, const Marks& marks_)
    : scene(scene_),
      method(method_),
      marks(marks_),
      index(index_),
      h(run.steps[index_].h),
      x(run.states[index_]),
      y(run.states[index_ + 1]),
      row(run.steps[index_]),
      contacts(run.contacts[index_]),
      joint_rows(run.joints[index_]),
      values(coordinates_) {
  u = h > 0 ? between(scene, x, y, h) : x;
  values_y = coordinates(scene, y, values);
  at_x = touches(scene, x, values);
  at_y = touches(scene, y, values_y);
  for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
    const std::size_t first = first_coordinate(scene, j);
    joints_x.push_back(joint_state(scene, j, x, values.data() + first));
    joints_y.push_back(joint_state(scene, j, y, values_y.data() + first));
  }
  for (const ContactRow& c : contacts)  // nothing goes unlooked at
    if (!c.p.isZero(0) && (touch(at_x, c.contact) == nullptr || touch(at_y, c.contact) == nullptr))
      throw std::runtime_error("the checker does not know the contact point " + c.contact);
  load_x = loads(scene, x, values);
  double farthest = 0;
  for (const BodyState& b : y.bodies) farthest = std::max(farthest, b.at.p.norm());
  for (const Touch& c : at_y) farthest = std::max(farthest, c.point.norm());
  if (h > 0) place_rounding_ = marks.rounding * farthest / h;
  find_islands();
  find_speeds();
  find_strikes();
}

/// Whether a contact is as good as closed at the end, at the speeds of the fastest.
bool Step::closed(const std::string& name) const {
  double fastest = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    fastest = std::max(fastest, x.bodies[i].v.norm() + h * scene.gravity.norm());
  const Touch* t = touch(at_y, name);
  return t != nullptr && t->gap * (t->turns ? 0 : 1) <= 1e-3 * h * fastest;
}

void Step::find_islands() {
  std::vector<int> root(scene.bodies.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[at(i)] != i) i = root[at(i)];
    return i;
  };
  const auto tie = [&](int a, int b) {
    if (scene.bodies[at(a)].moves() && scene.bodies[at(b)].moves()) root[at(find(a))] = find(b);
  };
  for (const Joint& j : scene.joints) tie(j.a, j.b);
  for (const ContactRow& c : contacts)
    if (const Touch* t = touch(at_x, c.contact); t != nullptr && (!c.p.isZero(0) || closed(c.contact)))
      tie(t->a, t->b);
  island.assign(scene.bodies.size(), -1);
  std::vector<int> number(scene.bodies.size(), -1);
  int count = 0;
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    if (!scene.bodies[at(i)].moves()) continue;
    int& n = number[at(find(i))];
    if (n < 0) n = count++;
    island[at(i)] = n;
  }
  speed.assign(at(count), 0);
  struck.assign(at(count), 0);
  follows.assign(at(count), 1);
}

double Step::linear_speed(int body, const Vector3d& impulse) const {
  return impulse.norm() / scene.bodies[at(body)].mass;
}

double Step::angular_speed(int body, const Vector3d& moment) const {
  const Body& b = scene.bodies[at(body)];
  if (b.kind == Kind::Planar) return std::abs(moment.z()) / std::sqrt(b.size[0] * b.mass);
  if (b.kind != Kind::Spatial) return 0;
  return std::sqrt(moment.dot(b.inertia().inverse() * moment) / b.mass);
}

void Step::find_speeds() {
  const auto raise = [&](int body, double by) {
    if (island[at(body)] >= 0) speed[at(island[at(body)])] = std::max(speed[at(island[at(body)])], by);
  };
  const std::vector<Wrench> load_y = loads(scene, y, values_y);
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const Body& b = scene.bodies[at(i)];
    if (!b.moves()) continue;
    const BodyState& s = x.bodies[at(i)];
    double own = s.v.norm();
    if (b.turns()) own += angular_speed(i, b.inertia() * (s.at.q.conjugate() * s.w));
    for (const auto* load : {&std::as_const(load_x), &load_y}) {
      const Wrench& w = (*load)[at(i)];
      double by_load = h * linear_speed(i, w.force);
      if (b.turns()) by_load += h * angular_speed(i, s.at.q.conjugate() * w.moment);
      if (load == &load_x || by_load < 10 * own) raise(i, own + by_load);
    }
  }
  const auto prescribed = [&](int body, int other, const Vector3d& point) {
    const Body& b = scene.bodies[at(body)];
    if (b.moves()) return;
    for (const State* now : {&x, &y})
      raise(other, (now->bodies[at(body)].velocity_at(point) + surface_velocity(b)).norm());
  };
  for (const ContactRow& c : contacts) {
    const Touch* t = touch(at_x, c.contact);
    if (t == nullptr || c.p.isZero(0)) continue;
    prescribed(t->a, t->b, t->point);
    prescribed(t->b, t->a, t->point);
    if (h > 0 && !t->turns)
      for (const int body : {t->a, t->b}) raise(body, std::max(0.0, -t->gap) / h);
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    prescribed(joint.a, joint.b, joints_x[j].anchor);
    prescribed(joint.b, joint.a, joints_x[j].anchor);
    for (const Motor& m : scene.motors) {
      if (at(m.joint) != j || m.motion.empty()) continue;
      const JointState& s = joints_x[j];
      for (const double t : {x.t, y.t})
        for (const int body : {joint.a, joint.b}) {
          const double r = evaluate(m.motion, {{"t", t}}).slope;
          const double lever = (s.anchor - x.bodies[at(body)].at.p).norm();
          raise(body,
                std::abs(r) * (s.rows.back().angle
                                   ? std::max(lever, std::sqrt(scene.bodies[at(body)].inertia().trace() /
                                                               std::max(scene.bodies[at(body)].mass, 1e-300)))
                                   : 1));
        }
    }
  }
}

/// Contacts that carry something and came in faster than the loads of two steps make them; and what may have been struck.
void Step::find_strikes() {
  constexpr double near = 1e-7;  // of speeds: what is at rest may seem to come in
  for (const ContactRow& c : contacts) {
    const Touch* t = touch(at_x, c.contact);
    if (t == nullptr) continue;
    const double un = t->normal.dot(relative_velocity(scene, x, *t));
    // with restitution whatever comes in rebounds, be it by rounding
    const double scale = t->turns ? std::abs(un) : speed_of(*t);
    const bool comes_in = un < (t->e > 0 ? 1e-12 : -near) * scale || (t->turns && un < 0);
    for (const int body : {t->a, t->b})
      if (comes_in && island[at(body)] >= 0 && (!c.p.isZero(0) || closed(c.contact)))
        struck[at(island[at(body)])] = 1;
    const bool pushes = c.f.allFinite() && !c.f.isZero(0);  // of an event's second row: a force, no impulse
    has_loaded = has_loaded || pushes || !c.p.isZero(0);
    has_sliding = has_sliding || ((pushes || !c.p.isZero(0)) && c.mode == "slip" && t->mu > 0);
    if (c.p.isZero(0)) continue;
    double by_loads = 0;
    for (const int body : {t->a, t->b})
      if (scene.bodies[at(body)].moves() && !t->turns)
        by_loads += 2 * h * linear_speed(body, load_x[at(body)].force);
    has_impact = has_impact || un < -by_loads - 1e-7 * (t->turns ? std::abs(un) : speed_of(*t));
  }
}

double Step::speed_of(int body) const { return island[at(body)] < 0 ? 0 : speed[at(island[at(body)])]; }
double Step::speed_of(const Touch& c) const { return std::max(speed_of(c.a), speed_of(c.b)); }

const JointReport* Step::joint(std::size_t j) const {
  const std::string& name = scene.joints[j].name;
  for (const JointReport& r : joint_rows)
    if (r.joint == name || r.joint.starts_with(name + ".")) return &r;
  return nullptr;
}

Matrix3d Step::mobility(const Touch& c, const State& where) const {
  Matrix3d G = Matrix3d::Zero();
  for (const int i : {c.a, c.b}) {
    const Body& b = scene.bodies[at(i)];
    if (!b.moves()) continue;
    G += Matrix3d::Identity() / b.mass;
    if (!b.turns()) continue;
    const Matrix3d R = where.bodies[at(i)].at.q.toRotationMatrix();
    Matrix3d inverse = Matrix3d::Zero();
    if (b.kind == Kind::Planar)
      inverse(2, 2) = 1 / b.size[0];
    else
      inverse = R * b.inertia().inverse() * R.transpose();
    if (c.turns) {
      G = inverse;
      continue;
    }
    const Vector3d r = c.point - where.bodies[at(i)].at.p;
    Matrix3d cross;
    cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    G += cross.transpose() * inverse * cross;
  }
  return G;
}

const Touch* Step::touch(const std::vector<Touch>& all, const std::string& name) const {
  for (const Touch& t : all)
    if (t.name == name) return &t;
  return nullptr;
}

double Step::allowed(double of, double added_up) const {
  of = std::max(of, place_rounding_);  // the least that a gap, rounded, asks for
  return marks.speed * of + std::min(marks.rounding * added_up, marks.most * of);
}

void Step::fault(const std::string& part, const std::string& of, double value, double limit) {
  if (value <= limit || !std::isfinite(limit)) return;  // a NaN of a finite limit is a fault too
  faults.push_back({index, part, of, value, limit});
}

std::vector<Sum> reactions(const Step& s, const State& where, const std::vector<Touch>& touches,
                           const std::vector<JointState>& joints) {
  std::vector<Sum> sums(s.scene.bodies.size());
  const auto add = [&](int body, const Vector3d& force, const Vector3d& point, const Vector3d& moment) {
    if (!s.scene.bodies[at(body)].moves()) return;
    const BodyState& b = where.bodies[at(body)];
    const Vector3d angular = (point - b.at.p).cross(force) + moment;
    sums[at(body)].linear += force;
    sums[at(body)].angular += angular;
    sums[at(body)].linear_size += s.linear_speed(body, force);
    const Vector3d size = (point.norm() + b.at.p.norm()) * force.norm() * Vector3d::UnitX();
    sums[at(body)].angular_size +=
        s.angular_speed(body, b.at.q.conjugate() * angular) + 1e-2 * s.angular_speed(body, size);
  };
  for (const ContactRow& c : s.contacts) {
    if (c.half != 0) continue;
    const Touch* t = s.touch(touches, c.contact);
    if (t == nullptr) continue;
    const Vector3d zero = Vector3d::Zero();
    add(t->b, t->turns ? zero : c.p, t->point, t->turns ? c.p : zero);
    add(t->a, t->turns ? zero : Vector3d(-c.p), t->point, t->turns ? Vector3d(-c.p) : zero);
  }
  for (std::size_t j = 0; j < s.scene.joints.size(); ++j) {
    const JointReport* r = s.joint(j);
    if (r == nullptr) continue;
    const Joint& joint = s.scene.joints[j];
    const JointState& now = joints[j];
    Vector3d force = s.h * r->force, moment_b = s.h * r->moment, moment_a = moment_b;
    if (joint.kind == "gear")
      moment_a =
          moment_b.dot(now.rows[0].moment_b) / now.rows[0].moment_b.squaredNorm() * now.rows[0].moment_a;
    if (joint.friction > 0) {
      const JointRow& along = now.coordinates[0];
      force += s.h * r->friction * along.force;
      moment_b += s.h * r->friction * along.moment_b;
      moment_a += s.h * r->friction * along.moment_a;
    }
    add(joint.b, force, now.anchor, moment_b);
    add(joint.a, -force, now.anchor, -moment_a);
  }
  return sums;
}

}  // namespace checker
