// Scenes from their text.
#include <cmath>
#include <set>
#include <stdexcept>
#include <toml.hpp>

#include "scene.hpp"

namespace checker {
namespace {

/// A table of the file; every key must be asked for, so that nothing is read past.
class Table {
 public:
  Table(const toml::value& value) : table_(value.as_table()) {}
  ~Table() noexcept(false) {
    if (std::uncaught_exceptions() > 0) return;
    for (const auto& [key, value] : table_)
      if (!asked_.contains(key)) throw std::runtime_error("the checker does not know the key " + key);
  }
  bool has(const std::string& key) {
    asked_.insert(key);
    return table_.contains(key);
  }
  static double number(const toml::value& v) {
    if (v.is_floating()) return v.as_floating();
    if (v.is_integer()) return static_cast<double>(v.as_integer());
    throw std::runtime_error("the checker reads numbers only");
  }
  double number(const std::string& key, double otherwise) {
    return has(key) ? number(table_.at(key)) : otherwise;
  }
  std::string text(const std::string& key, const std::string& otherwise = "") {
    if (!has(key)) return otherwise;
    const toml::value& v = table_.at(key);
    return v.is_string() ? v.as_string().str : digits(number(v));
  }
  std::vector<double> numbers(const std::string& key) {
    std::vector<double> x;
    if (!has(key)) return x;
    const toml::value& v = table_.at(key);
    if (!v.is_array()) return {number(v)};
    for (const toml::value& entry : v.as_array()) x.push_back(number(entry));
    return x;
  }
  Vector3d vector(const std::string& key, const Vector3d& otherwise = Vector3d::Zero()) {
    const std::vector<double> x = numbers(key);
    if (x.empty()) return otherwise;
    return {x.at(0), x.at(1), x.size() > 2 ? x[2] : 0};
  }
  Quaterniond orientation(const Quaterniond& otherwise) {
    const std::vector<double> x = numbers("orientation");
    if (x.empty()) return otherwise;
    const Quaterniond q(x.at(0), x.at(1), x.at(2), x.at(3));
    return std::abs(q.norm() - 1) < 1e-14 ? q : q.normalized();
  }
  const toml::value& at(const std::string& key) {
    asked_.insert(key);
    return table_.at(key);
  }
  const std::vector<toml::value>& tables(const std::string& key) {
    static const std::vector<toml::value> none;
    return has(key) ? table_.at(key).as_array() : none;
  }

 private:
  const toml::table& table_;
  std::set<std::string> asked_;
};

class Reader {
 public:
  explicit Reader(const toml::value& file) {
    Table root(file);
    for (const char* key : {"name", "what", "t_end"}) (void)root.has(key);
    scene_.gravity = root.vector("gravity", scene_.gravity);
    for (const toml::value& v : root.tables("body")) body(v);
    for (const toml::value& v : root.tables("joint")) joint(v);
    for (const toml::value& v : root.tables("limit")) limit(v);
    for (const toml::value& v : root.tables("motor")) motor(v);
    for (const toml::value& v : root.tables("joint_spring")) joint_spring(v);
    for (const toml::value& v : root.tables("spring")) spring(v);
    for (const toml::value& v : root.tables("contact")) contact(v);
    for (const toml::value& v : root.tables("force")) force(v);
  }
  Scene take() { return std::move(scene_); }

 private:
  template <class Things>
  static int index(const Things& things, const std::string& name) {
    for (std::size_t i = 0; i < things.size(); ++i)
      if (things[i].name == name) return static_cast<int>(i);
    throw std::runtime_error("nothing is called " + name);
  }
  int body_of(Table& t, const char* key) { return index(scene_.bodies, t.text(key)); }

  void body(const toml::value& v) {
    static const std::map<std::string, Kind> kinds = {{"prescribed", Kind::Prescribed},
                                                      {"spatial", Kind::Spatial},
                                                      {"planar", Kind::Planar},
                                                      {"particle", Kind::Particle}};
    Table t(v);
    Body b;
    b.name = t.text("name", "body " + std::to_string(scene_.bodies.size()));
    b.kind = kinds.at(t.text("kind"));
    b.mass = t.number("mass", 0);
    if (b.kind == Kind::Planar) b.size = {t.number("inertia", not_given)};
    if (b.kind == Kind::Spatial) inertia(t.at("inertia"), b);
    place(t, b, b.rest, b.rest_angle);
    b.start = b.rest;
    b.start_angle = b.rest_angle;
    b.starts_elsewhere = t.has("start");
    if (b.starts_elsewhere) {
      Table start(t.at("start"));
      place(start, b, b.start, b.start_angle);
    }
    b.v = t.vector("velocity");
    if (b.kind == Kind::Planar) b.w.z() = t.number("angular_velocity", 0);
    if (b.kind == Kind::Spatial) b.w = t.vector("angular_velocity");
    if (t.has("motion")) {
      Table m(t.at("motion"));
      b.motion.kind = m.text("kind");
      b.motion.vector = m.vector(b.motion.kind == "shaker"      ? "amplitude"
                                 : b.motion.kind == "turntable" ? "axis"
                                                                : "velocity",
                                 Vector3d::UnitZ());
      b.motion.rate = m.number("rate", 0);
      b.motion.phase = m.number("phase", 0);
    }
    scene_.bodies.push_back(b);
  }

