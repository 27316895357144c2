// Recipes of bodies that touch: on planes, in piles, inside round walls, boxes on boxes.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "maker.hpp"

namespace checker {

void tilt(Maker& m, Contact& c) {
  if (m.random.chance(0.5)) return;
  Vector3d n = m.up() + m.any(0.6);
  c.size["normal"] = entries(n);
  if (m.random.chance(0.5)) c.size["point"] = entries(m.any(m.L));
}

void add_spring(Maker& m, int a, int b) {
  Random& r = m.random;
  double lightest = std::numeric_limits<double>::infinity();
  for (const int i : {a, b})
    if (m.at(i).moves()) lightest = std::min(lightest, m.at(i).mass);
  Spring s;
  s.a = a;
  s.b = b;
  for (auto [i, point] : {std::pair(a, &s.point_a), std::pair(b, &s.point_b)})
    if (m.at(i).turns()) *point = m.any(0.3 * m.L);
  if (a == 0) s.point_a = m.any(2 * m.L);
  s.stiffness = lightest / (m.T * m.T) * r.decades(-1, r.chance(0.05) ? 5 : 1);
  if (r.chance(0.5)) s.damping = lightest / m.T * r.decades(-2, 0);
  const State x = first_state(m.scene);
  const double now = (x.bodies[static_cast<std::size_t>(b)].at * s.point_b -
                      x.bodies[static_cast<std::size_t>(a)].at * s.point_a)
                         .norm();
  s.length = r.chance(0.3) ? 0 : now * r.uniform(0.5, 1.5);
  m.scene.springs.push_back(s);
}

void add_force(Maker& m, int b) {
  Random& r = m.random;
  Force f;
  f.body = b;
  const double size = m.at(b).mass * 9.81, drag = m.at(b).mass / m.T;
  const char* names[] = {"vx", "vy", "vz"};
  for (int i = 0; i < (m.plane ? 2 : 3); ++i)
    f.force[i] = digits(size * r.uniform(-0.5, 0.5)) + "*sin(" + digits(r.uniform(0.5, 3) / m.T) + "*t) - " +
                 digits(drag * r.uniform(0, 0.5)) + "*" + names[i];
  m.scene.forces.push_back(f);
}

void add_extras(Maker& m, int b) {
  if (m.random.chance(0.12)) add_spring(m, 0, b);
  if (m.random.chance(0.12)) add_force(m, b);
}

namespace {

/// One body of one of the shapes that a plane can carry, above it; the name of the gap's kind.
int on_plane(Maker& m, int floor, const std::string& gap, bool launch = true) {
  Random& r = m.random;
  const Vector3d above = m.any(2 * m.L) + 2 * m.L * m.up();
  int b = 0;
  bool rolls = true;
  const double s = m.size();
  if (gap == "sphere_on_plane") {
    b = m.body(r.chance(0.5) ? "solid_sphere" : "hollow_sphere", {s}, above, r.turn());
    m.contact(gap, floor, b).size["radius"] = {s};
  } else if (gap == "capsule_on_plane") {
    const double length = s * r.uniform(0.5, 3);
    const bool lies = r.chance(0.5);
    const Quaterniond down(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()));
    b = m.body("cylinder", {s, length}, above, lies ? down : r.turn());
    Contact& c = m.contact(gap, floor, b);
    c.size = {{"radius", {s}}, {"length", {length}}};
    rolls = !lies;
  } else if (gap == "box_on_plane") {
    const Vector3d edges(s, s * r.uniform(0.3, 2), s * r.uniform(0.3, 2));
    const bool flat = r.chance(0.6);
    const Quaterniond about(Eigen::AngleAxisd(r.uniform(-3, 3), Vector3d::UnitZ()));
    b = m.body("box", entries(edges), above, flat ? about : r.turn());
    m.contact(gap, floor, b).size["size"] = entries(edges);
    rolls = !flat;
    if (!flat) tilt(m, m.scene.contacts.back());
  } else if (gap == "ellipsoid_on_plane") {
    const Vector3d axes(s, s * r.uniform(0.5, 1.5), s * r.uniform(0.5, 1.5));
    b = m.body("ellipsoid", entries(axes), above, r.turn());
    m.contact(gap, floor, b).size["semi_axes"] = entries(axes);
    if (r.chance(0.2)) m.scene.contacts.back().size["centre"] = entries(0.2 * s * r.direction());
  } else if (gap == "disc_on_plane") {
    b = m.body("cylinder", {s, 0.05 * s}, above,
               Quaterniond(Eigen::AngleAxisd(r.uniform(0.3, 1.5), Vector3d::UnitX())));
    m.contact(gap, floor, b).size["radius"] = {s};
  } else if (gap == "point_on_plane") {
    b = m.body("box", {s, s, 2 * s}, above, r.turn());
    m.contact(gap, floor, b).size["foot"] = entries(s * r.direction());
  } else {
    b = m.particle(above);
    m.contact("particle_on_plane", floor, b);
  }
  Contact& c = m.scene.contacts.back();
  if (rolls && gap != "disc_on_plane" && gap != "box_on_plane") tilt(m, c);
  if (r.chance(0.1) && gap == "sphere_on_plane") {
    c.placed = true;
    c.place_b.p = 0.3 * s * r.direction();
  }
  if (launch) m.launch(rolls);
  return b;
}

const std::vector<std::string> on_plane_kinds = {"sphere_on_plane",    "capsule_on_plane", "box_on_plane",
                                                 "ellipsoid_on_plane", "disc_on_plane",    "point_on_plane",
                                                 "particle_on_plane"};

}  // namespace

