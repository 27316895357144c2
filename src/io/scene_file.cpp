#include "perp/io/scene_file.hpp"

#include <algorithm>
#include <cmath>

#include "core/files.hpp"
#include "io/names.hpp"
#include "io/scene_events.hpp"
#include "io/scene_gaps.hpp"
#include "io/scene_joints.hpp"
#include "io/scene_motions.hpp"
#include "io/scene_parts.hpp"
#include "io/scene_shapes.hpp"
#include "io/scene_table.hpp"
#include "io/scene_words.hpp"
#include "io/units.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/urdf.hpp"
#include "perp/step/methods.hpp"

namespace perp {
namespace {

/// Reads one file into one scene, table by table. What a table lacks is the model's own default.
class SceneReader {
 public:
  SceneReader(const std::string& file, const SceneParameters& set) : set_(set) { source_.file = file; }

  Scene read(const TomlValue& file) {
    const SceneTable top(file, source_);
    if (top.has("parameters")) parameters(top.table("parameters"));
    const TomlValue toml = with_repeats(file, source_);
    const SceneTable root(toml, source_);
    root.allow({"name",  "what",          "gravity",      "t_end",   "parameters", "body",  "joint",
                "limit", "motor",         "joint_spring", "spring",  "contact",    "force", "event",
                "shape", "material_pair", "no_contact",   "include", "repeat",     "method"});
    for (const auto& [name, value] : set_) need_parameter(name);
    scene_.name = root.has("name") ? root.name() : std::filesystem::path(source_.file).stem().string();
    if (root.has("what")) scene_.what = root.text("what");
    scene_.t_end = root.number("t_end", Dimension::Time, scene_.t_end);
    if (!(scene_.t_end > 0))
      root.refuse("t_end", "the time " + shortest(scene_.t_end), "needs to be positive [s]");
    model().set_gravity(root.vector("gravity", Dimension::Acceleration, model().gravity()));

    source_.bodies = {model().body(ground).name};
    source_.body_of = {{source_.bodies[0], 0}};
    shapes_ = read_shapes(root);
    for (const SceneTable& table : root.tables("body")) body(table);
    for (const SceneTable& table : root.tables("joint")) read_joint(table, model());
    for (const SceneTable& table : root.tables("joint")) need_fixed_axles(table);
    for (const SceneTable& table : root.tables("limit")) read_limit(table, model());
    for (const SceneTable& table : root.tables("motor")) read_motor(table, model());
    for (const SceneTable& table : root.tables("joint_spring")) read_joint_spring(table, model());
    for (const SceneTable& table : root.tables("spring")) spring(table);
    for (const SceneTable& table : root.tables("contact")) contact(table);
    for (const SceneTable& table : root.tables("force")) read_force(table, model());
    for (const SceneTable& table : root.tables("event"))
      scene_.events.push_back(read_event(table, model(), scene_.events));
    if (root.has("method")) method_settings(root.table("method"));
    scene_.start = model().rest();
    for (const SceneTable& table : root.tables("body")) start(table);
    for (const std::string& pair : add_shapes(root, shapes_, scene_.start, model()))
      scene_.unused.push_back("contact '" + pair + "': the shapes overlap at the start");
    return std::move(scene_);
  }

 private:
  void method_settings(const SceneTable& all) {
    all.allow({"penalty"});
    const SceneTable table = all.table("penalty");
    table.allow({"stiffness", "damping", "slip_speed", "explicit"});
    MethodOptions options;
    for (const auto& [key, dimension] : {std::pair{"stiffness", Dimension::Stiffness},
                                         {"damping", Dimension::Damping},
                                         {"slip_speed", Dimension::Velocity},
                                         {"explicit", Dimension::None}}) {
      if (!table.has(key)) continue;
      const double value = table.number(key, dimension);
      table.placed([&] { options.set("penalty", key, value); });
      scene_.method_settings["penalty"][key] = value;
    }
  }

  Model& model() { return scene_.model; }

