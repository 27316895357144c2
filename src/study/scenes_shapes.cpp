// Bodies that are known by their shapes alone, and find their contacts themselves.
#include <cmath>

#include "study/scene_parts.hpp"

namespace perp {
namespace {

std::string numbered(const char* name, int i) { return name + ("-" + std::to_string(i)); }

/// A box of the ground, by the centre of its upper face.
void add_step(Model& model, const std::string& name, const Vector3& top, const Vector3& size) {
  model.add_shape(ground, Shape::box(size),
                  {.pose = {.p = top - Vector3(0, 0, size.z() / 2)}, .material = "ground", .name = name});
}

}  // namespace

Scene dominoes(Parameters& set) {
  const double mu = set.number("mu", 0.3, "friction coefficient [-]", not_negative);
  const int count = set.count("count", 20, "dominoes [-]", 1, 1000);
  const double spacing = set.number("spacing", 0.02, "from one to the next [m]", positive);
  const double push =
      set.number("push", 6, "angular velocity of the first about its edge [rad/s]", not_negative);
  const Vector3 size(0.0075, 0.024, 0.048);
  Scene s;
  s.id = "dominoes";
  s.what = "The first domino of a row is tipped over, and they all fall";
  s.model.add_shape(ground, Shape::half_space(), {.material = "ground"});
  for (int i = 0; i < count; ++i)
    s.model.add_body(Shape::box(size), {.density = 900,
                                        .material = "domino",
                                        .name = numbered("domino", i + 1),
                                        .pose = {.p = {i * spacing, 0, size.z() / 2}}});
  s.model.set_friction("ground", "domino", {.mu = mu});
  s.model.set_friction("domino", "domino", {.mu = mu});
  s.start = s.model.rest();
  const Vector3 w(0, push, 0), from_edge(-size.x() / 2, 0, size.z() / 2);
  s.model.set_velocity(s.start, {1}, w.cross(from_edge), w);
  return s;
}

Scene stairs(Parameters& set) {
  const double mu = set.number("mu", 0.4, "friction coefficient [-]", not_negative);
  const double e = set.number("e", 0.2, "restitution [-]", fraction);
  const double v0 = set.number("v0", 2.5, "initial velocity along x [m/s]", not_negative);
  const double tread = 0.3, rise = 0.15;
  const Vector3 size(0.12, 0.1, 0.08);
  const int count = 5;
  Scene s;
  s.id = "stairs";
  s.what = "A box slides off a landing and tumbles down five stairs";
  s.t_end = 2;
  s.model.add_shape(ground, Shape::half_space(), {.material = "ground", .name = "floor"});
  for (int i = 0; i < count; ++i) {
    const double height = rise * (count - i), length = i == 0 ? 1 : tread;
    add_step(s.model, numbered("stair", i + 1), {i * tread + (i == 0 ? -0.5 : -0.5 * tread), 0, height},
             {length, 1, height});
  }
  s.model.add_body(Shape::box(size), {.density = 600,
                                      .material = "box",
                                      .name = "box",
                                      .pose = {.p = {-0.3, 0, rise * count + size.z() / 2}}});
  s.model.set_friction("ground", "box", {.mu = mu, .e = e});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, {1}, {v0, 0, 0});
  return s;
}

