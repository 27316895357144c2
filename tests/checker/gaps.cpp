// Gaps between shapes, each from what doc/scene-files.md says of it. The impulse acts on the surface of b.
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mechanics.hpp"

namespace checker {
namespace {

struct Pair {
  const Contact& c;
  Place A, B;  // of the shapes
  bool plane;  // planar kinds: the default plane is y = 0

  double number(const char* key) const { return c.size.at(key)[0]; }
  Vector3d vector(const char* key, const Vector3d& otherwise) const {
    const auto found = c.size.find(key);
    if (found == c.size.end()) return otherwise;
    const auto& x = found->second;
    return {x[0], x[1], x.size() > 2 ? x[2] : 0};
  }
};

using Points = std::vector<Touch>;

void add(Points& out, double gap, const Vector3d& normal, const Vector3d& point) {
  Touch t;
  t.gap = gap;
  t.normal = normal;
  t.point = point;
  out.push_back(t);
}

/// A plane of a against balls of one radius about points fixed in b.
void balls_on_plane(const Pair& pair, const std::vector<Vector3d>& centres, double radius, Points& out) {
  const Vector3d up = pair.plane ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d n = pair.A.q * pair.vector("normal", up).normalized();
  const Vector3d foot = pair.A * pair.vector("point", Vector3d::Zero());
  for (const Vector3d& c : centres) {
    const Vector3d x = pair.B * c;
    add(out, n.dot(x - foot) - radius, n, x - radius * n);
  }
}

/// The lowest point of an ellipsoid over a plane, by Lagrange's rule: x = -D m/|sqrt(D) m|.
void ellipsoid_on_plane(const Pair& pair, const Vector3d& axes, const Vector3d& centre, Points& out) {
  const Vector3d up = pair.plane ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d n = pair.A.q * pair.vector("normal", up).normalized();
  const Vector3d foot = pair.A * pair.vector("point", Vector3d::Zero());
  const Vector3d m = pair.B.q.conjugate() * n;
  const double reach = axes.cwiseProduct(m).norm();
  Vector3d lowest = centre - axes.x() * Vector3d::UnitX();
  if (reach > 0) lowest = centre - axes.cwiseProduct(axes).cwiseProduct(m) / reach;
  add(out, n.dot(pair.B * centre - foot) - reach, n, pair.B * lowest);
}

/// Round things about a centre or an axis, from outside or from inside.
void round(const Pair& pair, double r_a, double r_b, bool inside, const Vector3d* axis,
           const Vector3d& through, Points& out) {
  Vector3d d = pair.B.p - pair.A * through;
  if (axis != nullptr) d -= axis->dot(d) * *axis;
  const double distance = d.norm();
  const Vector3d n = (inside ? -1 : 1) / distance * d;
  add(out, inside ? r_a - r_b - distance : distance - r_a - r_b, n, pair.B.p - r_b * n);
}

void sphere_on_box(const Pair& pair, Points& out) {
  const Vector3d half = 0.5 * pair.vector("size", Vector3d::Zero());
  const double r = pair.number("radius");
  const Vector3d c = pair.A.q.conjugate() * (pair.B.p - pair.A.p);
  Vector3d nearest = c;
  for (int i = 0; i < 3; ++i) nearest[i] = std::min(std::max(c[i], -half[i]), half[i]);
  double distance = (c - nearest).norm();
  Vector3d n = Vector3d::Zero();
  if (distance > 0) {
    n = (c - nearest) / distance;
  } else {
    int face = 0;
    distance = (c.cwiseAbs() - half).maxCoeff(&face);
    n[face] = c[face] < 0 ? -1 : 1;
  }
  n = pair.A.q * n;
  add(out, distance - r, n, pair.B.p - r * n);
}

/// A disc's rim: its lowest point; lying flatter than 30 degrees eight points fixed on it too, at odd eighths of half a turn.
void disc_on_plane(const Pair& pair, Points& out) {
  const double r = pair.number("radius");
  ellipsoid_on_plane(pair, {r, r, 0}, Vector3d::Zero(), out);
  const Vector3d n = out[0].normal;
  const Vector3d foot = pair.A * pair.vector("point", Vector3d::Zero());
  const bool flat = std::abs((pair.B.q * Vector3d::UnitZ()).dot(n)) >= std::cos(std::numbers::pi / 6);
  for (int k = 0; k < 8; ++k) {
    const double angle = (2 * k + 1) * std::numbers::pi / 8;
    const Vector3d x = pair.B * Vector3d(r * std::cos(angle), r * std::sin(angle), 0);
    add(out, flat ? n.dot(x - foot) : std::numeric_limits<double>::infinity(), n, x);
  }
}

/// b's bottom face within a's top face: its corners, half way to a. Whatever hangs over is not the checker's to judge.
void box_on_box(const Pair& pair, Points& out) {
  const Vector3d a = 0.5 * pair.vector("size_a", Vector3d::Zero()),
                 b = 0.5 * pair.vector("size_b", Vector3d::Zero());
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {-1, 1}, {1, 1}}) {
    const Vector3d corner = pair.B * Vector3d(x * b.x(), y * b.y(), -b.z());
    const Vector3d in_a = pair.A.q.conjugate() * (corner - pair.A.p);
    if (std::abs(in_a.x()) > a.x() || std::abs(in_a.y()) > a.y())
      throw std::runtime_error("the checker takes box_on_box only where b stands within a");
    const Vector3d n = pair.A.q * Vector3d::UnitZ();
    const double gap = in_a.z() - a.z();
    add(out, gap, n, corner - 0.5 * gap * n);
  }
}

