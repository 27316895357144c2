// Recipes of linkages, in space and in the plane, with what their joints carry.
#include <algorithm>
#include <cmath>

#include "maker.hpp"

namespace checker {
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
  for (bool again = true; again;) {  // a gear that becomes an axle may be another's
    again = false;
    for (const int j : made) {
      Joint& gear = m.scene.joints[static_cast<std::size_t>(j)];
      if (gear.kind != "gear" || !axle_moves(m, gear)) continue;
      const std::string name = gear.name;
      gear = make_joint(m, "revolute", gear.a, gear.b);
      gear.name = name;
      again = true;
    }
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