/// Two cards lean on each other, the right one a little more: it is as high and so a little longer, and its upper edge lies against the left
/// one's face, just below the edge of that. Both carry the ceiling. Two cards that met edge to edge would have no normal.
Scene card_house(Parameters& set) {
  const double mu = set.number("mu", 0.6, "friction coefficient [-]", not_negative);
  const double lean = set.number("lean", 0.22, "of the left cards from the vertical [rad]", {0.05, 0.5});
  const int storeys = set.count("storeys", 3, "storeys [-]", 1, 10);
  const double length = 0.09, width = 0.06, thick = 0.001, density = 800;
  const double more = lean + 0.04, top = length * std::cos(lean) + thick * std::sin(lean);
  const double longer = (top - thick * std::sin(more)) / std::cos(more);
  const double along_left = longer * std::cos(more) / std::cos(lean);  // to the right card's edge
  const double right_foot = along_left * std::sin(lean) + longer * std::sin(more);
  const double spacing = right_foot + 0.01;
  Scene s;
  s.id = "card-house";
  s.what = "A house of cards stands by friction";
  s.t_end = 2;
  s.model.add_shape(ground, Shape::half_space(), {.material = "ground"});
  // a card whose inner lower edge is at x, leaning by `angle`, its inner face towards +x where `sign` is 1
  const auto card = [&](const std::string& name, double x, double z, double angle, double sign, double along,
                        double across) {
    const Vector3 up(sign * std::sin(angle), 0, std::cos(angle)),
        inwards(sign * std::cos(angle), 0, -std::sin(angle));
    const Vector3 centre = Vector3(x, 0, z) + along / 2 * up - thick / 2 * inwards;
    s.model.add_body(Shape::box({thick, across, along}), {.density = density,
                                                          .material = "card",
                                                          .name = name,
                                                          .pose = {centre, rotation({0, sign * angle, 0})}});
  };
  double z = 0;
  for (int storey = storeys; storey >= 1; --storey) {
    const double first = -0.5 * spacing * storey;
    for (int i = 0; i < storey; ++i) {
      const std::string name = std::to_string(storeys - storey + 1) + "-" + std::to_string(i + 1);
      card("left-" + name, first + i * spacing, z, lean, 1, length, width);
      card("right-" + name, first + i * spacing + right_foot, z, more, -1, longer, 0.9 * width);
    }
    if (storey == 1) break;
    z += top;
    const double ridge = first + length * std::sin(lean);
    const double span = (storey - 1) * spacing + 0.06;
    s.model.add_body(Shape::box({span, 1.1 * width, thick}),
                     {.density = density,
                      .material = "card",
                      .name = numbered("ceiling", storeys - storey + 1),
                      .pose = {.p = {ridge + 0.5 * (storey - 1) * spacing, 0, z + thick / 2}}});
    z += thick;
  }
  s.model.set_friction("ground", "card", {.mu = mu});
  s.model.set_friction("card", "card", {.mu = mu});
  s.start = s.model.rest();
  return s;
}

Scene coin(Parameters& set) {
  const double mu = set.number("mu", 0.3, "friction coefficient [-]", not_negative);
  const double e = set.number("e", 0, "restitution [-]", fraction);
  const double tilt = set.number("tilt", 0.3, "of the coin at the start [rad]", {-1.5, 1.5});
  Scene s;
  s.id = "coin";
  s.what = "A coin is dropped tilted and ends up lying flat";
  s.t_end = 3;
  s.model.add_shape(ground, Shape::half_space(), {.material = "ground"});
  s.model.add_body(
      Shape::cylinder(0.012, 0.002),
      {.density = 8800, .material = "coin", .name = "coin", .pose = {{0, 0, 0.02}, rotation({0, tilt, 0})}});
  s.model.set_friction("ground", "coin", {.mu = mu, .e = e});
  s.start = s.model.rest();
  return s;
}

Scene cone(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double tilt = set.number("tilt", 0.5, "of its axis at the start [rad]", {-3, 3});
  const int corners = set.count("corners", 12, "of its base [-]", 3, 100);
  const double radius = 0.05, height = 0.12;
  std::vector<Vector3> points{{0, 0, height}};
  for (int k = 0; k < corners; ++k)
    points.emplace_back(radius * std::cos(2 * pi * k / corners), radius * std::sin(2 * pi * k / corners), 0);
  Scene s;
  s.id = "cone";
  s.what = "A cone dropped tilted comes to rest on its base, or on its side";
  s.t_end = 2;
  s.model.add_shape(ground, Shape::half_space(), {.material = "ground"});
  s.model.add_body(
      Shape::polyhedron(points),
      {.density = 700, .material = "cone", .name = "cone", .pose = {{0, 0, 0.08}, rotation({0, tilt, 0})}});
  s.model.set_friction("ground", "cone", {.mu = mu});
  s.start = s.model.rest();
  return s;
}