void make_on_plane(Maker& m) {
  const int count = 1 + m.random.below(2), floor = m.floor();
  for (int i = 0; i < count; ++i) add_extras(m, on_plane(m, floor, m.random.one_of(on_plane_kinds)));
  if (count == 2 && m.random.chance(0.3)) {
    const int last = static_cast<int>(m.scene.bodies.size()) - 1;
    add_spring(m, last - 1, last);
  }
}

/// Spheres on a floor and on each other; each touches one below it, or is about to, and keeps clear of the others.
void make_pile(Maker& m) {
  Random& r = m.random;
  const int floor = m.floor(), count = 2 + r.below(3);
  std::vector<int> spheres;
  std::vector<double> radii;
  for (int i = 0; i < count; ++i) {
    const double s = m.size();
    const int under = i == 0 ? -1 : r.below(i);
    Vector3d place = m.any(m.L) + 2 * m.L * m.up();
    if (under >= 0)
      place = m.at(spheres[static_cast<std::size_t>(under)]).rest.p +
              (s + radii[static_cast<std::size_t>(under)]) * (m.up() + m.any(0.8)).normalized();
    const int b = m.body("solid_sphere", {s}, place, r.turn());
    if (under < 0) {
      m.contact("sphere_on_plane", floor, b).size["radius"] = {s};
    } else {
      m.contact("sphere_on_sphere", spheres[static_cast<std::size_t>(under)], b).size = {
          {"radius_a", {radii[static_cast<std::size_t>(under)]}}, {"radius_b", {s}}};
    }
    m.launch(true);
    spheres.push_back(b);
    radii.push_back(s);
  }
  // contacts of the pairs that do not touch yet, where they are apart
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < i; ++j) {
      const auto a = static_cast<std::size_t>(j), b = static_cast<std::size_t>(i);
      const bool known = std::any_of(m.scene.contacts.begin(), m.scene.contacts.end(), [&](const Contact& c) {
        return c.a == spheres[a] && c.b == spheres[b];
      });
      if (known) continue;
      if ((m.at(spheres[a]).rest.p - m.at(spheres[b]).rest.p).norm() <= 1.0001 * (radii[a] + radii[b]))
        continue;
      m.contact("sphere_on_sphere", spheres[a], spheres[b]).size = {{"radius_a", {radii[a]}},
                                                                    {"radius_b", {radii[b]}}};
    }
}

void make_inside(Maker& m) {
  Random& r = m.random;
  const double big = m.size(), s = big * r.uniform(0.2, 0.7);
  const int wall = r.chance(0.6) ? 0 : m.prescribed(Vector3d::Zero());
  const bool tube = r.chance(0.5);
  const Vector3d axis = (Vector3d::UnitX() + 0.3 * r.direction()).normalized();
  Vector3d down = -m.up() + 0.5 * r.direction();
  if (tube) down -= down.dot(axis) * axis;
  const int b = m.body("solid_sphere", {s}, (big - s) * down.normalized(), r.turn());
  Contact& c = m.contact(tube ? "sphere_in_cylinder" : "sphere_in_sphere", wall, b);
  c.size = {{"radius_a", {big}}, {"radius_b", {s}}};
  if (tube) c.size["axis"] = entries(axis);
  m.launch(true);
  add_extras(m, b);
}

/// Boxes face to face, each within the one below; or a sphere on a box, at a face, an edge or a corner.
void make_boxes(Maker& m) {
  Random& r = m.random;
  const int floor = m.floor();
  const int count = 1 + r.below(2);
  double s = 2 * m.size();
  int below = floor;
  Vector3d under(s, s * r.uniform(0.7, 1.2), s * r.uniform(0.2, 0.6));
  const bool moving_bottom = r.chance(0.5);
  for (int i = 0; i < count; ++i) {
    Vector3d edges = under;
    if (i > 0) edges = Vector3d(0.45 * under.x(), 0.45 * under.y(), s * r.uniform(0.2, 0.6));
    const Vector3d place = i == 0 ? Vector3d(m.any(m.L) + 2 * m.L * m.up())
                                  : Vector3d(m.at(below).rest.p + 0.5 * (under.z() + edges.z()) * m.up());
    const Quaterniond about(Eigen::AngleAxisd(i == 0 ? 0 : r.uniform(-0.5, 0.5), Vector3d::UnitZ()));
    const int b = m.body("box", entries(edges), place, about);
    if (i == 0) {
      m.contact("box_on_plane", floor, b).size["size"] = entries(edges);
      if (moving_bottom)
        m.launch(false);
      else
        m.settle(0);
      m.at(b).w.setZero();
    } else {
      m.contact("box_on_box", below, b).size = {{"size_a", entries(under)}, {"size_b", entries(edges)}};
      m.settle(0);
      m.at(b).v = m.at(below).v;
      Vector3d slip = r.chance(0.4) ? Vector3d::Zero() : m.any(0.3 * m.V);
      m.at(b).v += slip - slip.dot(m.up()) * m.up();
      if (r.chance(0.4)) {
        const double approach = m.V * r.decades(-1.3, -0.3);
        m.at(b).v -= approach * m.up();
        m.settle(approach * m.h * r.uniform(0, 0.8 * m.steps));
      }
    }
    below = b;
    under = edges;
  }
  if (!r.chance(0.6)) return;
  const double radius = m.size() * 0.5;
  const Vector3d from = r.chance(0.5) ? Vector3d(m.up() + m.any(0.3)) : Vector3d(m.up() + m.any(1.5));
  const int ball = m.body("solid_sphere", {radius},
                          m.at(below).rest.p + (under.norm() + radius) * from.normalized(), r.turn());
  m.contact("sphere_on_box", below, ball).size = {{"radius", {radius}}, {"size", entries(under)}};
  m.launch(true);
}

}  // namespace checker
