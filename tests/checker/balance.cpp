// Momentum, and how places follow velocities, of the steps that ask once where forces are: lcp at the start, ncp at the end.
#include <cmath>

#include "judge.hpp"

namespace checker {
namespace {

/// Whether q+ = q + h nu+ of a body, the difference as a speed.
double kinematic_error(const Step& s, int i) {
  const BodyState &u = s.u.bodies[at(i)], &y = s.y.bodies[at(i)], &x = s.x.bodies[at(i)];
  double error = (u.v - y.v).norm();
  // between() turns about a fixed axis of the world, in which nu+ stands in the axes that q+ has
  if (s.scene.bodies[at(i)].turns()) {
    const Vector3d in_body = y.at.q.conjugate() * y.w, moved = x.at.q.conjugate() * u.w;
    error = std::max(error, s.angular_speed(i, s.scene.bodies[at(i)].inertia() * (in_body - moved)));
  }
  return error;
}

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// The angular velocity at the end of a step without reactions, J (w_f - w) = h (torque - w_f x J w_f), body axes, by Newton's method.
Vector3d free_end(const Matrix3d& J, const Vector3d& w, const Vector3d& torque, double h) {
  Vector3d end = w;
  for (int i = 0; i < 30; ++i) {
    const Vector3d left = J * (end - w) + h * (end.cross(J * end) - torque);
    const Matrix3d slope = J + h * (cross(end) * J - cross(J * end));
    end -= slope.inverse() * left;
  }
  return end;
}

}  // namespace

void judge_balance(Step& s) {
  const bool end = s.method == "ncp";
  const int bodies = static_cast<int>(s.scene.bodies.size());

  // an impact's velocities are not those that moved the bodies: what they tie together is one island
  for (int i = 1; i < bodies; ++i) {
    if (!s.scene.bodies[at(i)].moves()) continue;
    const double error = kinematic_error(s, i),
                 size = std::sqrt(s.scene.bodies[at(i)].inertia().trace() / s.scene.bodies[at(i)].mass);
    const double limit = s.allowed(s.speed_of(i), 0) + s.place_rounding() +
                         s.marks.rounding * (s.y.bodies[at(i)].v.norm() + size / s.h * 1);
    if (error <= limit) continue;
    s.follows[at(s.island[at(i)])] = 0;
    if (s.struck[at(s.island[at(i)])] == 0 && !s.projected())
      s.fault("kinematic", s.scene.bodies[at(i)].name, error, limit);
  }

  // loads stand at the start, or at q+ with the velocities that led there
  State where = end ? s.y : s.x;
  if (end)
    for (int i = 1; i < bodies; ++i) {
      if (!s.scene.bodies[at(i)].moves() || s.follows[at(s.island[at(i)])] != 0) continue;
      where.bodies[at(i)].v = s.u.bodies[at(i)].v;
      where.bodies[at(i)].w = s.u.bodies[at(i)].w;
    }
  const std::vector<Wrench> load = loads(s.scene, where, end ? s.values_y : s.values);
  const std::vector<Sum> sums = reactions(s, where, end ? s.at_y : s.at_x, end ? s.joints_y : s.joints_x);
  double worst = 0, rounding = 0;
  for (int i = 1; i < bodies; ++i) {
    const Body& b = s.scene.bodies[at(i)];
    if (!b.moves()) continue;
    const BodyState &x = s.x.bodies[at(i)], &y = s.y.bodies[at(i)], &w = where.bodies[at(i)];
    Vector3d linear = b.mass * (y.v - x.v) - s.h * load[at(i)].force - sums[at(i)].linear;
    if (b.kind == Kind::Planar) linear.z() = 0;
    const double size =
        sums[at(i)].linear_size + x.v.norm() + y.v.norm() + s.h * s.linear_speed(i, load[at(i)].force);
    s.fault("momentum", b.name, s.linear_speed(i, linear), s.allowed(s.speed_of(i), size));
    worst = std::max(worst, linear.cwiseAbs().maxCoeff());
    rounding = std::max(rounding, s.marks.rounding * size * b.mass);
    if (!b.turns()) continue;
    const Matrix3d J = b.inertia();
    const Vector3d w_x = x.at.q.conjugate() * x.w, w_y = y.at.q.conjugate() * y.w,
                   w_k = w.at.q.conjugate() * w.w;
    const Vector3d torque = w.at.q.conjugate() * load[at(i)].moment;
    const Vector3d known = J * (w_y - w_x) - s.h * torque - w.at.q.conjugate() * sums[at(i)].angular;
    Vector3d angular = known + s.h * w_k.cross(J * w_k);
    if (!end &&
        b.kind ==
            Kind::Spatial) {  // lcp: the gyroscopic moment of the free end; once it was that of the start
      const Vector3d w_f = free_end(J, w_x, torque, s.h);
      const Vector3d other = known + s.h * w_f.cross(J * w_f);
      if (s.angular_speed(i, other) < s.angular_speed(i, angular)) angular = other;
    }
    if (b.kind == Kind::Planar) angular = angular.z() * Vector3d::UnitZ();
    const double turn_size = sums[at(i)].angular_size + s.angular_speed(i, J * w_x) +
                             s.angular_speed(i, J * w_y) +
                             s.h * s.angular_speed(i, w.at.q.conjugate() * load[at(i)].moment);
    s.fault("momentum", b.name + " turning", s.angular_speed(i, angular),
            s.allowed(s.speed_of(i), turn_size));
    worst = std::max(worst, angular.cwiseAbs().maxCoeff());
    rounding = std::max(rounding, s.marks.rounding * turn_size * std::sqrt(J.trace() * b.mass));
  }
  const double said = s.row.of.at("res_newton_euler");
  if (!std::isnan(said)) s.fault("says-newton_euler", "", worst, 4 * said + 4 * rounding);
}

}  // namespace checker