Scene tetrahedra(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const int count = set.count("count", 10, "tetrahedra [-]", 1, 1000);
  const double edge = 0.1, half = 0.14;
  const double a = edge / std::sqrt(8.0);
  const Shape tetrahedron = Shape::polyhedron({{a, a, a}, {a, -a, -a}, {-a, a, -a}, {-a, -a, a}});
  Scene s;
  s.id = "tetrahedra";
  s.what = "Tetrahedra dropped into a box settle";
  s.t_end = 2;
  add_box_around(s.model, half, "ground");
  for (int i = 0; i < count; ++i) {  // four a layer, each turned in a way that never repeats
    const double x = i % 2 == 0 ? -half / 2 : half / 2, y = i / 2 % 2 == 0 ? -half / 2 : half / 2;
    s.model.add_body(tetrahedron,
                     {.density = 1000,
                      .material = "glass",
                      .name = numbered("tetrahedron", i + 1),
                      .pose = {{x, y, 0.07 + 0.13 * (i / 4)}, rotation({1.7 * i, 0.9 * i + 0.3, 2.3 * i})}});
  }
  s.model.set_friction("ground", "glass", {.mu = mu});
  s.model.set_friction("glass", "glass", {.mu = mu});
  s.start = s.model.rest();
  return s;
}

Scene chute(Parameters& set) {
  const double mu = set.number("mu", 0.2, "friction coefficient [-]", not_negative);
  const double slope = set.number("slope", 0.6, "of the chute [rad]", {0, 1.2});
  const int count = set.count("count", 6, "parcels [-]", 1, 100);
  Scene s;
  s.id = "chute";
  s.what = "Parcels and balls slide down a chute between its walls, onto a floor";
  s.t_end = 2;
  const double length = 1.5, width = 0.3, thick = 0.05;
  const Quaternion down = rotation({0, slope, 0});
  const Vector3 along = down * Vector3::UnitX(), up = down * Vector3::UnitZ();
  const Vector3 end(0, 0, 0.1), middle = end - length / 2 * along;  // of its upper face
  const auto plank = [&](const char* name, const Vector3& centre, const Vector3& size) {
    s.model.add_shape(ground, Shape::box(size), {.pose = {centre, down}, .material = "ground", .name = name});
  };
  s.model.add_shape(ground, Shape::half_space(), {.material = "ground", .name = "floor"});
  plank("bed", middle - thick / 2 * up, {length, width, thick});
  for (const double side : {-1.0, 1.0})
    plank(side < 0 ? "right" : "left", middle + side * (width + thick) / 2 * Vector3::UnitY() + 0.1 * up,
          {length, thick, 0.2});
  for (int i = 0; i < count; ++i) {
    const bool ball = i % 3 == 2;
    const double half = 0.04;
    const Vector3 place =
        end - (0.4 + 0.15 * i) * along + (half + 0.002) * up + 0.05 * std::sin(2.0 * i) * Vector3::UnitY();
    s.model.add_body(ball ? Shape::sphere(half) : Shape::box({2.5 * half, 2 * half, 2 * half}),
                     {.density = 300,
                      .material = "parcel",
                      .name = numbered(ball ? "ball" : "parcel", i + 1),
                      .pose = {place, down * rotation({0, 0, 0.3 * std::cos(3.0 * i)})}});
  }
  s.model.set_friction("ground", "parcel", {.mu = mu});
  s.model.set_friction("parcel", "parcel", {.mu = mu});
  s.start = s.model.rest();
  return s;
}

}  // namespace perp
