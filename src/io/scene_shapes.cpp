#include "io/scene_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "io/mesh_file.hpp"
#include "io/scene_text.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

using Kind = Shape::Kind;

std::vector<Vector3> vertices(const SceneTable& table) {
  const TomlValue::Entry* entry = table.toml().find("vertices");
  const std::size_t count = entry == nullptr ? 1 : std::max<std::size_t>(1, entry->value.items.size());
  return table.vectors("vertices", count, Dimension::Length);
}

double size(const SceneTable& table, const char* key) { return table.number(key, Dimension::Length); }

/// A file's path is from the scene's own folder; what became of the mesh is said by its hull.
Shape hull_of_file(const SceneTable& table) {
  if (table.has("vertices")) table.refuse("vertices", "vertices beside a file", "needs one of the two");
  const std::filesystem::path scene(table.source().file);
  return Shape::polyhedron(read_mesh(scene.parent_path() / table.text("file")).points);
}

/// f(x, y, z) with its exact gradient.
Shape formula(const SceneTable& table, double scale) {
  const auto f = std::make_shared<const Expression>(table.expression("f", {"x", "y", "z"}, Dimension::Any));
  ImplicitSurface surface;
  surface.f = [f](const Vector3& x) { return (*f)(std::span(x.data(), 3)); };
  surface.gradient = [f](const Vector3& x) -> Vector3 {
    const std::span<const double> at(x.data(), 3);
    return {f->derivative(at, 0), f->derivative(at, 1), f->derivative(at, 2)};
  };
  if (!(scale > 0) && !table.has("scale"))
    table.refuse("scale", "a formula in a file without a shape that ends",
                 "needs a length of the surface [m]");
  surface.size = table.number("scale", Dimension::Length, scale);
  surface.text = f->text();
  return Shape::formula(std::move(surface));
}

/// The file's word for a kind (Shape::name), the keys of its sizes with how many numbers each has, and its maker.
struct ShapeKind {
  Kind kind;
  std::string name;
  std::vector<std::pair<std::string, int>> keys;
  Shape (*make)(const SceneTable&);
};

const std::vector<ShapeKind>& spatial_kinds() {
  static const std::vector<ShapeKind> all = {
      {Kind::Sphere,
       "sphere",
       {{"radius", 1}},
       [](const SceneTable& t) { return Shape::sphere(size(t, "radius")); }},
      {Kind::HalfSpace, "half_space", {}, [](const SceneTable&) { return Shape::half_space(); }},
      {Kind::Box,
       "box",
       {{"size", 3}},
       [](const SceneTable& t) { return Shape::box(t.vector("size", Dimension::Length)); }},
      {Kind::Capsule,
       "capsule",
       {{"radius", 1}, {"length", 1}},
       [](const SceneTable& t) { return Shape::capsule(size(t, "radius"), size(t, "length")); }},
      {Kind::Cylinder,
       "cylinder",
       {{"radius", 1}, {"length", 1}},
       [](const SceneTable& t) { return Shape::cylinder(size(t, "radius"), size(t, "length")); }},
      {Kind::Disc,
       "disc",
       {{"radius", 1}},
       [](const SceneTable& t) { return Shape::disc(size(t, "radius")); }},
      {Kind::Ellipsoid,
       "ellipsoid",
       {{"semi_axes", 3}},
       [](const SceneTable& t) { return Shape::ellipsoid(t.vector("semi_axes", Dimension::Length)); }},
      {Kind::Superquadric,
       "superquadric",
       {{"semi_axes", 3}, {"exponents", 2}},
       [](const SceneTable& t) {
         const std::vector<double> e = t.numbers("exponents", 2, 2, Dimension::None);
         return Shape::superquadric(t.vector("semi_axes", Dimension::Length), {e[0], e[1]});
       }},
      {Kind::Polyhedron,
       "polyhedron",
       {{"vertices", 0}, {"file", 0}},
       [](const SceneTable& t) { return t.has("file") ? hull_of_file(t) : Shape::polyhedron(vertices(t)); }},
      {Kind::HollowSphere,
       "hollow_sphere",
       {{"radius", 1}},
       [](const SceneTable& t) { return Shape::hollow_sphere(size(t, "radius")); }},
      {Kind::HollowCylinder,
       "hollow_cylinder",
       {{"radius", 1}},
       [](const SceneTable& t) { return Shape::hollow_cylinder(size(t, "radius")); }},
      {Kind::Formula,
       "formula",
       {{"f", 0}, {"scale", 1}},
       [](const SceneTable& t) { return formula(t, size(t, "scale")); }},
  };
  return all;
}