  /// name = value, or name = { value, what }; a value may use the parameters above it.
  void parameters(const SceneTable& table) {
    for (const auto& [name, place, value] : table.toml().entries) {
      const bool fits = !name.empty() && std::isdigit(static_cast<unsigned char>(name[0])) == 0 &&
                        name.find('-') == std::string::npos;
      if (!fits || Expression::reserved(name))
        refuse_at(source_.file, place, "the parameter '" + name + "'",
                  "needs a name of letters, digits and '_' that is no function, nor pi or t");
      SceneParameter parameter;
      parameter.name = name;
      const TomlValue* given = &value;
      if (value.kind == TomlValue::Kind::Table) {
        const SceneTable described(value, source_);
        described.allow({"value", "what"});
        if (!described.has("value"))
          described.refuse("value", "a parameter without the key 'value'", "needs it");
        if (described.has("what")) parameter.what = described.text("what");
        given = &value.find("value")->value;
      }
      parameter.value = table.number(*given, Dimension::Any);
      if (given->kind == TomlValue::Kind::Text)
        if (const auto quantity = read_quantity(given->text, Dimension::Any))
          source_.dimensions[name] = quantity->dimension;
      if (const auto overridden = set_.find(name); overridden != set_.end()) {
        parameter.value = overridden->second;
        if (!std::isfinite(parameter.value))
          refuse(source_.file, name, parameter.value, "needs to be finite");
      }
      source_.parameters[name] = parameter.value;
      scene_.parameters.push_back(std::move(parameter));
    }
  }

  void need_parameter(const std::string& name) const {
    if (source_.parameters.contains(name)) return;
    std::vector<std::string> known;
    for (const SceneParameter& parameter : scene_.parameters) known.push_back(parameter.name);
    refuse(source_.file, "parameter", name,
           known.empty() ? "the scene has no parameters" : "needs to be " + one_of(known, name));
  }

  /// Position, and orientation as a quaternion, an axis with an angle, or (in the plane) an angle.
  Pose pose(const SceneTable& table, const Pose& otherwise, BodyKind kind) const {
    Pose X = otherwise;
    X.p = table.vector("position", Dimension::Length, X.p);
    if (kind == BodyKind::Planar && table.has("angle")) {
      if (table.has("orientation"))
        table.refuse("orientation", "an orientation beside an angle", "needs one of the two");
      const double half = 0.5 * table.number("angle", Dimension::Angle);
      X.q = Quaternion(std::cos(half), 0, 0, std::sin(half));
    } else if (table.has("orientation")) {
      X.q = table.orientation();
    }
    return X;
  }

  Inertia inertia(const SceneTable& body) const {
    const double mass = body.number("mass", Dimension::Mass);
    const SceneTable table = body.table("inertia");
    const auto made = [&](auto make) -> Inertia {
      try {
        return make();
      } catch (const std::invalid_argument& error) {
        (table.concerns(error) ? table : body).refuse(error);
      }
    };
    if (table.has("moments")) {
      table.allow({"moments"});
      const Vector3 moments = table.vector("moments", Dimension::Inertia);
      return made([&] { return Inertia::principal(mass, moments); });
    }
    if (table.has("tensor")) {
      table.allow({"tensor"});
      const std::vector<Vector3> rows = table.vectors("tensor", 3, Dimension::Inertia);
      Matrix3 J;
      for (int i = 0; i < 3; ++i) J.row(i) = rows[static_cast<std::size_t>(i)];
      return made([&] { return Inertia(mass, J); });
    }
    const std::vector<std::string> shapes{"solid_sphere", "hollow_sphere", "box", "cylinder", "ellipsoid"};
    const auto size = [&](const char* key) { return table.number(key, Dimension::Length); };
    switch (table.word("shape", shapes)) {
      case 0: {
        table.allow({"shape", "radius"});
        const double radius = size("radius");
        return made([&] { return Inertia::solid_sphere(mass, radius); });
      }
      case 1: {
        table.allow({"shape", "radius"});
        const double radius = size("radius");
        return made([&] { return Inertia::hollow_sphere(mass, radius); });
      }
      case 2: {
        table.allow({"shape", "size"});
        const Vector3 edges = table.vector("size", Dimension::Length);
        return made([&] { return Inertia::solid_box(mass, edges); });
      }
      case 3: {
        table.allow({"shape", "radius", "length"});
        const double radius = size("radius"), length = size("length");
        return made([&] { return Inertia::solid_cylinder(mass, radius, length); });
      }
      default: {
        table.allow({"shape", "semi_axes"});
        const Vector3 semi_axes = table.vector("semi_axes", Dimension::Length);
        return made([&] { return Inertia::solid_ellipsoid(mass, semi_axes); });
      }
    }
  }

  /// Whether mass and inertia are those of the body's shapes.
  bool by_shapes(const SceneTable& body) const {
    return !body.has("mass") && !body.has("inertia") &&
           std::any_of(shapes_.begin(), shapes_.end(),
                       [&](const SceneShape& s) { return s.body == body.name(); });
  }

  Inertia inertia_by_shapes(const SceneTable& body) const {
    const MassProperties mass = mass_by_shapes(shapes_, body);
    return body.placed([&] { return Inertia(mass.mass, mass.J); });
  }

