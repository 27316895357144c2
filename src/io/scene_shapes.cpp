#include "io/scene_shapes.hpp"

#include <algorithm>
#include <cmath>

#include "io/scene_text.hpp"

namespace perp {
namespace {

using Kind = Shape::Kind;

std::vector<Vector3> vertices(const SceneTable& table) {
  const TomlValue::Entry* entry = table.toml().find("vertices");
  const std::size_t count = entry == nullptr ? 1 : std::max<std::size_t>(1, entry->value.items.size());
  return table.vectors("vertices", count, Dimension::Length);
}

/// The file's word for a kind, the keys of its sizes, and its maker.
struct ShapeKind {
  std::string name;
  std::vector<std::string> keys;
  Shape (*make)(const SceneTable&);
};

double size(const SceneTable& table, const char* key) { return table.number(key, Dimension::Length); }

const std::vector<ShapeKind>& spatial_kinds() {
  static const std::vector<ShapeKind> all = {
      {"sphere", {"radius"}, [](const SceneTable& t) { return Shape::sphere(size(t, "radius")); }},
      {"half_space", {}, [](const SceneTable&) { return Shape::half_space(); }},
      {"box", {"size"}, [](const SceneTable& t) { return Shape::box(t.vector("size", Dimension::Length)); }},
      {"capsule",
       {"radius", "length"},
       [](const SceneTable& t) { return Shape::capsule(size(t, "radius"), size(t, "length")); }},
      {"cylinder",
       {"radius", "length"},
       [](const SceneTable& t) { return Shape::cylinder(size(t, "radius"), size(t, "length")); }},
      {"disc", {"radius"}, [](const SceneTable& t) { return Shape::disc(size(t, "radius")); }},
      {"ellipsoid",
       {"semi_axes"},
       [](const SceneTable& t) { return Shape::ellipsoid(t.vector("semi_axes", Dimension::Length)); }},
      {"polyhedron", {"vertices"}, [](const SceneTable& t) { return Shape::polyhedron(vertices(t)); }},
      {"hollow_sphere",
       {"radius"},
       [](const SceneTable& t) { return Shape::hollow_sphere(size(t, "radius")); }},
      {"hollow_cylinder",
       {"radius"},
       [](const SceneTable& t) { return Shape::hollow_cylinder(size(t, "radius")); }},
  };
  return all;
}

const std::vector<ShapeKind>& planar_kinds() {
  static const std::vector<ShapeKind> all = {
      {"disc", {"radius"}, [](const SceneTable& t) { return Shape::planar_disc(size(t, "radius")); }},
      {"box",
       {"width", "height"},
       [](const SceneTable& t) { return Shape::box(size(t, "width"), size(t, "height")); }},
      {"polygon",
       {"vertices"},
       [](const SceneTable& t) {
         std::vector<Vector2> corners;
         for (const Vector3& x : vertices(t)) corners.push_back(x.head<2>());
         return Shape::polygon(corners);
       }},
      {"line", {}, [](const SceneTable&) { return Shape::line(); }},
  };
  return all;
}

/// Planar bodies have planar shapes; what never moves has those of the bodies that do.
bool planar(const SceneTable& root, const std::string& body) {
  bool any = false, all = true;
  for (const SceneTable& table : root.tables("body")) {
    const std::string kind = table.has("kind") ? table.text("kind") : "spatial";
    if (table.name() == body && kind != "prescribed") return kind == "planar";
    any = any || kind == "planar";
    all = all && (kind == "planar" || kind == "prescribed");
  }
  return any && all;
}

SceneShape read_shape(const SceneTable& root, const SceneTable& table) {
  std::string body = table.text("body");
  const bool flat = planar(root, body) || table.has("width");
  const std::vector<ShapeKind>& kinds = flat ? planar_kinds() : spatial_kinds();
  std::vector<std::string> names,
      keys{"body", "kind", "name", "position", "orientation", "angle", "material", "density"};
  for (const ShapeKind& kind : kinds) names.push_back(kind.name);
  const ShapeKind& kind = kinds[table.word("kind", names)];
  keys.insert(keys.end(), kind.keys.begin(), kind.keys.end());
  table.allow(keys);
  ShapeOptions options;
  options.name = table.name();
  if (table.has("material")) options.material = table.text("material");
  options.pose.p = table.vector("position", Dimension::Length, options.pose.p);
  if (table.has("orientation")) options.pose.q = table.orientation();
  if (table.has("angle")) {
    if (!flat || table.has("orientation"))
      table.refuse("angle", "an angle", "is for planar shapes, in place of an orientation");
    options.pose.q = rotation({0, 0, table.number("angle", Dimension::Angle)});
  }
  SceneShape read{
      table, std::move(body), table.placed([&] { return kind.make(table); }), std::move(options), {}};
  if (table.has("density")) read.density = table.number("density", Dimension::Any);
  return read;
}

void read_material_pair(const SceneTable& table, BodyShapes& shapes) {
  table.allow({"a", "b", "mu", "e", "torsion", "rolling"});
  const std::string a = table.text("a"), b = table.text("b");
  for (const auto& [key, name] : {std::pair("a", a), std::pair("b", b)})
    if (std::none_of(shapes.all().begin(), shapes.all().end(),
                     [&, wanted = name](const BodyShapes::Placed& s) { return s.material == wanted; }))
      table.refuse(key, "the material '" + name + "'", "needs to be that of a shape");
  const MaterialPair pair{.mu = table.number("mu", Dimension::None, 0),
                          .torsion = table.number("torsion", Dimension::Length, 0),
                          .rolling = table.number("rolling", Dimension::Length, 0),
                          .e = table.number("e", Dimension::None, 0)};
  table.placed([&] {
    shapes.set_friction(a, b, pair);
    return 0;
  });
}

/// A pair of bodies, or overlapping = "at the start": all pairs of shapes that do; returns whether it is that.
bool read_no_contact(const SceneTable& table, BodyShapes& shapes) {
  if (table.has("overlapping")) {
    table.allow({"overlapping"});
    (void)table.word("overlapping", {"at the start"});
    return true;
  }
  table.allow({"a", "b"});
  shapes.no_contact(table.body("a"), table.body("b"));
  return false;
}

}  // namespace

std::vector<SceneShape> read_shapes(const SceneTable& root) {
  std::vector<SceneShape> shapes;
  for (const SceneTable& table : root.tables("shape")) shapes.push_back(read_shape(root, table));
  return shapes;
}

MassProperties mass_by_shapes(const std::vector<SceneShape>& shapes, const SceneTable& body) {
  MassProperties mass;
  double reach = 0;
  for (const SceneShape& s : shapes) {
    if (s.body != body.name() || !s.density) continue;
    s.table.placed([&] {
      mass.add(s.shape, s.options.pose, *s.density);
      return 0;
    });
    reach = std::max(reach, s.shape.reach());
  }
  if (!(mass.mass > 0))
    body.refuse("mass", "a body without mass, and without shapes that have a density", "needs one of them");
  constexpr double rounding = 1e-9;  // of the size: positions that were typed with ten digits or more
  if (mass.centre.norm() > rounding * reach)
    body.refuse("mass", "the centre of mass of its shapes is at " + written(mass.centre),
                "needs to be the body's origin");
  return mass;
}

std::vector<std::string> connect_shapes(const SceneTable& root, const std::vector<SceneShape>& shapes,
                                        const State& start, Model& model) {
  BodyShapes placed;
  bool leave_out = false;
  for (const SceneTable& table : root.tables("no_contact"))
    leave_out = read_no_contact(table, placed) || leave_out;
  for (const SceneShape& s : shapes) {
    const BodyId id = s.table.body("body");
    s.table.placed([&] {
      placed.add(model, id, s.shape, s.options);
      return 0;
    });
  }
  for (const SceneTable& table : root.tables("material_pair")) read_material_pair(table, placed);
  if (shapes.empty()) return {};
  return shapes.front().table.placed([&] {  // a pair without a gap stands at the file's first shape
    std::vector<std::string> apart;
    if (leave_out) apart = placed.leave_out_overlapping(model, start);
    placed.add_contacts(model);
    return apart;
  });
}

}  // namespace perp
