// Joints and loads: doc/joints.md's equations, written down anew.
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mechanics.hpp"

namespace checker {
namespace {

/// The axis and two directions across it, world axes with all bodies at their `position`.
Matrix3d axes(const Vector3d& along) {
  const Vector3d n = along.normalized();
  const Vector3d other = std::abs(n.x()) > 0.9 ? Vector3d::UnitY() : Vector3d::UnitX();
  Matrix3d frame;
  frame.col(0) = n;
  frame.col(1) = (other - n.dot(other) * n).normalized();
  frame.col(2) = n.cross(frame.col(1));
  return frame;
}

double near_to(double angle, double near) {
  return near + std::remainder(angle - near, 2 * std::numbers::pi);
}

double angle_about(const Vector3d& axis, const Vector3d& zero, const Vector3d& hand) {
  const Vector3d s = hand - axis.dot(hand) * axis;
  return std::atan2(axis.dot(zero.cross(s)), zero.dot(s));
}

/// The joint's axes carried by a and by b.
struct Carried {
  Matrix3d a, b;
  Vector3d anchor_a, anchor_b, apart;
};

Carried carried(const Scene& scene, const Joint& j, const State& x) {
  const auto at = [&](int i) -> const BodyState& { return x.bodies[static_cast<std::size_t>(i)]; };
  const auto rest = [&](int i) -> const Place& { return scene.bodies[static_cast<std::size_t>(i)].rest; };
  // a prescribed body's joint is defined where it is without its motion
  const auto turn = [&](int i) -> Quaterniond { return at(i).at.q * rest(i).q.conjugate(); };
  const auto point = [&](int i, const Vector3d& p) -> Vector3d {
    return at(i).at.p + turn(i) * (p - rest(i).p);
  };
  const Matrix3d frame = axes(j.axis);
  Carried c{turn(j.a) * frame,
            turn(j.b) * frame,
            point(j.a, j.point),
            point(j.b, j.kind == "rod" ? j.point_b : j.point),
            {}};
  c.apart = c.anchor_b - c.anchor_a;
  return c;
}

JointRow along(const Carried& c, const Vector3d& d) {
  JointRow row;
  row.psi = d.dot(c.apart);
  row.force = d;
  return row;
}

/// Of two directions carried by a and by b that keep at right angles: psi = u.w, which turning b about w x u brings on.
JointRow across(const Vector3d& u, const Vector3d& w) {
  JointRow row;
  row.psi = u.dot(w);
  row.moment_a = row.moment_b = w.cross(u);
  row.angle = true;
  return row;
}

/// How an angle about `axis` answers to the turning of what carries `hand`: the axis itself where the hand stands across it.
Vector3d gradient(const Vector3d& axis, const Vector3d& hand) {
  const Vector3d s = hand - axis.dot(hand) * axis;
  return axis - s * (hand.dot(axis) / s.squaredNorm());
}

JointRow turning(const Vector3d& axis, const Vector3d& hand, double angle) {
  JointRow row;
  row.psi = angle;
  row.moment_a = row.moment_b = gradient(axis, hand);
  row.angle = true;
  return row;
}

void add_coordinates(const Scene& scene, const Joint& j, const Carried& c, const double* near,
                     JointState& s) {
  (void)scene;
  const auto angle = [&] {
    const double now = angle_about(c.a.col(0), c.a.col(1), c.b.col(1));
    s.coordinates.push_back(turning(c.a.col(0), c.b.col(1), near_to(now, near[s.coordinates.size()])));
  };
  if (j.kind == "revolute" || j.kind == "screw") angle();
  if (j.kind == "prismatic") s.coordinates.push_back(along(c, c.a.col(0)));
  if (j.kind == "cylindrical") {
    angle();
    s.coordinates.push_back(along(c, c.a.col(0)));
  }
  if (j.kind == "planar") {
    s.coordinates.push_back(along(c, c.a.col(1)));
    s.coordinates.push_back(along(c, c.a.col(2)));
    angle();
  }
}

/// axis is fixed in a, axis_b in b; each angle is of what the other body carries.
void add_universal(const Joint& j, const Carried& c, const double* near, JointState& s) {
  const Vector3d rest_b = j.axis_b.isZero(0) ? Vector3d(axes(j.axis).col(1)) : j.axis_b.normalized();
  const Matrix3d frame = axes(j.axis);
  const Vector3d in_frame = frame.transpose() * rest_b;
  const Vector3d b_in_a = c.a * in_frame, b_in_b = c.b * in_frame;
  const Vector3d a_in_a = c.a.col(0), a_in_b = c.b.col(0);
  s.rows.push_back(across(a_in_a, b_in_b));
  s.coordinates.push_back(turning(a_in_a, b_in_b, near_to(angle_about(a_in_a, b_in_a, b_in_b), near[0])));
  s.coordinates.push_back(turning(b_in_b, a_in_a, near_to(-angle_about(b_in_b, a_in_b, a_in_a), near[1])));
}

/// Angles in the world about axes that stand still; whole turns are not the joint's error.
void add_gear(const Scene& scene, const Joint& j, const State& x, JointState& s) {
  const auto angle = [&](int i, const Matrix3d& frame) {
    const auto k = static_cast<std::size_t>(i);
    const Quaterniond turn = x.bodies[k].at.q * scene.bodies[k].rest.q.conjugate();
    return angle_about(frame.col(0), frame.col(1), turn * frame.col(1));
  };
  const Matrix3d a = axes(j.axis), b = axes(j.axis_b.isZero(0) ? j.axis : j.axis_b);
  JointRow row;
  const double by_a = angle(j.a, a), by_b = angle(j.b, b), turn = 2 * std::numbers::pi;
  row.psi = std::numeric_limits<double>::infinity();
  for (int k = -4; k <= 4; ++k) {
    const double psi = std::remainder(by_b - j.ratio * (by_a + k * turn), turn);
    if (std::abs(psi) < std::abs(row.psi)) row.psi = psi;
  }
  const auto hand = [&](int i, const Matrix3d& frame) -> Vector3d {
    return x.bodies[at(i)].at.q * scene.bodies[at(i)].rest.q.conjugate() * frame.col(1);
  };
  row.moment_b = gradient(b.col(0), hand(j.b, b));
  row.moment_a = j.ratio * gradient(a.col(0), hand(j.a, a));
  row.angle = true;
  s.rows.push_back(row);
}

}  // namespace

const std::vector<std::string>& coordinate_names(const std::string& kind) {
  static const std::map<std::string, std::vector<std::string>> names = {
      {"revolute", {"angle"}},         {"prismatic", {"slide"}}, {"cylindrical", {"angle", "slide"}},
      {"planar", {"x", "y", "angle"}}, {"screw", {"angle"}},     {"universal", {"angle_a", "angle_b"}}};
  static const std::vector<std::string> none;
  const auto found = names.find(kind);
  return found == names.end() ? none : found->second;
}

std::size_t first_coordinate(const Scene& scene, int joint) {
  std::size_t first = 0;
  for (int i = 0; i < joint; ++i)
    first += coordinate_names(scene.joints[static_cast<std::size_t>(i)].kind).size();
  return first;
}

std::size_t coordinate_index(const Scene& scene, int joint, const std::string& name) {
  const auto& names = coordinate_names(scene.joints[static_cast<std::size_t>(joint)].kind);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (name.empty() || names[i] == name) return first_coordinate(scene, joint) + i;
  throw std::runtime_error("no coordinate " + name);
}

JointState joint_state(const Scene& scene, int joint, const State& x, const double* near) {
  const Joint& j = scene.joints[static_cast<std::size_t>(joint)];
  const Carried c = carried(scene, j, x);
  JointState s;
  s.anchor = c.anchor_b;
  const auto is = [&](std::initializer_list<const char*> kinds) {
    for (const char* kind : kinds)
      if (j.kind == kind) return true;
    return false;
  };
  if (is({"fixed", "ball", "revolute", "universal", "prismatic", "cylindrical", "screw"}))
    for (const int i : {1, 2}) s.rows.push_back(along(c, c.a.col(i)));
  if (is({"fixed", "ball", "revolute", "universal", "planar"})) s.rows.push_back(along(c, c.a.col(0)));
  if (is({"fixed", "revolute", "prismatic", "cylindrical", "screw", "planar"}))
    for (const int i : {1, 2}) s.rows.push_back(across(c.a.col(i), c.b.col(0)));
  if (is({"fixed", "prismatic"})) s.rows.push_back(across(c.a.col(2), c.b.col(1)));
  if (j.kind == "universal") add_universal(j, c, near, s);
  if (j.kind == "gear") add_gear(scene, j, x, s);
  if (j.kind == "rod") {
    const double length = (j.point_b - j.point).norm(), now = c.apart.norm();
    JointRow row;
    row.psi = now - length;
    row.force = c.apart / now;
    s.rows.push_back(row);
  }
  add_coordinates(scene, j, c, near, s);
  if (j.kind == "screw") {
    JointRow row = along(c, c.a.col(0));
    const double slide = row.psi;
    row.psi = slide - j.lead * near_to(s.coordinates[0].psi, slide / j.lead);
    row.moment_a = row.moment_b = -j.lead * s.coordinates[0].moment_b;
    s.rows.push_back(row);
  }
  for (const Motor& m : scene.motors) {
    if (m.joint != joint || m.motion.empty()) continue;
    JointRow row =
        s.coordinates[coordinate_index(scene, joint, m.coordinate) - first_coordinate(scene, joint)];
    row.psi -= evaluate(m.motion, {{"t", x.t}}).value;
    s.rows.push_back(row);
  }
  return s;
}

std::vector<double> coordinates(const Scene& scene, const State& x, const std::vector<double>& near) {
  std::vector<double> values;
  for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j)
    for (const JointRow& row : joint_state(scene, j, x, near.data() + values.size()).coordinates)
      values.push_back(row.psi);
  return values;
}