  void body(const SceneTable& table) {
    table.allow({"name", "kind", "mass", "inertia", "position", "orientation", "angle", "start", "velocity",
                 "angular_velocity", "angular_velocity_body", "motion"});  // of some kind; below of its own
    BodyOptions options;
    options.name = table.name();
    const BodyKind kind =
        scene_words::body_kinds[table.word("kind", scene_words::names(scene_words::body_kinds))].second;
    switch (kind) {
      case BodyKind::Spatial: {
        table.allow({"name", "kind", "mass", "inertia", "position", "orientation", "start", "velocity",
                     "angular_velocity", "angular_velocity_body"});
        options.pose = pose(table, {}, kind);
        const Inertia J = by_shapes(table) ? inertia_by_shapes(table) : inertia(table);
        table.placed([&] { return model().add_body(J, options); });
        break;
      }
      case BodyKind::Planar: {
        table.allow({"name", "kind", "mass", "inertia", "position", "angle", "orientation", "start",
                     "velocity", "angular_velocity"});
        options.pose = pose(table, {}, kind);
        const MassProperties made = by_shapes(table) ? mass_by_shapes(shapes_, table) : MassProperties{};
        const double mass = by_shapes(table) ? made.mass : table.number("mass", Dimension::Mass),
                     J = by_shapes(table) ? made.J(2, 2) : table.number("inertia", Dimension::Inertia);
        table.placed([&] { return model().add_planar_body(mass, J, options); });
        break;
      }
      case BodyKind::Particle: {
        table.allow({"name", "kind", "mass", "position", "start", "velocity"});
        options.pose = pose(table, {}, kind);
        const double mass = table.number("mass", Dimension::Mass);
        table.placed([&] { return model().add_particle(mass, options); });
        break;
      }
      default: {
        table.allow({"name", "kind", "position", "orientation", "motion"});
        const Pose about = pose(table, {}, kind);
        PrescribedMotion motion = table.has("motion") ? read_motion(table.table("motion"), about)
                                                      : PrescribedMotion::belt(Vector3::Zero(), about);
        table.placed([&] { return model().add_prescribed(std::move(motion), options); });
      }
    }
    source_.bodies.push_back(model().bodies().back().name);
    source_.body_of[source_.bodies.back()] = static_cast<int>(source_.bodies.size()) - 1;
  }

  /// Where the body of the table is and how it moves at t = 0. Bodies come in the order of the file.
  void start(const SceneTable& table) {
    const BodyId id{++started_};
    const Body& body = model().body(id);
    State& x = scene_.start;
    if (body.kind == BodyKind::Prescribed) return;
    if (body.kind == BodyKind::Planar && table.has("angle"))
      x.q[body.q0 + 2] = table.number("angle", Dimension::Angle);
    if (table.has("start")) {
      const SceneTable begin = table.table("start");
      if (body.kind == BodyKind::Spatial) begin.allow({"position", "orientation"});
      if (body.kind == BodyKind::Planar) begin.allow({"position", "angle"});
      if (body.kind == BodyKind::Particle) begin.allow({"position"});
      const Pose X = pose(begin, body.rest, body.kind);
      begin.placed([&] {
        model().set_position(x, id, X.p);
        return 0;
      });
      if (begin.has("orientation")) model().set_orientation(x, id, X.q);
      if (begin.has("angle")) x.q[body.q0 + 2] = begin.number("angle", Dimension::Angle);
    }
    const Vector3 v = table.vector("velocity", Dimension::Velocity, Vector3::Zero());
    Vector3 w = Vector3::Zero();
    if (body.kind == BodyKind::Planar)
      w.z() = table.number("angular_velocity", Dimension::Rate, 0);
    else
      w = table.vector("angular_velocity", Dimension::Rate, w);
    table.placed([&] {
      model().set_velocity(x, id, v, w);
      return 0;
    });
    if (table.has("angular_velocity_body")) {
      if (table.has("angular_velocity"))
        table.refuse("angular_velocity_body", "a second angular velocity", "needs one of the two");
      x.nu.segment<3>(body.v0 + 3) = table.vector("angular_velocity_body", Dimension::Rate);
    }
  }

