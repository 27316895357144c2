// Scenes as text.
#include <cmath>
#include <cstdio>

#include "scene.hpp"

namespace checker {

Matrix3d Body::inertia() const {
  Vector3d J = Vector3d::Zero();
  const auto square = [&](std::size_t i) { return size[i] * size[i]; };
  if (kind == Kind::Planar) J.z() = size[0];
  if (kind != Kind::Spatial) return J.asDiagonal();
  if (shape == "moments") J = Vector3d(size[0], size[1], size[2]);
  if (shape == "solid_sphere") J.setConstant(2 * mass * square(0) / 5);
  if (shape == "hollow_sphere") J.setConstant(2 * mass * square(0) / 3);
  if (shape == "box")
    J = mass / 12 * Vector3d(square(1) + square(2), square(0) + square(2), square(0) + square(1));
  if (shape == "ellipsoid")
    J = mass / 5 * Vector3d(square(1) + square(2), square(0) + square(2), square(0) + square(1));
  if (shape == "cylinder") {
    J.x() = J.y() = mass * (square(0) / 4 + square(1) / 12);
    J.z() = mass * square(0) / 2;
  }
  return J.asDiagonal();
}

Place Body::first() const { return starts_elsewhere ? start : rest; }

std::string digits(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", number + 0.0);  // and no -0
  return text;
}

namespace {

std::string list(const double* x, std::size_t n) {
  std::string text = "[";
  for (std::size_t i = 0; i < n; ++i) text += (i == 0 ? "" : ", ") + digits(x[i]);
  return text + "]";
}
std::string list(const Vector3d& v) { return list(v.data(), 3); }
std::string list(const Quaterniond& q) {
  const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
  return list(wxyz, 4);
}
std::string quoted(const std::string& text) { return '"' + text + '"'; }

class Writer {
 public:
  void table(const std::string& name) { out_ += "\n[[" + name + "]]\n"; }
  void line(const std::string& key, const std::string& value) { out_ += key + " = " + value + "\n"; }
  void unless(double otherwise, const std::string& key, double value) {
    if (!(value == otherwise) && !std::isnan(value)) line(key, digits(value));
  }
  void unless_zero(const std::string& key, const Vector3d& v) {
    if (!v.isZero(0)) line(key, list(v));
  }
  std::string out_;
};

void write_place(Writer& w, const Body& body, const Place& at, double angle, bool inline_table) {
  const bool planar = body.kind == Kind::Planar;
  std::string position = list(at.p), turn = planar ? digits(angle) : list(at.q);
  const char* key = planar ? "angle" : "orientation";
  if (inline_table) {
    std::string text = "{ position = " + position;
    if (body.turns()) text += std::string(", ") + key + " = " + turn;
    w.line("start", text + " }");
    return;
  }
  w.unless_zero("position", at.p);
  if (planar ? angle != 0 : !at.q.isApprox(Quaterniond::Identity(), 0)) w.line(key, turn);
}

void write_body(Writer& w, const Body& body) {
  static const std::map<Kind, std::string> kinds = {{Kind::Prescribed, "prescribed"},
                                                    {Kind::Spatial, "spatial"},
                                                    {Kind::Planar, "planar"},
                                                    {Kind::Particle, "particle"}};
  w.table("body");
  w.line("name", quoted(body.name));
  w.line("kind", quoted(kinds.at(body.kind)));
  if (body.moves()) w.line("mass", digits(body.mass));
  if (body.kind == Kind::Planar) w.line("inertia", digits(body.size[0]));
  if (body.kind == Kind::Spatial) {
    const auto& s = body.size;
    std::string text = "{ shape = " + quoted(body.shape) + ", ";
    if (body.shape == "moments") text = "{ moments = " + list(s.data(), 3);
    if (body.shape.ends_with("sphere")) text += "radius = " + digits(s[0]);
    if (body.shape == "box") text += "size = " + list(s.data(), 3);
    if (body.shape == "ellipsoid") text += "semi_axes = " + list(s.data(), 3);
    if (body.shape == "cylinder") text += "radius = " + digits(s[0]) + ", length = " + digits(s[1]);
    w.line("inertia", text + " }");
  }
  write_place(w, body, body.rest, body.rest_angle, false);
  if (body.starts_elsewhere) write_place(w, body, body.start, body.start_angle, true);
  if (body.moves()) w.unless_zero("velocity", body.v);
  if (body.kind == Kind::Planar) w.unless(0, "angular_velocity", body.w.z());
  if (body.kind == Kind::Spatial) w.unless_zero("angular_velocity", body.w);
  const Motion& m = body.motion;
  if (m.kind == "shaker")
    w.line("motion", "{ kind = \"shaker\", amplitude = " + list(m.vector) + ", rate = " + digits(m.rate) +
                         ", phase = " + digits(m.phase) + " }");
  if (m.kind == "turntable")
    w.line("motion",
           "{ kind = \"turntable\", axis = " + list(m.vector) + ", rate = " + digits(m.rate) + " }");
  if (m.kind == "belt") w.line("motion", "{ kind = \"belt\", velocity = " + list(m.vector) + " }");
}

void write_joints(Writer& w, const Scene& scene) {
  for (const Joint& j : scene.joints) {
    w.table("joint");
    w.line("name", quoted(j.name));
    w.line("kind", quoted(j.kind));
    w.line("a", quoted(scene.bodies[static_cast<std::size_t>(j.a)].name));
    w.line("b", quoted(scene.bodies[static_cast<std::size_t>(j.b)].name));
    w.line("point", list(j.point));
    if (j.kind == "rod")
      w.line("point_b", list(j.point_b));
    else
      w.line("axis", list(j.axis));
    w.unless_zero("axis_b", j.axis_b);
    w.unless(0, "lead", j.lead);
    w.unless(0, "ratio", j.ratio);
    w.unless(0, "friction", j.friction);
  }
  const auto about = [&](const char* table, int joint, const std::string& coordinate) {
    w.table(table);
    w.line("joint", quoted(scene.joints[static_cast<std::size_t>(joint)].name));
    if (!coordinate.empty()) w.line("coordinate", quoted(coordinate));
  };
  for (const Limit& l : scene.limits) {
    about("limit", l.joint, l.coordinate);
    w.unless(not_given, "lower", l.lower);
    w.unless(not_given, "upper", l.upper);
    w.unless(0, "e", l.e);
  }
  for (const Motor& m : scene.motors) {
    about("motor", m.joint, m.coordinate);
    w.line(m.motion.empty() ? "effort" : "motion", quoted(m.motion.empty() ? m.effort : m.motion));
  }
  for (const JointSpring& s : scene.joint_springs) {
    about("joint_spring", s.joint, s.coordinate);
    w.line("stiffness", digits(s.stiffness));
    w.unless(0, "damping", s.damping);
    w.unless(0, "rest", s.rest);
  }
}

void write_contact(Writer& w, const Scene& scene, const Contact& c) {
  w.table("contact");
  w.line("name", quoted(c.name));
  w.line("a", quoted(scene.bodies[static_cast<std::size_t>(c.a)].name));
  w.line("b", quoted(scene.bodies[static_cast<std::size_t>(c.b)].name));
  std::string gap = "{ kind = " + quoted(c.gap);
  for (const auto& [key, x] : c.size)
    gap += ", " + key + " = " + (x.size() == 1 ? digits(x[0]) : list(x.data(), x.size()));
  if (c.placed)
    for (const auto& [key, place] : {std::pair("place_a", c.place_a), std::pair("place_b", c.place_b)})
      gap += std::string(", ") + key + " = { position = " + list(place.p) +
             ", orientation = " + list(place.q) + " }";
  w.line("gap", gap + " }");
  w.unless(0, "mu", c.mu);
  w.unless(0, "e", c.e);
  w.unless_zero("tangent", c.tangent);
}

}  // namespace

std::string text_of(const Scene& scene) {
  Writer w;
  w.line("gravity", list(scene.gravity));
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) write_body(w, scene.bodies[i]);
  write_joints(w, scene);
  for (const Spring& s : scene.springs) {
    w.table("spring");
    w.line("a", quoted(scene.bodies[static_cast<std::size_t>(s.a)].name));
    w.line("b", quoted(scene.bodies[static_cast<std::size_t>(s.b)].name));
    w.line("point_a", list(s.point_a));
    w.line("point_b", list(s.point_b));
    w.line("stiffness", digits(s.stiffness));
    w.unless(0, "damping", s.damping);
    w.unless(0, "length", s.length);
  }
  for (const Contact& c : scene.contacts) write_contact(w, scene, c);
  for (const Force& f : scene.forces) {
    w.table("force");
    w.line("body", quoted(scene.bodies[static_cast<std::size_t>(f.body)].name));
    w.line("force", "[" + quoted(f.force[0]) + ", " + quoted(f.force[1]) + ", " + quoted(f.force[2]) + "]");
  }
  return w.out_;
}

}  // namespace checker