  static void inertia(const toml::value& v, Body& b) {
    Table t(v);
    b.shape = t.text("shape", "moments");
    for (const char* key : {"moments", "radius", "length", "size", "semi_axes"})
      for (const double x : t.numbers(key)) b.size.push_back(x);
  }

  static void place(Table& t, const Body& b, Place& at, double& angle) {
    at.p = t.vector("position", at.p);
    if (b.kind == Kind::Planar) {
      angle = t.number("angle", angle);
      at.q = Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
    } else {
      at.q = t.orientation(at.q);
    }
  }

  void joint(const toml::value& v) {
    Table t(v);
    Joint j;
    j.name = t.text("name", "joint " + std::to_string(scene_.joints.size() + 1));
    j.kind = t.text("kind");
    j.a = body_of(t, "a");
    j.b = body_of(t, "b");
    j.point = t.vector("point");
    j.axis = t.vector("axis", j.axis);
    j.axis_b = t.vector("axis_b");
    j.point_b = t.vector("point_b");
    j.lead = t.number("lead", not_given);
    j.ratio = t.number("ratio", not_given);
    j.friction = t.number("friction", 0);
    scene_.joints.push_back(j);
  }

  void limit(const toml::value& v) {
    Table t(v);
    scene_.limits.push_back({index(scene_.joints, t.text("joint")), t.text("coordinate"),
                             t.number("lower", not_given), t.number("upper", not_given), t.number("e", 0)});
  }
  void motor(const toml::value& v) {
    Table t(v);
    scene_.motors.push_back(
        {index(scene_.joints, t.text("joint")), t.text("coordinate"), t.text("effort"), t.text("motion")});
  }
  void joint_spring(const toml::value& v) {
    Table t(v);
    scene_.joint_springs.push_back({index(scene_.joints, t.text("joint")), t.text("coordinate"),
                                    t.number("stiffness", 0), t.number("damping", 0), t.number("rest", 0)});
  }
  void spring(const toml::value& v) {
    Table t(v);
    Spring s;
    s.a = body_of(t, "a");
    s.b = body_of(t, "b");
    s.point_a = t.vector("point_a");
    s.point_b = t.vector("point_b");
    s.stiffness = t.number("stiffness", 0);
    s.damping = t.number("damping", 0);
    s.length = t.number("length", 0);
    scene_.springs.push_back(s);
  }

  void contact(const toml::value& v) {
    Table t(v);
    Contact c;
    c.name = t.text("name", "contact " + std::to_string(scene_.contacts.size() + 1));
    c.a = body_of(t, "a");
    c.b = body_of(t, "b");
    c.mu = t.number("mu", 0);
    c.e = t.number("e", 0);
    c.tangent = t.vector("tangent");
    Table gap(t.at("gap"));
    c.gap = gap.text("kind");
    for (const char* key :
         {"radius", "radius_a", "radius_b", "radius_circle", "radius_disc", "length", "width", "height", "a",
          "b", "normal", "point", "foot", "size", "size_a", "size_b", "semi_axes", "centre", "axis"})
      if (gap.has(key)) c.size[key] = gap.numbers(key);
    for (auto* place : {&c.place_a, &c.place_b}) {
      const char* key = place == &c.place_a ? "place_a" : "place_b";
      if (!gap.has(key)) continue;
      c.placed = true;
      Table at(gap.at(key));
      place->p = at.vector("position");
      place->q = at.orientation(place->q);
    }
    scene_.contacts.push_back(c);
  }

  void force(const toml::value& v) {
    Table t(v);
    Force f;
    f.body = body_of(t, "body");
    const auto& entries = t.at("force").as_array();
    for (std::size_t i = 0; i < entries.size() && i < 3; ++i)
      f.force[i] = entries[i].is_string() ? entries[i].as_string().str : digits(Table::number(entries[i]));
    scene_.forces.push_back(f);
  }

  Scene scene_;
};

}  // namespace

Scene read_scene(const std::string& path) { return Reader(toml::parse(path)).take(); }

}  // namespace checker