double rate(const State& x, const Joint& joint, const JointRow& row, const Vector3d& anchor) {
  const BodyState &a = x.bodies[static_cast<std::size_t>(joint.a)],
                  &b = x.bodies[static_cast<std::size_t>(joint.b)];
  return row.force.dot(b.velocity_at(anchor) - a.velocity_at(anchor)) + row.moment_b.dot(b.w) -
         row.moment_a.dot(a.w);
}

namespace {

void push(const State& x, int body, const Vector3d& force, const Vector3d& point, std::vector<Wrench>& all) {
  Wrench& w = all[static_cast<std::size_t>(body)];
  w.force += force;
  w.moment += (point - x.bodies[static_cast<std::size_t>(body)].at.p).cross(force);
}

struct SpringNow {
  Vector3d x_a, x_b, e = Vector3d::Zero();
  double length, rate = 0;
};

SpringNow spring_now(const Spring& s, const State& x) {
  const BodyState &a = x.bodies[static_cast<std::size_t>(s.a)], &b = x.bodies[static_cast<std::size_t>(s.b)];
  SpringNow now{a.at * s.point_a, b.at * s.point_b, Vector3d::Zero(), 0};
  const Vector3d d = now.x_b - now.x_a;
  now.length = d.norm();
  if (now.length > 0) now.e = d / now.length;
  now.rate = now.e.dot(b.velocity_at(now.x_b) - a.velocity_at(now.x_a));
  return now;
}

Vector3d force_now(const Scene& scene, const Force& f, const State& x) {
  const BodyState& s = x.bodies[static_cast<std::size_t>(f.body)];
  std::map<std::string, double> names = {{"t", x.t},        {"x", s.at.p.x()}, {"y", s.at.p.y()},
                                         {"vx", s.v.x()},   {"vy", s.v.y()},   {"angle", s.angle},
                                         {"omega", s.w.z()}};
  if (scene.bodies[static_cast<std::size_t>(f.body)].kind != Kind::Planar)
    names.insert({{"z", s.at.p.z()}, {"vz", s.v.z()}, {"wx", s.w.x()}, {"wy", s.w.y()}, {"wz", s.w.z()}});
  return {evaluate(f.force[0], names).value, evaluate(f.force[1], names).value,
          evaluate(f.force[2], names).value};
}

/// Calls with joint, row of the coordinate, anchor and the effort along it.
template <class Act>
void joint_efforts(const Scene& scene, const State& x, const std::vector<double>& values, bool springs,
                   bool others, Act act) {
  const auto at = [&](int joint, const std::string& name, auto effort) {
    const std::size_t first = first_coordinate(scene, joint), index = coordinate_index(scene, joint, name);
    const JointState s = joint_state(scene, joint, x, values.data() + first);
    const JointRow& row = s.coordinates[index - first];
    const Joint& j = scene.joints[static_cast<std::size_t>(joint)];
    const double speed = rate(x, j, row, s.anchor);
    act(j, row, s.anchor, effort(row.psi, speed), speed);
  };
  for (const JointSpring& s : scene.joint_springs)
    at(s.joint, s.coordinate, [&](double c, double r) {
      return (springs ? -s.stiffness * (c - s.rest) : 0) - (others ? s.damping * r : 0);
    });
  for (const Motor& m : scene.motors) {
    if (m.effort.empty() || !others) continue;
    at(m.joint, m.coordinate, [&](double c, double r) {
      return evaluate(m.effort, {{"t", x.t}, {"coordinate", c}, {"rate", r}}).value;
    });
  }
}

}  // namespace

