// Boxes, a table and a heap of balls: most of them should stay where they are.
#include <algorithm>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {

Scene table(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double x = 0.4, y = 0.3, h = 0.5;  // the feet, from the centre of mass
  Scene s;
  s.id = "C3";
  s.what = "A table stands on four legs, whose twelve forces six equations do not tell apart";
  s.t_end = 10;
  const BodyId body =
      s.model.add_body(Inertia::solid_box(1, {1, 0.8, 0.1}), {.pose = {.p = {0, 0, h}}, .name = "table"});
  const char* names[] = {"front-left", "front-right", "back-right", "back-left"};
  const Vector3 feet[] = {{-x, -y, -h}, {x, -y, -h}, {x, y, -h}, {-x, y, -h}};
  for (int i = 0; i < 4; ++i)
    s.model.add_contact(ground, body, point_on_plane(feet[i]), {.mu = mu, .name = names[i]});
  s.start = s.model.rest();
  stays(s);
  return s;
}

Scene stack(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double ratio = set.number("ratio", 1000, "mass of the top box over that of the others [-]", positive);
  const int count = set.count("count", 2, "boxes [-]", 1, 1000);
  const Vector3 size(1, 1, 1);
  Scene s;
  s.id = "C5";
  s.what = "A stack of boxes of 1 kg under a heavier one stands";
  BodyId below = ground;
  for (int i = 0; i < count; ++i) {
    const BodyId box =
        s.model.add_body(Inertia::solid_box(i + 1 < count ? 1 : ratio, size),
                         {.pose = {.p = {0, 0, 0.5 + i}}, .name = "box-" + std::to_string(i + 1)});
    s.model.add_contact(below, box, i == 0 ? box_on_plane(size) : box_on_box(size, size),
                        {.mu = mu, .name = i == 0 ? "floor" : "joint-" + std::to_string(i)});
    below = box;
  }
  s.start = s.model.rest();
  stays(s);
  return s;
}

void add_box_around(Model& model, double half, const std::string& material) {
  const auto wall = [&](const char* name, const Vector3& normal, double distance) {
    model.add_shape(ground, Shape::half_space(),
                    {.pose = {-distance * normal, Quaternion::FromTwoVectors(Vector3::UnitZ(), normal)},
                     .material = material,
                     .name = name});
  };
  wall("floor", Vector3::UnitZ(), 0);
  wall("west", Vector3::UnitX(), half);
  wall("east", -Vector3::UnitX(), half);
  wall("south", Vector3::UnitY(), half);
  wall("north", -Vector3::UnitY(), half);
}

Scene pile(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const int count = set.count("count", 50, "balls [-]", 1, 20000);
  const double r = 0.5;
  const int side = std::max(1, int(std::lround(std::cbrt(count))));  // balls along each edge of the box
  Scene s;
  s.id = "pile";
  s.what = "Balls dropped into a box settle";
  const double half = 1.1 * r * side;
  add_box_around(s.model, half, "box");
  for (int i = 0; i < count; ++i) {  // in layers, each ball off its place by a little that never repeats
    const int column = i % side, row = i / side % side, layer = i / (side * side);
    const Vector3 lattice(2.2 * r * (column - 0.5 * (side - 1)), 2.2 * r * (row - 0.5 * (side - 1)),
                          r * (1.1 + 2.2 * layer));
    const Vector3 off = 0.08 * r * Vector3(std::sin(1.7 * i), std::cos(2.3 * i), 0);
    const BodyId ball = s.model.add_body(
        Inertia::solid_sphere(1, r), {.pose = {.p = lattice + off}, .name = "ball-" + std::to_string(i + 1)});
    s.model.add_shape(ball, Shape::sphere(r), {.material = "ball"});
  }
  s.model.set_friction("ball", "ball", {.mu = mu});
  s.model.set_friction("ball", "box", {.mu = mu});
  s.start = s.model.rest();
  return s;
}

Scene sunk_box(Parameters& set) {
  const double depth = set.number("depth", 0.1, "of the box in the floor at the start [m]", not_negative);
  const Vector3 size(1, 1, 1);
  Scene s;
  s.id = "C14";
  s.what = "A box that starts inside the floor";
  const BodyId box =
      s.model.add_body(Inertia::solid_box(1, size), {.pose = {.p = {0, 0, 0.5 - depth}}, .name = "box"});
  s.model.add_contact(ground, box, box_on_plane(size), {.mu = 0.5, .name = "floor"});
  s.start = s.model.rest();
  return s;
}

Scene creep(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double theta = set.number("theta", pi / 9, "slope [rad]", {0, 1.57});
  const Vector3 size(1, 1, 1);
  Scene s;
  s.id = "C17";
  s.what = "A box that friction holds on a slope does not creep";
  s.t_end = 100;
  s.model.set_gravity({g * std::sin(theta), 0, -g * std::cos(theta)});
  const BodyId box =
      s.model.add_body(Inertia::solid_box(1, size), {.pose = {.p = {0, 0, 0.5}}, .name = "box"});
  s.model.add_contact(ground, box, box_on_plane(size), {.mu = mu, .name = "slope"});
  s.start = s.model.rest();
  if (std::tan(theta) <= mu && std::tan(theta) <= 1) stays(s);  // neither slides nor tips
  return s;
}

Scene sliding_cube(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double v0 = set.number("v0", 6, "initial velocity along x [m/s]", not_negative);
  const double edge = 0.1;
  Scene s;
  s.id = "C20";
  s.what = "A cube slides to rest and stays flat on the floor";
  s.t_end = 1.5;
  const BodyId cube = s.model.add_body(Inertia::solid_box(1, edge * Vector3::Ones()),
                                       {.pose = {.p = {0, 0, edge / 2}}, .name = "cube"});
  s.model.add_contact(ground, cube, box_on_plane(edge * Vector3::Ones()), {.mu = mu, .name = "floor"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, cube, {v0, 0, 0});

  if (mu >= 1) return s;  // it tips
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Real a = Real(mu) * g, slid = mu > 0 ? std::min(t, v0 / a) : t;
    model.set_position(x, cube, {double(slid * (v0 - a * slid / 2)), 0, edge / 2});
    model.set_velocity(x, cube, {double(v0 - a * slid), 0, 0});
  });
  return s;
}

}  // namespace perp
