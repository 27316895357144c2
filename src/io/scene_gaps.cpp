#include "io/scene_gaps.hpp"

#include <algorithm>
#include <array>

#include "io/scene_text.hpp"

namespace perp {
namespace {

/// The arguments of a gap's maker, in its order.
struct Sizes {
  const std::vector<double>& x;
  double number(std::size_t i) const { return x[i]; }
  Vector3 vector(std::size_t i) const { return {x[i], x[i + 1], x[i + 2]}; }
  Plane plane(std::size_t i) const { return {vector(i), vector(i + 3)}; }
};

struct Size {
  std::string key;
  std::size_t numbers = 1;             ///< 1 or 3
  std::vector<double> otherwise = {};  ///< empty: must be given
};
using SizeList = std::vector<Size>;

struct GapKind {
  std::string name;
  SizeList sizes;
  Gap (*make)(const Sizes&);
};

SizeList with_plane(SizeList sizes, const Plane& plane) {
  const Vector3 &n = plane.normal, &p = plane.point;
  sizes.push_back({"normal", 3, {n.x(), n.y(), n.z()}});
  sizes.push_back({"point", 3, {p.x(), p.y(), p.z()}});
  return sizes;
}

SizeList and_then(SizeList sizes, const Size& last) {
  sizes.push_back(last);
  return sizes;
}

const std::vector<GapKind>& kinds() {
  const Plane floor, line = horizontal_line;
  static const std::vector<GapKind> all = {
      {"sphere_on_plane", with_plane({{"radius"}}, floor),
       [](const Sizes& s) { return sphere_on_plane(s.number(0), s.plane(1)); }},
      {"particle_on_plane", with_plane({}, floor),
       [](const Sizes& s) { return particle_on_plane(s.plane(0)); }},
      {"point_on_plane", with_plane({{"foot", 3}}, floor),
       [](const Sizes& s) { return point_on_plane(s.vector(0), s.plane(3)); }},
      {"capsule_on_plane", with_plane({{"radius"}, {"length"}}, floor),
       [](const Sizes& s) { return capsule_on_plane(s.number(0), s.number(1), s.plane(2)); }},
      {"box_on_plane", with_plane({{"size", 3}}, floor),
       [](const Sizes& s) { return box_on_plane(s.vector(0), s.plane(3)); }},
      {"ellipsoid_on_plane", and_then(with_plane({{"semi_axes", 3}}, floor), {"centre", 3, {0, 0, 0}}),
       [](const Sizes& s) { return ellipsoid_on_plane(s.vector(0), s.plane(3), s.vector(9)); }},
      {"disc_on_plane", with_plane({{"radius"}}, floor),
       [](const Sizes& s) { return disc_on_plane(s.number(0), s.plane(1)); }},
      {"sphere_in_cylinder",
       {{"radius_a"}, {"radius_b"}, {"axis", 3, {0, 0, 1}}, {"point", 3, {0, 0, 0}}},
       [](const Sizes& s) { return sphere_in_cylinder(s.number(0), s.number(1), s.vector(2), s.vector(5)); }},
      {"sphere_on_sphere",
       {{"radius_a"}, {"radius_b"}},
       [](const Sizes& s) { return sphere_on_sphere(s.number(0), s.number(1)); }},
      {"sphere_in_sphere",
       {{"radius_a"}, {"radius_b"}},
       [](const Sizes& s) { return sphere_in_sphere(s.number(0), s.number(1)); }},
      {"sphere_on_box",
       {{"radius"}, {"size", 3}},
       [](const Sizes& s) { return sphere_on_box(s.number(0), s.vector(1)); }},
      {"box_on_box",
       {{"size_a", 3}, {"size_b", 3}},
       [](const Sizes& s) { return box_on_box(s.vector(0), s.vector(3)); }},
      {"disc_on_line", with_plane({{"radius"}}, line),
       [](const Sizes& s) { return disc_on_line(s.number(0), s.plane(1)); }},
      {"disc_in_circle",
       {{"radius_circle"}, {"radius_disc"}},
       [](const Sizes& s) { return disc_in_circle(s.number(0), s.number(1)); }},
      {"particle_in_circle", {{"radius"}}, [](const Sizes& s) { return particle_in_circle(s.number(0)); }},
      {"ellipse_on_line", with_plane({{"a"}, {"b"}}, line),
       [](const Sizes& s) { return ellipse_on_line(s.number(0), s.number(1), s.plane(2)); }},
      {"rectangle_on_rectangle",
       {{"width_a"}, {"height_a"}, {"width_b"}, {"height_b"}},
       [](const Sizes& s) {
         return rectangle_on_rectangle({s.number(0), s.number(1)}, {s.number(2), s.number(3)});
       }},
      {"box_on_line", with_plane({{"width"}, {"height"}}, line),
       [](const Sizes& s) { return box_on_line(s.number(0), s.number(1), s.plane(2)); }},
  };
  return all;
}

/// place_a, place_b: where a shape sits in its body.
Pose read_place(const SceneTable& gap, std::string_view key) {
  Pose X;
  if (!gap.has(key)) return X;
  const SceneTable table = gap.table(key);
  table.allow({"position", "orientation"});
  X.p = table.vector("position", Dimension::Length, X.p);
  if (table.has("orientation")) X.q = table.orientation();
  return X;
}

std::string write_place(const Pose& X) {
  InlineTable table;
  table.add("position", written(X.p));
  const std::array wxyz{X.q.w(), X.q.x(), X.q.y(), X.q.z()};
  table.add("orientation", written(wxyz));
  return table.text();
}

}  // namespace

Gap read_gap(const SceneTable& table) {
  std::vector<std::string> names, keys{"kind", "place_a", "place_b"};
  for (const GapKind& kind : kinds()) names.push_back(kind.name);
  const GapKind& kind = kinds()[table.word("kind", names)];
  for (const Size& size : kind.sizes) keys.push_back(size.key);
  table.allow(keys);
  std::vector<double> x;
  for (const Size& size : kind.sizes) {
    if (!table.has(size.key) && !size.otherwise.empty()) {
      x.insert(x.end(), size.otherwise.begin(), size.otherwise.end());
    } else if (size.numbers == 1) {
      x.push_back(table.number(size.key, Dimension::Length));
    } else {
      const Vector3 v = table.vector(
          size.key, size.key == "normal" || size.key == "axis" ? Dimension::None : Dimension::Length);
      x.insert(x.end(), v.begin(), v.end());
    }
  }
  Gap gap = table.placed([&] { return kind.make({x}); });
  if (!table.has("place_a") && !table.has("place_b")) return gap;
  return placed(gap, read_place(table, "place_a"), read_place(table, "place_b"));
}

std::string write_gap(const Recipe& recipe) {
  const auto kind =
      std::find_if(kinds().begin(), kinds().end(), [&](const GapKind& k) { return k.name == recipe.maker; });
  InlineTable table;
  table.add("kind", in_quotes(recipe.maker));
  std::size_t at = 0;
  for (const Size& size : kind->sizes) {
    const std::span<const double> numbers(recipe.numbers.data() + at, size.numbers);
    if (!std::equal(numbers.begin(), numbers.end(), size.otherwise.begin(), size.otherwise.end(), same_bits))
      table.add(size.key, written(numbers));
    at += size.numbers;
  }
  for (std::size_t i = 0; i < recipe.places.size(); ++i)
    table.add(i == 0 ? "place_a" : "place_b", write_place(recipe.places[i]));
  return table.text();
}

}  // namespace perp
