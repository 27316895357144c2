// Rows of `event`: the law of each contact at the row's end, forces and accelerations together; momentum; jumps; energy.
#include <cmath>

#include "energy.hpp"

namespace checker {
namespace {

bool jointed(const Step& s, int island) {
  for (const Joint& j : s.scene.joints)
    for (const int body : {j.a, j.b})
      if (s.island[at(body)] >= 0 && s.island[at(body)] == island) return true;
  return false;
}

/// Loads that are the same throughout a row: the weight alone.
bool weight_alone(const Scene& scene, int body) {
  for (const Spring& s : scene.springs)
    if (s.a == body || s.b == body) return false;
  for (const Force& f : scene.forces)
    if (f.body == body) return false;
  return true;
}

/// A speed that is nothing beside those that weights give over the scene's lengths.
double nothing(const Step& s) {
  double farthest = 0;
  for (const BodyState& b : s.y.bodies) farthest = std::max(farthest, b.at.p.norm());
  return 1e-12 * std::sqrt(9.81 * farthest);
}

double size_of(const Body& b) { return b.turns() ? std::sqrt(b.inertia().trace() / b.mass) : 0; }

double size_of(const Step& s, const Touch& c) {
  double size = c.point.norm();
  for (const int i : {c.a, c.b})
    if (s.scene.bodies[at(i)].moves()) size = std::max(size, size_of(s.scene.bodies[at(i)]));
  return size;
}

/// Impulses of the row against the change of momentum, of bodies without joints.
void judge_momentum(Step& s) {
  const bool jump = s.h == 0;
  constexpr double most = 1e-5;     // of speeds: what may be brought to zero
  constexpr double by_rule = 1e-6;  // of speeds: impulses of a row are integrals of forces by a rule
  const double said = s.row.of.at("res_newton_euler");
  const std::vector<Sum> sums = reactions(s, s.y, s.at_y, s.joints_y);
  for (int i = 1; i < static_cast<int>(s.scene.bodies.size()); ++i) {
    const Body& b = s.scene.bodies[at(i)];
    if (!b.moves() || jointed(s, s.island[at(i)])) continue;
    const BodyState &x = s.x.bodies[at(i)], &y = s.y.bodies[at(i)];
    // what still slid or opened is brought to zero, what closes does so to the tolerance, impulses of a row are integrals: as little as the
    // row says
    const auto dropped = [&](double speed) {
      return std::min(2 * speed, most * s.speed_of(i) + (jump ? 1e4 * nothing(s) : 0));
    };
    const double limit =
        (jump ? s.allowed(s.speed_of(i), sums[at(i)].linear_size) : by_rule * s.speed_of(i)) +
        s.place_rounding() + dropped(said / b.mass) + 1e-3 * nothing(s);
    if (jump || weight_alone(s.scene, i)) {
      Vector3d left = b.mass * (y.v - x.v - s.h * s.scene.gravity) - sums[at(i)].linear;
      if (b.kind == Kind::Planar) left.z() = 0;
      s.fault("momentum", b.name, s.linear_speed(i, left), limit);
    }
    if (!jump || !b.turns()) continue;
    const Vector3d turned = b.inertia() * (y.at.q.conjugate() * y.w - x.at.q.conjugate() * x.w) -
                            y.at.q.conjugate() * sums[at(i)].angular;
    const Vector3d left = b.kind == Kind::Planar ? Vector3d(turned.z() * Vector3d::UnitZ()) : turned;
    s.fault("momentum", b.name + " turning", s.angular_speed(i, left),
            s.allowed(s.speed_of(i), sums[at(i)].angular_size) +
                dropped(s.angular_speed(i, Vector3d::Constant(said))) + 1e-3 * nothing(s));
  }
}

/// Accelerations that the row's forces give, of bodies without joints; others stay as they are.
std::vector<Wrench> accelerations(const Step& s) {
  std::vector<Wrench> all = loads(s.scene, s.y, s.values_y);
  for (const ContactRow& c : s.contacts) {
    const Touch* t = s.touch(s.at_y, c.contact);
    if (t == nullptr || t->turns || !c.f.allFinite()) continue;
    for (const auto& [body, sign] : {std::pair(t->a, -1.0), std::pair(t->b, 1.0)}) {
      all[at(body)].force += sign * c.f;
      all[at(body)].moment += sign * (t->point - s.y.bodies[at(body)].at.p).cross(c.f);
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Body& b = s.scene.bodies[i];
    if (!b.moves()) continue;
    const BodyState& y = s.y.bodies[i];
    all[i].force /= b.mass;
    if (b.kind == Kind::Planar) {
      all[i].force.z() = 0;
      all[i].moment = all[i].moment.z() / b.size[0] * Vector3d::UnitZ();
    } else if (b.kind == Kind::Spatial) {
      const Matrix3d J = b.inertia();
      const Vector3d w = y.at.q.conjugate() * y.w;
      all[i].moment = y.at.q * (J.inverse() * (y.at.q.conjugate() * all[i].moment - w.cross(J * w)));
    } else {
      all[i].moment.setZero();
    }
  }
  return all;
}

/// The second derivative of a closed contact's gap, by a second difference of places.
void judge_accelerations(Step& s) {
  const std::vector<Wrench> a = accelerations(s);
  double fastest = 0;
  for (const ContactRow& c : s.contacts) {
    const Touch* t = s.touch(s.at_y, c.contact);
    if (t == nullptr || t->stop || !(c.f.norm() > 0) || s.row.solver == "inelastic-step") continue;
    const int island = std::max(s.island[at(t->a)], s.island[at(t->b)]);
    if (island < 0 || jointed(s, island)) continue;
    double size = std::numeric_limits<double>::infinity(), scale = s.scene.gravity.norm();
    for (const int i : {t->a, t->b}) {
      if (!s.scene.bodies[at(i)].moves()) continue;
      const double arm = (t->point - s.y.bodies[at(i)].at.p).norm();
      size = std::min(size, std::max(arm, size_of(s.scene.bodies[at(i)])));
      scale = std::max(scale, a[at(i)].force.norm() + arm * a[at(i)].moment.norm());
    }
    for (const BodyState& b : s.y.bodies) fastest = std::max({fastest, b.v.norm(), b.w.norm() * size});
    const double d =
        1e-3 * std::min(std::sqrt(size / scale), fastest > 0 ? size / fastest : std::sqrt(size / scale));
    double gap[2];
    for (const int side : {0, 1}) {
      State by = s.y;
      const double step = side == 0 ? -d : d;
      for (std::size_t i = 0; i < by.bodies.size(); ++i) {
        by.bodies[i].v += 0.5 * step * a[i].force;
        by.bodies[i].w += 0.5 * step * a[i].moment;
      }
      gap[side] = s.touch(touches(s.scene, moved(s.scene, s.y, by, step), s.values_y), c.contact)->gap;
    }
    const double second = (gap[1] - 2 * t->gap + gap[0]) / (d * d);
    const double rounding = 8 * std::numeric_limits<double>::epsilon() * size_of(s, *t) / (d * d);
    s.fault("acceleration", c.contact, std::abs(second), 1e-5 * scale + rounding);
  }
}

/// A step across poses all of its laws where it began: velocities at the end of bodies where they were.
bool carried(const Step& s) { return s.row.solver == "inelastic-step"; }

/// The contact's relative velocity at the end of the row.
Vector3d velocity_at_end(const Step& s, const Touch& t) {
  if (!carried(s)) return relative_velocity(s.scene, s.y, t);
  State back = s.x;
  for (std::size_t i = 0; i < s.x.bodies.size(); ++i) {
    if (!s.scene.bodies[i].moves()) continue;
    back.bodies[i].v = s.y.bodies[i].v;
    back.bodies[i].w = s.x.bodies[i].at.q * (s.y.bodies[i].at.q.conjugate() * s.y.bodies[i].w);
  }
  return relative_velocity(s.scene, back, t);
}

/// Whether an impact's normal velocities are not those of Newton's law, with e or without, at a contact that pushes: then it is Poisson's, whose
/// friction belongs to two phases and need not be against the slip that is left.
bool by_poisson(const Step& s) {
  constexpr double near = 1e-6;
  for (const ContactRow& c : s.contacts) {
    const Touch *t = s.touch(s.at_y, c.contact), *x = s.touch(s.at_x, c.contact);
    if (t == nullptr || x == nullptr || c.p.isZero(0)) continue;
    const double after = t->normal.dot(relative_velocity(s.scene, s.y, *t));
    const double before = std::min(0.0, x->normal.dot(relative_velocity(s.scene, s.x, *x)));
    const double small = near * s.speed_of(*t) + nothing(s);
    if (std::abs(after + t->e * before) > small && std::abs(after) > small) return true;
  }
  return false;
}

void judge_contact(Step& s, const ContactRow& c, Touch t) {
  const bool across = carried(s);
  const double gap_at_end = t.gap;
  if (across) t = *s.touch(s.at_x, c.contact);
  constexpr double near = 1e-6;
  const bool jump = s.h == 0 && !(c.f.norm() > 0);
  s.fault("normal", c.contact + " gap", std::abs(c.gap - gap_at_end), 1e-9 * (t.turns ? 1 : size_of(s, t)));
  const Vector3d force = jump ? c.p : c.f;
  if (!force.allFinite() || force.isZero(0)) return;
  const double n = t.normal.dot(force);
  const Vector3d f = force - n * t.normal;
  double size = force.norm(), weight = 0;  // what is nearly nothing beside weights is noise
  for (const int i : {t.a, t.b})
    if (s.scene.bodies[at(i)].moves())
      weight = std::max(weight, s.scene.bodies[at(i)].mass * s.scene.gravity.norm());
  if (!jump) size = std::max(size, weight);
  s.fault("normal", c.contact + " normal direction", (c.normal - t.normal).norm(), 1e-9);
  s.fault("normal", c.contact + " pulls", -n, near * size);
  s.fault("cone", c.contact, f.norm() - t.mu * std::max(n, 0.0), near * size);
  const Vector3d u = velocity_at_end(s, t);
  const double along = t.normal.dot(u), speed = s.speed_of(t);
  const double un = along + (across ? std::max(t.gap, 0.0) / s.h : 0);
  const Vector3d u_t = u - along * t.normal;
  if (!t.turns)
    s.fault("normal", c.contact + (jump ? " goes on" : " leaves"), jump ? -un : std::abs(un),
            (jump ? near : 0.1 * near) * speed + nothing(s));
  // what comes to rest keeps to a line, whatever its last direction
  if (t.stop || u_t.norm() < std::max(1e-3 * speed, 1e6 * nothing(s))) return;
  if (!jump && n < near * weight) return;
  if (jump && by_poisson(s)) return;  // in its cone, and energy tells the rest
  s.fault("friction", c.contact, (f + t.mu * n * u_t.normalized()).norm(), 1e-5 * size);
}

}  // namespace

void judge_event(Step& s, const Run& run, double tolerance) {
  (void)run;
  for (const Touch& t : s.at_y) {
    const double size = t.turns ? 1 : size_of(s, t);
    s.fault("normal", t.name + " overlaps", -t.gap,
            std::max(1e-6 * size, 1e2 * tolerance * size) + std::max(0.0, -s.touch(s.at_x, t.name)->gap));
  }
  for (const ContactRow& c : s.contacts)
    if (const Touch* t = s.touch(s.at_y, c.contact); t != nullptr) judge_contact(s, c, *t);
  for (std::size_t j = 0; j < s.joints_y.size(); ++j)
    for (const JointRow& row : s.joints_y[j].rows) {
      const double size = row.angle ? 1 : s.joints_y[j].anchor.norm();
      s.fault("joints", s.scene.joints[j].name, std::abs(row.psi), 1e-6 * size);
    }
  judge_momentum(s);
  if (s.h > 0) judge_accelerations(s);
  bool driven = !s.scene.forces.empty() || !s.scene.motors.empty();
  for (std::size_t i = 1; i < s.scene.bodies.size(); ++i)
    driven = driven || !s.scene.bodies[i].motion.kind.empty();
  if (driven) return;
  const Gain g =
      gain_of(s);  // dampers only take: without them, as a rule for two ends is not exact over a long row
  s.fault("energy", "", g.gain + g.loads, 1e-6 * g.size + g.rounding);
}

}  // namespace checker
