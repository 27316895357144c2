// The laws of contacts and of dry friction in joints, where each method poses them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "judge.hpp"

namespace checker {
namespace {

struct Parts {
  double n;
  Vector3d t;
};
Parts parts(const Vector3d& p, const Vector3d& normal) {
  const double n = normal.dot(p);
  return {n, p - n * normal};
}

/// How far friction is from dissipating most in the circle of radius mu p_n, as a speed.
double circle_error(const Vector3d& p_t, const Vector3d& u_t, double bound, double mobility) {
  Vector3d z = p_t - u_t / mobility;
  if (z.norm() > bound) z *= bound / z.norm();
  return mobility * (p_t - z).norm();
}

/// The same in the polygon with a corner along t: what it leaves undissipated, as a speed, or as an impulse along the slip.
double polygon_error(const Vector3d& p_t, const Vector3d& u_t, double bound, const Matrix3d& frame, int edges,
                     double mobility) {
  double most = 0;
  for (int k = 0; k < edges; ++k) {
    const double angle = 2 * std::numbers::pi * k / edges;
    most = std::max(most, -u_t.dot(std::cos(angle) * frame.col(1) + std::sin(angle) * frame.col(2)));
  }
  const double left = std::abs(bound * most + p_t.dot(u_t));
  return left == 0 ? 0 : std::min(left / bound, mobility * left / u_t.norm());
}

/// How far friction is outside the polygon, whose edges stand across the directions half way between its corners.
double outside_polygon(const Vector3d& p_t, double bound, const Matrix3d& frame, int edges) {
  double most = 0;
  for (int k = 0; k < edges; ++k) {
    const double angle = std::numbers::pi * (2 * k + 1) / edges;
    const Vector3d across = std::cos(angle) * frame.col(1) + std::sin(angle) * frame.col(2);
    most = std::max(most, p_t.dot(across) - bound * std::cos(std::numbers::pi / edges));
  }
  return most;
}

/// Whether the contact's bodies stay in the xy plane.
bool in_plane(const Step& s, const Touch& c) {
  return s.scene.bodies[at(c.a)].kind == Kind::Planar || s.scene.bodies[at(c.b)].kind == Kind::Planar;
}

/// The axes of a friction polygon, as doc/notation.md has them.
Matrix3d polygon_axes(const Step& s, const Touch& c) {
  Vector3d wish = s.scene.contacts[at(c.contact)].tangent;
  if (in_plane(s, c)) wish = c.normal.cross(Vector3d::UnitZ());
  if ((wish - c.normal.dot(wish) * c.normal).squaredNorm() <= 1e-12 * wish.squaredNorm())
    wish = std::abs(c.normal.x()) > 0.9 ? Vector3d::UnitY() : Vector3d::UnitX();
  Matrix3d frame;
  frame.col(0) = c.normal;
  frame.col(1) = (wish - c.normal.dot(wish) * c.normal).normalized();
  frame.col(2) = c.normal.cross(frame.col(1));
  return frame;
}

/// What every contact's row must hold to, wherever the step poses its law.
void judge_row(Step& s, const ContactRow& c, const Touch& where, double turned) {
  const Matrix3d G = s.mobility(where, s.x);
  const double w = G.trace() / 3, size = w * c.p.norm();
  const double limit = s.allowed(s.speed_of(where), size) + turned * size * 2;
  const Parts p = parts(c.p, where.normal);
  s.fault("normal", c.contact + " normal direction", (c.normal - where.normal).norm(), 1e-9 + 2 * turned);
  s.fault("normal", c.contact + " pn", w * std::abs(p.n - c.p_n), limit);
  s.fault("normal", c.contact + " pulls", -w * p.n, limit);
  s.fault("cone", c.contact, w * (p.t.norm() - where.mu * std::max(p.n, 0.0)), limit);
  if (where.stop) s.fault("cone", c.contact, w * p.t.norm(), limit);
}

void judge_gap_row(Step& s, const ContactRow& c) {
  const Touch* t = s.touch(s.at_y, c.contact);
  if (t == nullptr || std::isnan(c.gap)) return;
  const double size = t->turns ? 1 : t->point.norm() + std::abs(t->gap);
  s.fault("normal", c.contact + " gap", std::abs(t->gap - c.gap), 1e-11 * size + 1e-9 * std::abs(t->gap));
}

/// A length that makes a speed of what turns: 1 of what does not.
double turning_length(const Step& s, const Touch& c) {
  if (!c.turns) return 1;
  double size = std::numeric_limits<double>::infinity();
  for (const int i : {c.a, c.b}) {
    const Body& b = s.scene.bodies[at(i)];
    if (b.turns()) size = std::min(size, std::sqrt(b.inertia().trace() / b.mass));
  }
  return size;
}

struct NormalLaw {
  const Touch& start;  // the contact as the step found it
  const Touch& posed;  // where its law is posed
  double slack;        // complementary to p_n where velocities move the bodies [m/s]
  double after;        // normal velocity at the end
};

/// 0 <= slack, complementary to p_n; where an impact's velocities are not those that moved the bodies, u_n+ + e u_n- in its place.
void judge_normal(Step& s, const NormalLaw& law, const ContactRow* row) {
  const Touch& c = law.start;
  const double length = turning_length(s, c), w = s.mobility(law.posed, s.x).trace() / 3;
  const double p = row == nullptr ? 0 : w * row->p_n * length;
  const double rounding = c.turns ? s.marks.rounding * 4 * length / s.h : 2 * s.place_rounding();
  const double limit = s.allowed(s.speed_of(c), p) + rounding;
  s.fault("normal", c.name + " overlaps", -law.slack * length,
          limit + 1e-8 * std::max(0.0, -c.gap) * length / s.h);
  if (!(p > limit)) return;
  const auto island = at(std::max(s.island[at(c.a)], s.island[at(c.b)]));
  const double apart = std::min(law.slack * length, p);
  const bool impact = s.follows[island] == 0 && s.struck[island] != 0;
  // moved onto the joints too, velocities do not tell whether there was an impact
  if (!impact || (s.projected() && apart <= limit)) {
    s.fault("normal", c.name + " acts at a distance", apart, limit);
    return;
  }
  // Newton's law; where it would add energy Moreau's, then e = 0
  const double before = c.normal.dot(relative_velocity(s.scene, s.x, c));
  double error = std::numeric_limits<double>::infinity();
  for (const double u : {std::min(before, 0.0), before, 0.0}) {
    const double free = (law.after + c.e * u) * length;
    error = std::min(error, free < 0 ? -free : std::min(free, p));
  }
  s.fault("normal", c.name + " rebounds", error, 4 * limit);
}

const ContactRow* row_of(const Step& s, const std::string& name, int half = 0) {
  for (const ContactRow& r : s.contacts)
    if (r.contact == name && r.half == half) return &r;
  return nullptr;
}

void judge_lcp(Step& s) {
  State by_u = s.x, by_y = s.x;  // at q, with the velocities that moved the bodies, with those at the end
  for (std::size_t i = 0; i < s.x.bodies.size(); ++i) {
    if (!s.scene.bodies[i].moves()) continue;
    by_u.bodies[i].v = s.u.bodies[i].v;
    by_u.bodies[i].w = s.u.bodies[i].w;
    by_y.bodies[i].v = s.y.bodies[i].v;
    by_y.bodies[i].w = s.x.bodies[i].at.q * (s.y.bodies[i].at.q.conjugate() * s.y.bodies[i].w);
  }
  for (const Touch& c : s.at_x) {
    const ContactRow* row = row_of(s, c.name);
    double slack = c.gap / s.h + c.normal.dot(relative_velocity(s.scene, by_u, c));
    const Vector3d u = relative_velocity(s.scene, by_y, c);
    if (s.projected()) {  // then q+ is not where the velocities led
      const double by_end = c.gap / s.h + c.normal.dot(u), p = row == nullptr ? 0 : row->p_n;
      const double w = s.mobility(c, s.x).trace() / 3;
      const auto error = [&](double x) { return std::abs(std::min(x, w * p)); };
      if (error(by_end) < error(slack)) slack = by_end;
    }
    judge_normal(s, {c, c, slack, c.normal.dot(u)}, row);
    if (row == nullptr) continue;
    judge_row(s, *row, c, 0);
    judge_gap_row(s, *row);
    const Parts p = parts(row->p, c.normal);
    if (!(p.n > 0) || c.stop || !(c.mu > 0)) continue;
    const double w = s.mobility(c, s.x).trace() / 3;
    const Vector3d u_t = u - c.normal.dot(u) * c.normal;
    const Matrix3d axes = polygon_axes(s, c);
    const int edges = in_plane(s, c) ? 2 : 8;
    const double error = polygon_error(p.t, u_t, c.mu * p.n, axes, edges, w);
    s.fault("cone", c.name + " polygon", w * outside_polygon(p.t, c.mu * p.n, axes, edges),
            s.allowed(s.speed_of(c), w * row->p.norm()));
    s.fault("friction", c.name, error, 4 * s.allowed(s.speed_of(c), w * row->p.norm() + u_t.norm()));
  }
}

void judge_ncp(Step& s) {
  for (const Touch& c : s.at_y) {
    const ContactRow* row = row_of(s, c.name);
    const Vector3d u = relative_velocity(s.scene, s.y, c);
    judge_normal(s, {*s.touch(s.at_x, c.name), c, c.gap / s.h, c.normal.dot(u)}, row);
    if (row == nullptr) continue;
    judge_row(s, *row, c, 0);
    judge_gap_row(s, *row);
    const Parts p = parts(row->p, c.normal);
    if (!(p.n > 0) || c.stop || !(c.mu > 0)) continue;
    const double w = s.mobility(c, s.y).trace() / 3;
    const Vector3d u_t = u - c.normal.dot(u) * c.normal;
    s.fault("friction", c.name, circle_error(p.t, u_t, c.mu * p.n, w),
            2 * s.allowed(s.speed_of(c), w * row->p.norm() + u_t.norm()));
  }
}

/// Friction of both halves of a contact whose normal stays: the first against the slip at the middle; the second against that too, or
/// against the slip at the end where it would have turned that round, stuck or arrived.
void judge_halves_friction(Step& s, const Touch& c, const Vector3d& u_half, const Vector3d& u_end) {
  const double w = s.mobility(c, s.y).trace() / 3;
  const auto along = [&](const Vector3d& u) { return Vector3d(u - c.normal.dot(u) * c.normal); };
  const Vector3d u_t = along(u_half), v_t = along(u_end);
  for (const int half : {1, 2}) {
    const ContactRow* row = row_of(s, c.name, half);
    if (row == nullptr || row->p.isZero(0)) continue;
    const Parts p = parts(row->p, c.normal);
    const double bound = c.mu * std::max(p.n, 0.0);
    double error = circle_error(p.t, half == 1 ? u_t : v_t, bound, w);
    if (half == 2 && u_t.norm() > 0) error = std::min(error, w * (p.t + bound * u_t.normalized()).norm());
    s.fault("friction", c.name + " half " + std::to_string(half), error,
            4 * s.allowed(s.speed_of(c), w * row->p.norm() + u_t.norm()) + s.place_rounding());
  }
}

/// Each half within its own cone, the sum as far as its normal does not turn; friction where that stays.
void judge_ncp2(Step& s) {
  State half = s.x, half_y = s.y;
  for (std::size_t i = 0; i < s.x.bodies.size(); ++i) {
    if (!s.scene.bodies[i].moves()) continue;
    for (State* into : {&half, &half_y}) {
      into->bodies[i].v = s.u.bodies[i].v;
      into->bodies[i].w = s.u.bodies[i].w;  // turning about a fixed axis: the same in world axes all along
    }
  }
  for (const Touch& c : s.at_y) {
    const ContactRow* row = row_of(s, c.name);
    const Touch& before = *s.touch(s.at_x, c.name);
    const Vector3d u = relative_velocity(s.scene, s.y, c);
    judge_normal(s, {before, c, c.gap / s.h, c.normal.dot(u)}, row);
    if (row == nullptr) continue;
    const double turned = (c.normal - before.normal).norm();
    judge_row(s, *row, c, turned);
    judge_gap_row(s, *row);
    for (const int k : {1, 2})
      if (const ContactRow* part = row_of(s, c.name, k); part != nullptr && !part->p.isZero(0))
        judge_row(s, *part, k == 1 ? before : c, 0);
    const Parts p = parts(row->p, c.normal);
    const double w = s.mobility(c, s.y).trace() / 3;
    const double limit = s.allowed(s.speed_of(c), w * row->p.norm());
    if (!(w * p.n > limit) || c.stop) continue;
    // the second stage leaves nothing that closed approaching; Moreau's law lets it where it came from the other side
    const double came = before.normal.dot(relative_velocity(s.scene, s.x, before));
    s.fault("normal", c.name + " approaches", -(c.normal.dot(u) + c.e * std::max(came, 0.0)),
            limit + 8 * s.marks.rounding * u.norm());
    if (!(c.mu > 0) || turned > 1e-12) continue;
    judge_halves_friction(
        s, c, 0.5 * (relative_velocity(s.scene, half, before) + relative_velocity(s.scene, half_y, c)), u);
  }
}

}  // namespace

void judge_contacts(Step& s) {
  if (s.method == "lcp") judge_lcp(s);
  if (s.method == "ncp") judge_ncp(s);
  if (s.method == "ncp2") judge_ncp2(s);
}

}  // namespace checker