  /// A gear's angles are those in the world: right for wheels whose axles stay where they are.
  void need_fixed_axles(const SceneTable& table) {
    if (table.text("kind") != "gear") return;
    const auto moves = [&](BodyId id) {
      const BodyKind kind = model().body(id).kind;
      return kind != BodyKind::Ground && kind != BodyKind::Prescribed;
    };
    for (const char* key : {"a", "b"}) {
      const BodyId wheel = table.body(key);
      for (const JointGeometry& joint : model().joints()) {
        if (joint.kind == JointKind::Gear || (joint.a != wheel && joint.b != wheel)) continue;
        const BodyId carrier = joint.a == wheel ? joint.b : joint.a;
        if (moves(wheel) && moves(carrier) && carrier != table.body("a") && carrier != table.body("b"))
          table.refuse(key,
                       "the wheel '" + model().body(wheel).name + "', which joint '" + joint.name +
                           "' puts on '" + model().body(carrier).name + "'",
                       "needs an axle that does not move: a gear's angles are those in the world");
      }
    }
  }

  void spring(const SceneTable& table) {
    table.allow({"a", "b", "point_a", "point_b", "stiffness", "damping", "length"});
    Spring spring;
    spring.a = table.body("a");
    spring.b = table.body("b");
    spring.point_a = table.vector("point_a", Dimension::Length, spring.point_a);
    spring.point_b = table.vector("point_b", Dimension::Length, spring.point_b);
    spring.stiffness = table.number("stiffness", Dimension::Stiffness);
    spring.damping = table.number("damping", Dimension::Damping, 0);
    spring.length = table.number("length", Dimension::Length, 0);
    table.placed([&] {
      model().add_spring(spring);
      return 0;
    });
  }

  static FrictionAxes friction_axes(const SceneTable& table) {
    table.allow({"mu", "axes_of", "t"});
    const std::vector<double> mu = table.numbers("mu", 2, 2, Dimension::None);
    FrictionAxes axes{.mu = {mu[0], mu[1]}, .t = table.vector("t", Dimension::None, Vector3::UnitX())};
    if (table.has("axes_of") && table.word("axes_of", {"a", "b"}) == 1) axes.of = FrictionAxes::Of::B;
    return axes;
  }

  void contact(const SceneTable& table) {
    table.allow(
        {"name", "a", "b", "gap", "mu", "torsion", "rolling", "friction_axes", "e", "tangent", "compliance"});
    const BodyId a = table.body("a"), b = table.body("b");
    Gap gap = read_gap(table.table("gap"));
    ContactOptions options;
    options.name = table.name();
    options.mu = table.number("mu", Dimension::None, 0);
    options.torsion = table.number("torsion", Dimension::Length, 0);
    options.rolling = table.number("rolling", Dimension::Length, 0);
    if (table.has("friction_axes")) options.friction_axes = friction_axes(table.table("friction_axes"));
    options.e = table.number("e", Dimension::None, 0);
    options.compliance = table.number("compliance", Dimension::None, 1);
    options.tangent = table.vector("tangent", Dimension::None, options.tangent);
    table.placed([&] { return model().add_contact(a, b, std::move(gap), options); });
  }

  const SceneParameters& set_;
  SceneSource source_;
  Scene scene_;
  int started_ = 0;
  std::vector<SceneShape> shapes_;
};

}  // namespace

Scene read_scene(std::string_view text, const std::string& file, const SceneParameters& set) {
  return read_scene(text, file, set, [](const std::string& path) { return scene_text(path); });
}

Scene read_scene(std::string_view text, const std::string& file, const SceneParameters& set,
                 const std::function<std::string(const std::string&)>& read) {
  return SceneReader(file, set).read(with_includes(parse_toml(text, file), file, read));
}

bool is_scene_file(const std::string& name_or_file) {
  const std::vector<std::string>& names = scene_names();
  return std::find(names.begin(), names.end(), name_or_file) == names.end();
}

std::string scene_text(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code none;
  const bool path = name.find('/') != std::string::npos || name.ends_with(".toml") || name.ends_with(".urdf");
  if (!path && !std::filesystem::exists(file, none))
    refuse("scene", "SCENE", name, "needs to be a file or " + one_of(scene_names(), name));
  if (!std::filesystem::is_regular_file(file, none))
    refuse_at(name, {}, "a file that cannot be read", "needs a scene file");
  if (const auto size = std::filesystem::file_size(file, none); size > longest_toml)
    refuse_at(name, {}, std::to_string(size) + " bytes", "needs to have 100 MB at most");
  return read_file(file, "needs a scene file");
}

Scene load_scene(const std::string& name_or_file, const SceneParameters& set) {
  if (!is_scene_file(name_or_file)) return scene(name_or_file, set);
  const std::string text = scene_text(name_or_file);
  return name_or_file.ends_with(".urdf") ? read_urdf(text, name_or_file, set)
                                         : read_scene(text, name_or_file, set);
}

}  // namespace perp