std::vector<Wrench> loads(const Scene& scene, const State& x, const std::vector<double>& values) {
  std::vector<Wrench> all(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) all[i].force = scene.bodies[i].mass * scene.gravity;
  for (const Spring& s : scene.springs) {
    const SpringNow now = spring_now(s, x);
    const Vector3d force = (-s.stiffness * (now.length - s.length) - s.damping * now.rate) * now.e;
    push(x, s.b, force, now.x_b, all);
    push(x, s.a, -force, now.x_a, all);
  }
  for (const Force& f : scene.forces)
    push(x, f.body, force_now(scene, f, x), x.bodies[static_cast<std::size_t>(f.body)].at.p, all);
  joint_efforts(scene, x, values, true, true,
                [&](const Joint& j, const JointRow& row, const Vector3d& anchor, double effort, double) {
                  push(x, j.b, effort * row.force, anchor, all);
                  push(x, j.a, -effort * row.force, anchor, all);
                  all[static_cast<std::size_t>(j.b)].moment += effort * row.moment_b;
                  all[static_cast<std::size_t>(j.a)].moment -= effort * row.moment_a;
                });
  return all;
}

double potential_energy(const Scene& scene, const State& x, const std::vector<double>& values) {
  double energy = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    energy -= scene.bodies[i].mass * scene.gravity.dot(x.bodies[i].at.p);
  for (const Spring& s : scene.springs) {
    const double stretch = spring_now(s, x).length - s.length;
    energy += 0.5 * s.stiffness * stretch * stretch;
  }
  for (const JointSpring& s : scene.joint_springs) {
    const double turn = values[coordinate_index(scene, s.joint, s.coordinate)] - s.rest;
    energy += 0.5 * s.stiffness * turn * turn;
  }
  return energy;
}

double load_power(const Scene& scene, const State& x, const std::vector<double>& values) {
  double power = 0;
  for (const Force& f : scene.forces)
    power += force_now(scene, f, x).dot(x.bodies[static_cast<std::size_t>(f.body)].v);
  for (const Spring& s : scene.springs) {
    const double rate = spring_now(s, x).rate;
    power -= s.damping * rate * rate;
  }
  joint_efforts(scene, x, values, false, true,
                [&](const Joint&, const JointRow&, const Vector3d&, double effort, double speed) {
                  power += effort * speed;
                });
  return power;
}

}  // namespace checker