const std::vector<ShapeKind>& planar_kinds() {
  static const std::vector<ShapeKind> all = {
      {Kind::PlanarDisc,
       "disc",
       {{"radius", 1}},
       [](const SceneTable& t) { return Shape::planar_disc(size(t, "radius")); }},
      {Kind::PlanarBox,
       "box",
       {{"width", 1}, {"height", 1}},
       [](const SceneTable& t) { return Shape::box(size(t, "width"), size(t, "height")); }},
      {Kind::Polygon,
       "polygon",
       {{"vertices", 0}},
       [](const SceneTable& t) {
         std::vector<Vector2> corners;
         for (const Vector3& x : vertices(t)) corners.push_back(x.head<2>());
         return Shape::polygon(corners);
       }},
      {Kind::Ellipse,
       "ellipse",
       {{"a", 1}, {"b", 1}},
       [](const SceneTable& t) { return Shape::ellipse(size(t, "a"), size(t, "b")); }},
      {Kind::Line, "line", {}, [](const SceneTable&) { return Shape::line(); }},
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

/// `scale` is for a formula that has none.
SceneShape read_shape(const SceneTable& root, const SceneTable& table, double scale) {
  std::string body = table.text("body");
  const bool flat = planar(root, body) || table.has("width");
  const std::vector<ShapeKind>& kinds = flat ? planar_kinds() : spatial_kinds();
  std::vector<std::string> names,
      keys{"body", "kind", "name", "position", "orientation", "angle", "material", "density"};
  for (const ShapeKind& kind : kinds) names.push_back(kind.name);
  const ShapeKind& kind = kinds[table.word("kind", names)];
  for (const auto& [key, count] : kind.keys) keys.push_back(key);
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
      table,
      std::move(body),
      table.placed([&] { return kind.kind == Kind::Formula ? formula(table, scale) : kind.make(table); }),
      std::move(options),
      {}};
  if (table.has("density")) read.density = table.number("density", Dimension::Any);
  return read;
}

void read_material_pair(const SceneTable& table, Model& model) {
  table.allow({"a", "b", "mu", "e", "torsion", "rolling"});
  const std::string a = table.text("a"), b = table.text("b");
  for (const auto& [key, name] : {std::pair("a", a), std::pair("b", b)})
    if (std::none_of(model.shapes().begin(), model.shapes().end(),
                     [&, wanted = name](const BodyShape& s) { return s.material == wanted; }))
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

/// Of [[no_contact]]: a pair of bodies; a pair of shapes, BODY.SHAPE each; or overlapping = "at the start": all pairs of shapes that do.
enum class Apart { Bodies, Shapes, Overlapping };

Apart kind_of(const SceneTable& table) {
  if (table.has("overlapping")) {
    table.allow({"overlapping"});
    (void)table.word("overlapping", {"at the start"});
    return Apart::Overlapping;
  }
  table.allow({"a", "b"});
  const bool a = table.text("a").find('.') != std::string::npos,
             b = table.text("b").find('.') != std::string::npos;
  if (a != b)
    table.refuse("b", "'" + table.text("b") + "' beside '" + table.text("a") + "'",
                 "needs two bodies, or two shapes as BODY.SHAPE");
  return a ? Apart::Shapes : Apart::Bodies;
}

ShapeId shape_of(const SceneTable& table, const char* key, const Model& model) {
  const std::string& text = table.text(key);
  const std::size_t dot = text.find('.');
  try {
    return model.find_shape(model.find_body(text.substr(0, dot)), text.substr(dot + 1));
  } catch (const std::invalid_argument& error) {
    table.refuse(key, "the shape '" + text + "'", error.what());
  }
}

const ShapeKind& words_of(const Shape& shape) {
  const std::vector<ShapeKind>& kinds = shape.planar() ? planar_kinds() : spatial_kinds();
  return *std::find_if(kinds.begin(), kinds.end(),
                       [&](const ShapeKind& kind) { return kind.kind == shape.kind(); });
}

/// Whether a reader would take the shape for what it is: see `planar`.
bool told_by_its_body(const Model& model, const BodyShape& s) {
  const auto moves_in_plane = [](const Body& b) { return b.kind == BodyKind::Planar; };
  const Body& body = model.body(s.body);
  if (body.nv > 0) return true;
  const bool any = std::any_of(model.bodies().begin(), model.bodies().end(), moves_in_plane);
  const bool all = std::all_of(model.bodies().begin(), model.bodies().end(),
                               [&](const Body& b) { return b.nv == 0 || moves_in_plane(b); });
  return s.shape.planar() == (any && all);
}

std::string listed(const std::vector<Vector3>& vertices, bool planar) {
  std::string text = "[";
  for (const Vector3& x : vertices) {
    if (text.size() > 1) text += ", ";
    text += planar ? written(std::span(x.data(), 2)) : written(x);
  }
  return text + "]";
}

std::string write_shape(const Model& model, const BodyShape& s) {
  const ShapeKind& words = words_of(s.shape);
  std::string text = "\n[[shape]]\nbody = " + in_quotes(model.body(s.body).name) +
                     "\nkind = " + in_quotes(words.name) + "\nname = " + in_quotes(s.name) + "\n";
  const double* next = s.shape.sizes().data();
  if (s.shape.kind() == Kind::Formula) next = &s.shape.surface().size;
  for (const auto& [key, count] : words.keys) {
    if (key == "file") continue;  // its vertices are there
    text += key + " = ";
    if (key == "f") text += in_quotes(s.shape.surface().text);
    if (key == "vertices") text += listed(s.shape.vertices(), s.shape.planar());
    if (count == 1) text += shortest(*next);
    if (count > 1) text += written(std::span(next, static_cast<std::size_t>(count)));
    text += "\n";
    next += count;
  }
  if (!s.pose.p.isZero(0)) text += "position = " + written(s.pose.p) + "\n";
  const std::array<double, 4> q{s.pose.q.w(), s.pose.q.x(), s.pose.q.y(), s.pose.q.z()};
  if (q != std::array<double, 4>{1, 0, 0, 0}) text += "orientation = " + written(q) + "\n";
  if (!s.material.empty()) text += "material = " + in_quotes(s.material) + "\n";
  return text;
}

std::string write_pair(const std::string& table, const std::string& a, const std::string& b) {
  return "\n[[" + table + "]]\na = " + in_quotes(a) + "\nb = " + in_quotes(b) + "\n";
}

}  // namespace

std::vector<SceneShape> read_shapes(const SceneTable& root) {
  const std::vector<SceneTable> tables = root.tables("shape");
  const auto is_formula = [](const SceneTable& table) {
    return table.has("kind") && table.text("kind") == "formula";
  };
  std::vector<SceneShape> shapes;
  double scale = 0;  // of the largest shape that ends
  for (const SceneTable& table : tables) {
    if (is_formula(table)) continue;
    shapes.push_back(read_shape(root, table, 0));
    if (const double reach = shapes.back().shape.reach(); std::isfinite(reach))
      scale = std::max(scale, reach);
  }
  for (std::size_t i = 0; i < tables.size(); ++i)  // in the file's order
    if (is_formula(tables[i]))
      shapes.insert(shapes.begin() + static_cast<std::ptrdiff_t>(i), read_shape(root, tables[i], scale));
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

std::vector<std::string> add_shapes(const SceneTable& root, const std::vector<SceneShape>& shapes,
                                    const State& start, Model& model) {
  const std::vector<SceneTable> apart = root.tables("no_contact");
  for (const SceneTable& table : apart)
    if (kind_of(table) == Apart::Bodies) model.no_contact(table.body("a"), table.body("b"));
  for (const SceneShape& s : shapes) {
    const BodyId id = s.table.body("body");
    s.table.placed([&] { return model.add_shape(id, s.shape, s.options); });
  }
  std::vector<std::string> left_out;
  for (const SceneTable& table : apart) {
    if (kind_of(table) == Apart::Shapes)
      model.no_contact(shape_of(table, "a", model), shape_of(table, "b", model));
    if (kind_of(table) == Apart::Overlapping) left_out = model.leave_out_overlapping(start);
  }
  for (const SceneTable& table : root.tables("material_pair")) read_material_pair(table, model);
  return left_out;
}

std::string write_shapes(const Model& model, const std::function<void(const std::string&)>& cannot_say) {
  std::string text;
  for (const BodyShape& s : model.shapes()) {
    if (!told_by_its_body(model, s))
      cannot_say("planar shape '" + s.name + "' of '" + model.body(s.body).name + "' among spatial bodies");
    if (s.shape.kind() == Kind::Formula && s.shape.surface().text.empty())
      cannot_say("surface of shape '" + s.name + "' of '" + model.body(s.body).name + "'");
    text += write_shape(model, s);
  }
  const auto there = [&](const std::string& material) {
    return std::any_of(model.shapes().begin(), model.shapes().end(),
                       [&](const BodyShape& s) { return s.material == material; });
  };
  for (const auto& [materials, law] : model.materials()) {
    if (!there(materials.first) || !there(materials.second)) continue;
    text += write_pair("material_pair", materials.first, materials.second);
    if (law.mu != 0) text += "mu = " + shortest(law.mu) + "\n";
    if (law.torsion != 0) text += "torsion = " + shortest(law.torsion) + "\n";
    if (law.rolling != 0) text += "rolling = " + shortest(law.rolling) + "\n";
    if (law.e != 0) text += "e = " + shortest(law.e) + "\n";
  }
  for (const auto& [a, b] : model.bodies_apart())
    text += write_pair("no_contact", model.body({a}).name, model.body({b}).name);
  const auto name = [&](int i) {
    const BodyShape& s = model.shapes()[static_cast<std::size_t>(i)];
    return model.body(s.body).name + "." + s.name;
  };
  for (const auto& [a, b] : model.shapes_apart()) text += write_pair("no_contact", name(a), name(b));
  return text;
}

}  // namespace perp
