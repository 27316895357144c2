#include "io/scene_shapes.hpp"

#include <algorithm>
#include <array>
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
      {"capsule", {"radius", "length"},
       [](const SceneTable& t) { return Shape::capsule(size(t, "radius"), size(t, "length")); }},
      {"cylinder", {"radius", "length"},
       [](const SceneTable& t) { return Shape::cylinder(size(t, "radius"), size(t, "length")); }},
      {"disc", {"radius"}, [](const SceneTable& t) { return Shape::disc(size(t, "radius")); }},
      {"ellipsoid", {"semi_axes"},
       [](const SceneTable& t) { return Shape::ellipsoid(t.vector("semi_axes", Dimension::Length)); }},
      {"polyhedron", {"vertices"}, [](const SceneTable& t) { return Shape::polyhedron(vertices(t)); }},
      {"hollow_sphere", {"radius"}, [](const SceneTable& t) { return Shape::hollow_sphere(size(t, "radius")); }},
      {"hollow_cylinder", {"radius"}, [](const SceneTable& t) { return Shape::hollow_cylinder(size(t, "radius")); }},
  };
  return all;
}

const std::vector<ShapeKind>& planar_kinds() {
  static const std::vector<ShapeKind> all = {
      {"disc", {"radius"}, [](const SceneTable& t) { return Shape::planar_disc(size(t, "radius")); }},
      {"box", {"width", "height"}, [](const SceneTable& t) { return Shape::box(size(t, "width"), size(t, "height")); }},
      {"polygon", {"vertices"},
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
  std::vector<std::string> names, keys{"body", "kind", "name", "position", "orientation", "angle", "material", "density"};
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
  SceneShape read{table, std::move(body), table.placed([&] { return kind.make(table); }), std::move(options), {}};
  if (table.has("density")) read.density = table.number("density", Dimension::Any);
  return read;
}

std::string sizes_of(const Shape& shape) {
  std::string text;
  const auto line = [&](std::string_view key, const std::string& value) {
    text.append(key).append(" = ").append(value).append("\n");
  };
  const std::vector<double>& s = shape.sizes();
  switch (shape.kind()) {
    case Kind::Box:
      line("size", written(s));
      break;
    case Kind::Ellipsoid:
      line("semi_axes", written(s));
      break;
    case Kind::PlanarBox:
      line("width", shortest(s[0]));
      line("height", shortest(s[1]));
      break;
    case Kind::Polyhedron:
    case Kind::Polygon: {
      std::string list;
      for (const Vector3& x : shape.vertices())
        list += (list.empty() ? "" : ", ") + (shape.planar() ? written(std::span(x.data(), 2)) : written(x));
      line("vertices", "[" + list + "]");
      break;
    }
    case Kind::HalfSpace:
    case Kind::Line:
      break;
    default:
      line("radius", shortest(s[0]));
      if (s.size() > 1) line("length", shortest(s[1]));
  }
  return text;
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
    body.refuse("mass", "the centre of mass of its shapes is at " + written(mass.centre), "needs to be the body's origin");
  return mass;
}

void read_material_pair(const SceneTable& table, Model& model) {
  table.allow({"a", "b", "mu", "e", "torsion", "rolling"});
  const std::string a = table.text("a"), b = table.text("b");
  for (const auto& [key, name] : {std::pair("a", a), std::pair("b", b)})
    if (std::none_of(model.shapes().begin(), model.shapes().end(), [&](const BodyShape& s) { return s.material == name; }))
      table.refuse(key, "the material '" + name + "'", "needs to be that of a shape");
  const MaterialPair pair{.mu = table.number("mu", Dimension::None, 0),
                          .torsion = table.number("torsion", Dimension::Length, 0),
                          .rolling = table.number("rolling", Dimension::Length, 0),
                          .e = table.number("e", Dimension::None, 0)};
  table.placed([&] {
    model.set_friction(a, b, pair);
    return 0;
  });
}

std::string write_shapes(const Model& model) {
  std::string text;
  const auto line = [&](std::string_view key, const std::string& value) {
    text.append(key).append(" = ").append(value).append("\n");
  };
  for (const BodyShape& s : model.shapes()) {
    text += "\n[[shape]]\n";
    line("body", in_quotes(model.body(s.body).name));
    line("kind", in_quotes(s.shape.name()));
    line("name", in_quotes(s.name));
    text += sizes_of(s.shape);
    if (!s.pose.p.isZero(0)) line("position", written(s.pose.p));
    const std::array wxyz{s.pose.q.w(), s.pose.q.x(), s.pose.q.y(), s.pose.q.z()};
    if (wxyz != std::array{1.0, 0.0, 0.0, 0.0}) line("orientation", written(wxyz));
    if (!s.material.empty()) line("material", in_quotes(s.material));
  }
  for (const auto& [materials, pair] : model.materials()) {
    text += "\n[[material_pair]]\n";
    line("a", in_quotes(materials.first));
    line("b", in_quotes(materials.second));
    line("mu", shortest(pair.mu));
    if (pair.e != 0) line("e", shortest(pair.e));
  }
  for (const auto& [a, b] : model.apart()) {
    const bool joined = std::any_of(model.joints().begin(), model.joints().end(), [&](const JointGeometry& j) {
      return std::minmax(j.a.index, j.b.index) == std::minmax(a, b);
    });
    if (joined) continue;
    text += "\n[[no_contact]]\n";
    line("a", in_quotes(model.bodies()[static_cast<std::size_t>(a)].name));
    line("b", in_quotes(model.bodies()[static_cast<std::size_t>(b)].name));
  }
  return text;
}

}  // namespace perp
