// The recipes of random scenes.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "maker.hpp"

namespace checker {
namespace {

std::vector<double> entries(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// A slope for the last contact's plane.
void tilt(Maker& m, Contact& c) {
  if (m.random.chance(0.5)) return;
  Vector3d n = m.up() + m.any(0.6);
  c.size["normal"] = entries(n);
  if (m.random.chance(0.5)) c.size["point"] = entries(m.any(m.L));
}

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

namespace {

struct Freedom {
  const char* coordinate;
  bool turns;
};
const std::map<std::string, std::vector<Freedom>> freedoms = {
    {"revolute", {{"", true}}},
    {"prismatic", {{"", false}}},
    {"screw", {{"", true}}},
    {"cylindrical", {{"angle", true}, {"slide", false}}},
    {"planar", {{"x", false}, {"y", false}, {"angle", true}}},
    {"universal", {{"angle_a", true}, {"angle_b", true}}}};

Joint make_joint(Maker& m, const std::string& kind, int a, int b) {
  Random& r = m.random;
  Joint j;
  j.name = "j" + std::to_string(m.scene.joints.size() + 1);
  j.kind = kind;
  j.a = a;
  j.b = b;
  const Vector3d p_a = m.at(a).moves() ? m.at(a).rest.p : Vector3d(m.at(b).rest.p + m.any(m.L)),
                 p_b = m.at(b).rest.p;
  j.point =
      m.at(b).kind == Kind::Particle && kind == "ball" ? p_b : Vector3d(0.5 * (p_a + p_b) + m.any(0.2 * m.L));
  j.axis = m.plane ? (kind == "prismatic" ? m.any(1) : Vector3d(Vector3d::UnitZ())) : r.direction();
  if (kind == "universal") j.axis_b = (j.axis.cross(r.direction())).normalized();
  if (kind == "gear") {
    j.ratio = r.one_of<double>({-2, -1, 0.5, 1, 3});
    if (!m.plane) j.axis_b = r.direction();
  }
  if (kind == "screw") j.lead = m.L * r.uniform(0.05, 0.3) * (r.chance(0.5) ? 1 : -1);
  if (kind == "rod") {
    j.point = m.at(a).kind == Kind::Particle ? p_a : Vector3d(p_a + m.any(0.2 * m.L));
    j.point_b = m.at(b).kind == Kind::Particle ? p_b : Vector3d(p_b + m.any(0.2 * m.L));
  }
  if (m.plane) j.point.z() = j.point_b.z() = 0;
  return j;
}

/// Stops, motors, springs, friction of a joint's coordinates.
void equip(Maker& m, int index) {
  Random& r = m.random;
  Joint& j = m.scene.joints[static_cast<std::size_t>(index)];
  const auto found = freedoms.find(j.kind);
  if (found == freedoms.end()) return;
  double mass = std::numeric_limits<double>::infinity();
  for (const int i : {j.a, j.b})
    if (m.at(i).moves()) mass = std::min(mass, m.at(i).mass);
  const Freedom& f = r.one_of(found->second);
  const double unit = f.turns ? 1 : m.L, effort = mass * 9.81 * (f.turns ? m.L : 1);
  const std::string name = found->second.size() > 1 ? f.coordinate : "";
  const double what = r.uniform();
  if (what < 0.25) {
    Limit l{index, name, not_given, not_given, m.e()};
    (r.chance(0.5) ? l.lower : l.upper) = 0;
    if (r.chance(0.4)) l = {index, name, -unit * r.uniform(0, 0.02), unit * r.uniform(0, 0.02), l.e};
    if (l.lower == l.upper) l.lower = -0.1 * unit;
    m.scene.limits.push_back(l);
  } else if (what < 0.4 && found->second.size() == 1) {
    j.friction = effort * r.decades(-2, 0.5);
  } else if (what < 0.55) {
    m.scene.motors.push_back({index, name,
                              digits(effort * r.uniform(-1, 1)) + "*cos(" + digits(r.uniform(0, 3) / m.T) +
                                  "*t) - " + digits(effort * m.T / unit * r.uniform(0, 0.2)) + "*rate",
                              ""});
  } else if (what < 0.63) {
    m.scene.motors.push_back(
        {index, name, "",
         digits(unit * r.uniform(-0.3, 0.3)) + "*(1 - cos(" + digits(r.uniform(0.5, 3) / m.T) + "*t))"});
  } else if (what < 0.75) {
    m.scene.joint_springs.push_back({index, name, effort / unit * r.decades(-1, 1),
                                     r.chance(0.5) ? effort * m.T / unit * r.uniform(0, 0.1) : 0,
                                     unit * r.uniform(-0.3, 0.3)});
  }
}

/// Whether a gear's wheel turns about an axle on a third body that moves: its angles are those in the world.
bool axle_moves(Maker& m, const Joint& gear) {
  for (const Joint& j : m.scene.joints) {
    if (j.kind == "gear" || j.name == gear.name) continue;
    for (const int wheel : {gear.a, gear.b}) {
      if (j.a != wheel && j.b != wheel) continue;
      const int carrier = j.a == wheel ? j.b : j.a;
      if (m.at(carrier).moves() && carrier != gear.a && carrier != gear.b) return true;
    }
  }
  return false;
}

/// Bodies tied to what was there before, round loops too. Those that hang on the ground turn about the first joint or stand.
void link(Maker& m, int first, int count, bool to_ground) {
  Random& r = m.random;
  const std::vector<std::string> space = {"fixed",     "ball",      "revolute", "prismatic", "cylindrical",
                                          "universal", "planar",    "screw",    "rod",       "gear",
                                          "revolute",  "prismatic", "revolute"},
                                 flat = {"fixed", "ball", "revolute", "prismatic", "rod", "gear", "revolute"};
  const auto add = [&](int a, int b) {
    std::string kind = r.one_of(m.plane ? flat : space);
    if (m.at(b).kind == Kind::Particle || m.at(a).kind == Kind::Particle)
      kind = r.chance(0.5) && m.at(a).kind != Kind::Particle ? "ball" : "rod";
    if (kind == "gear" && !m.at(a).moves()) kind = "revolute";
    m.scene.joints.push_back(make_joint(m, kind, a, b));
    return static_cast<int>(m.scene.joints.size()) - 1;
  };
  const int root = to_ground ? (r.chance(0.7) ? 0 : m.prescribed(m.at(first).rest.p + m.any(m.L))) : -1;
  std::vector<int> made;
  if (root >= 0) made.push_back(add(root, first));
  for (int i = 1; i < count; ++i) made.push_back(add(first + i - 1, first + i));
  if (r.chance(0.3) && count > 1)
    made.push_back(add(r.chance(0.5) || first + count - 1 == first + 1 ? 0 : first, first + count - 1));
  for (const int j : made)
    if (Joint& gear = m.scene.joints[static_cast<std::size_t>(j)];
        gear.kind == "gear" && axle_moves(m, gear)) {
      const std::string name = gear.name;
      gear = make_joint(m, "revolute", gear.a, gear.b);
      gear.name = name;
    }
  for (const int j : made)
    if (r.chance(0.5)) equip(m, j);
}

}  // namespace

void make_linkage(Maker& m) {
  Random& r = m.random;
  const int count = 1 + r.below(4), first = static_cast<int>(m.scene.bodies.size());
  Vector3d place = m.any(m.L) + 2 * m.L * m.up();
  for (int i = 0; i < count; ++i) {
    const double s = 0.5 * m.size();
    place += m.any(2 * m.L);
    const bool bead = i > 0 && r.chance(0.15);
    if (bead)
      m.particle(place);
    else
      m.body(r.chance(0.5) ? "box" : "ellipsoid", {s, s * r.uniform(0.4, 1), s * r.uniform(0.4, 2)}, place,
             r.turn());
  }
  const bool to_ground = r.chance(0.6);
  link(m, first, count, to_ground);
  if (!to_ground) {  // all of them move as one
    const Vector3d v = m.any(m.V * r.decades(-2, 0)),
                   w = r.chance(0.5) ? Vector3d(Vector3d::Zero())
                                     : Vector3d(r.direction() / m.T * r.decades(-2, 0));
    bool tied_to_world = false;
    for (const Joint& j : m.scene.joints) tied_to_world = tied_to_world || !m.at(j.a).moves();
    if (!tied_to_world)
      for (int i = first; i < first + count; ++i) {
        m.at(i).v = v + w.cross(m.at(i).rest.p - m.at(first).rest.p);
        if (m.at(i).turns()) m.at(i).w = w;
      }
  }
  // floors under one or two of them
  const int feet = 1 + r.below(2), floor = m.floor();
  for (int k = 0; k < feet; ++k) {
    const int b = first + r.below(count);
    if (!m.at(b).moves()) continue;
    Contact& c = m.contact(m.at(b).kind == Kind::Particle ? "particle_on_plane"
                           : r.chance(0.5)                ? "sphere_on_plane"
                                                          : "point_on_plane",
                           floor, b);
    if (c.gap == "sphere_on_plane") c.size["radius"] = {0.3 * m.size()};
    if (c.gap == "point_on_plane") c.size["foot"] = entries(m.any(0.5 * m.L));
    tilt(m, c);
    const double approach = std::max(0.0, -m.at(b).v.dot(m.up()));
    m.raise_plane(r.chance(0.6) ? 0 : (approach + 9.81 * m.h) * m.h * r.uniform(0, m.steps));
  }
}

void make_planar(Maker& m) {
  Random& r = m.random;
  const int count = 1 + r.below(3), floor = m.floor(), first = static_cast<int>(m.scene.bodies.size());
  const bool linked = count > 1 && r.chance(0.5);
  for (int i = 0; i < count; ++i) {
    const double s = m.size();
    const Vector3d above = m.any(2 * m.L) + 3 * m.L * m.up();
    const int kind = linked ? r.below(3) : r.below(5);
    bool rolls = true;
    int b = 0;
    if (kind == 0) {
      b = m.planar_body(0.7 * s, above, r.uniform(-1, 1));
      m.contact("disc_on_line", floor, b).size["radius"] = {s};
    } else if (kind == 1) {
      rolls = r.chance(0.4);
      b = m.planar_body(0.5 * s, above, rolls ? r.uniform(-1, 1) : 0);
      m.contact("box_on_line", floor, b).size = {{"width", {s}}, {"height", {s * r.uniform(0.3, 2)}}};
    } else if (kind == 2) {
      b = m.planar_body(0.5 * s, above, r.uniform(-1, 1));
      m.contact("ellipse_on_line", floor, b).size = {{"a", {s}}, {"b", {s * r.uniform(0.5, 1)}}};
    } else {
      const double big = s * r.uniform(1.5, 3);
      Vector3d down = m.any(0.5) - m.up();
      const bool disc = kind == 3;
      b = disc ? m.planar_body(0.7 * s, (big - s) * down.normalized(), 0)
               : m.particle(big * down.normalized());
      Contact& c = m.contact(disc ? "disc_in_circle" : "particle_in_circle", 0, b);
      if (disc)
        c.size = {{"radius_circle", {big}}, {"radius_disc", {s}}};
      else
        c.size["radius"] = {big};
    }
    Contact& c = m.scene.contacts.back();
    if (rolls && kind < 3) tilt(m, c);
    if (linked)
      m.raise_plane(r.chance(0.6) ? 0 : 9.81 * m.h * m.h * r.uniform(0, m.steps * m.steps / 2));
    else
      m.launch(rolls);
    if (!linked) add_extras(m, b);
  }
  if (linked) link(m, first, count, r.chance(0.5));
}

}  // namespace checker