std::vector<Vector3d> corners(const Vector3d& half, int count) {
  std::vector<Vector3d> all;
  for (int i = 0; i < count; ++i)
    all.emplace_back((i % 2 == 0 ? -1 : 1) * half.x(), (i / 2 % 2 == 0 ? -1 : 1) * half.y(),
                     (i / 4 == 0 ? -1 : 1) * half.z());
  return all;
}

void gaps(const Pair& pair, Points& out) {
  const std::string& kind = pair.c.gap;
  const Vector3d zero = Vector3d::Zero();
  if (kind == "sphere_on_plane" || kind == "disc_on_line")
    return balls_on_plane(pair, {zero}, pair.number("radius"), out);
  if (kind == "particle_on_plane") return balls_on_plane(pair, {zero}, 0, out);
  if (kind == "point_on_plane") return balls_on_plane(pair, {pair.vector("foot", zero)}, 0, out);
  if (kind == "capsule_on_plane") {
    const Vector3d end(0, 0, 0.5 * pair.number("length"));
    return balls_on_plane(pair, {-end, end}, pair.number("radius"), out);
  }
  if (kind == "box_on_plane")
    return balls_on_plane(pair, corners(0.5 * pair.vector("size", zero), 8), 0, out);
  if (kind == "box_on_line")
    return balls_on_plane(pair, corners({0.5 * pair.number("width"), 0.5 * pair.number("height"), 0}, 4), 0,
                          out);
  if (kind == "ellipsoid_on_plane")
    return ellipsoid_on_plane(pair, pair.vector("semi_axes", zero), pair.vector("centre", zero), out);
  if (kind == "ellipse_on_line")
    return ellipsoid_on_plane(pair, {pair.number("a"), pair.number("b"), 0}, zero, out);
  if (kind == "disc_on_plane") return disc_on_plane(pair, out);
  if (kind == "sphere_on_sphere" || kind == "sphere_in_sphere")
    return round(pair, pair.number("radius_a"), pair.number("radius_b"), kind == "sphere_in_sphere", nullptr,
                 zero, out);
  if (kind == "sphere_in_cylinder") {
    const Vector3d axis = pair.A.q * pair.vector("axis", Vector3d::UnitZ()).normalized();
    return round(pair, pair.number("radius_a"), pair.number("radius_b"), true, &axis,
                 pair.vector("point", zero), out);
  }
  const Vector3d z = Vector3d::UnitZ();
  if (kind == "disc_in_circle")
    return round(pair, pair.number("radius_circle"), pair.number("radius_disc"), true, &z, zero, out);
  if (kind == "particle_in_circle") return round(pair, pair.number("radius"), 0, true, &z, zero, out);
  if (kind == "sphere_on_box") return sphere_on_box(pair, out);
  if (kind == "box_on_box") return box_on_box(pair, out);
  throw std::runtime_error("the checker has no gap " + kind);
}

}  // namespace

std::vector<Touch> touches(const Scene& scene, const State& x, const std::vector<double>& values) {
  std::vector<Touch> all;
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const Contact& c = scene.contacts[i];
    const auto a = static_cast<std::size_t>(c.a), b = static_cast<std::size_t>(c.b);
    const bool plane = c.gap.find("_line") != std::string::npos;
    std::vector<Touch> points;
    gaps({c, x.bodies[a].at * c.place_a, x.bodies[b].at * c.place_b, plane}, points);
    const bool patch = points.size() > 1;
    for (std::size_t k = 0; k < points.size(); ++k) {
      Touch& t = points[k];
      t.name = patch ? c.name + "." + std::to_string(k) : c.name;
      t.contact = static_cast<int>(i);
      t.a = c.a;
      t.b = c.b;
      t.mu = c.mu;
      t.e = c.e;
      all.push_back(t);
    }
  }
  for (const Limit& l : scene.limits) {
    const Joint& joint = scene.joints[static_cast<std::size_t>(l.joint)];
    const std::size_t first = first_coordinate(scene, l.joint),
                      at = coordinate_index(scene, l.joint, l.coordinate);
    const JointState s = joint_state(scene, l.joint, x, values.data() + first);
    const JointRow& row = s.coordinates[at - first];
    for (const double side : {1.0, -1.0}) {
      const double limit = side > 0 ? l.lower : l.upper;
      if (std::isnan(limit)) continue;
      Touch t;
      const std::string of =
          coordinate_names(joint.kind).size() > 1 ? joint.name + "." + l.coordinate : joint.name;
      t.name = of + (side > 0 ? ".lower" : ".upper");
      t.contact = -1;
      t.a = joint.a;
      t.b = joint.b;
      t.gap = side * (row.psi - limit);
      t.stop = true;
      t.turns = row.angle;
      t.normal = side * (row.angle ? row.moment_b : row.force).normalized();
      t.point = s.anchor;
      t.e = l.e;
      all.push_back(t);
    }
  }
  return all;
}

Vector3d relative_velocity(const Scene& scene, const State& x, const Touch& c) {
  const auto a = static_cast<std::size_t>(c.a), b = static_cast<std::size_t>(c.b);
  if (c.turns) return x.bodies[b].w - x.bodies[a].w;
  Vector3d u = x.bodies[b].velocity_at(c.point) - x.bodies[a].velocity_at(c.point);
  if (c.stop) return u;
  Vector3d surface = surface_velocity(scene.bodies[b]) - surface_velocity(scene.bodies[a]);
  return u + surface - c.normal.dot(surface) * c.normal;
}

}  // namespace checker
