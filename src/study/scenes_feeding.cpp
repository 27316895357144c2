// Machines that bring parts into place by contact alone: a feeder's track, a fixture.
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/model/timing.hpp"
#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// A rectangle of a planar body, by its centre.
struct Plate {
  const char* name;
  double width, height, x, y;
};

/// A planar body of rectangles, whose centre of mass is at its origin.
BodyId add_plates(Model& model, const std::string& name, double density, const std::vector<Plate>& plates) {
  double mass = 0, J = 0;
  for (const Plate& p : plates) {
    const double m = density * p.width * p.height;
    mass += m;
    J += m * ((p.width * p.width + p.height * p.height) / 12 + p.x * p.x + p.y * p.y);
  }
  const BodyId body = model.add_planar_body(mass, J, {.name = name});
  for (const Plate& p : plates)
    model.add_shape(body, Shape::box(p.width, p.height),
                    {.pose = {.p = {p.x, p.y, 0}}, .material = "part", .name = p.name});
  return body;
}

/// A piece of track on the ground: its upper face from x to x + length at the height y, both its ends bevelled.
void add_track(Model& model, const std::string& name, double x, double y, double length, double bevel) {
  const double half = length / 2, depth = 0.02;
  const double below =
      (half * depth * depth - bevel * bevel * bevel / 48) /
      (2 * half * depth - bevel * bevel / 4);  // of the centroid, where a polygon has its origin
  model.add_shape(ground,
                  Shape::polygon({{-half, -depth},
                                  {half, -depth},
                                  {half, -bevel / 4},
                                  {half - bevel, 0},
                                  {bevel - half, 0},
                                  {-half, -bevel / 4}}),
                  {.pose = {.p = {x + half, y - below, 0}}, .material = "track", .name = name});
}

}  // namespace

/// What trips is the part's leading edge, which sinks into a slot: of a part on its base never, since half of its width bridges it.
Scene feeder(Parameters& set) {
  const double mu = set.number("mu", 0.25, "friction between part and track [-]", not_negative);
  const double e = set.number("e", 0, "restitution [-]", fraction);
  const double incline = set.number("incline", 25 * pi / 180, "of the track [rad]", acute);
  const double slot = set.number("slot", 0.014, "width of the slots [m]", {0.001, 0.05});
  const double sink = set.number("sink", 0.004, "their depth [m]", {0.0005, 0.02});
  const double turn = set.number("turn", 0, "angle at which the part is dropped [rad]; 0: right way up");
  const double start_x = set.number("start_x", 0, "where [m]", {-0.2, 0.02});
  const double drop = set.number("drop", 0.005, "from how high [m]", not_negative);
  constexpr double width = 0.03, height = 0.02, wall = 0.0025;
  constexpr double first = 0.06, pitch = 0.08, step_down = 0.0003, bevel = 0.002;
  constexpr int slots = 4;
  Scene s;
  s.id = "feeder";
  s.what =
      "Cup-shaped parts slide down a track with slots, over which those that lie wrong trip until they stand "
      "right";
  s.t_end = 1.6;
  s.model.set_gravity(g * Vector3(std::sin(incline), -std::cos(incline), 0));  // x along the track
  const double base = width * wall, walls = 2 * (height - wall) * wall;
  const double rise =
      (base * wall / 2 + walls * (height + wall) / 2) / (base + walls);  // of the centre of mass
  const double side = (width - wall) / 2, middle = (height + wall) / 2 - rise;
  const BodyId cup = add_plates(s.model, "cup", 20,
                                {{"base", width, wall, 0, wall / 2 - rise},
                                 {"left", wall, height - wall, -side, middle},
                                 {"right", wall, height - wall, side, middle}});
  s.model.add_shape(ground, Shape::box(0.3, 0.02),
                    {.pose = {.p = {first - 0.15, -0.01, 0}}, .material = "track", .name = "entry"});
  add_track(s.model, "exit", first + slot + pitch * (slots - 1), -step_down * slots, 5, bevel);
  for (int i = 1; i < slots; ++i)
    add_track(s.model, "piece-" + std::to_string(i), first + slot + pitch * (i - 1), -step_down * i,
              pitch - slot, bevel);
  for (int i = 1; i <= slots; ++i)
    s.model.add_shape(
        ground, Shape::box(slot, 0.01),
        {.pose = {.p = {first + slot / 2 + pitch * (i - 1), -step_down * (i - 1) - sink - 0.005, 0}},
         .material = "track",
         .name = "slot-" + std::to_string(i)});
  s.model.set_friction("part", "track", {.mu = mu, .e = e});
  s.start = s.model.rest();
  s.model.set_position(s.start, cup, {start_x, drop + std::hypot(width / 2, height), 0});
  s.model.set_orientation(s.start, cup, rotation({0, 0, turn}));
  return s;
}

namespace {

/// A force along -axis on a body from a time on, at a point of it.
void add_clamp(Model& model, BodyId body, int axis, const Vector3& at, double push, double from) {
  const Vector3 force = -push * Vector3::Unit(axis);
  std::vector<std::string> texts(6, "0");
  texts[static_cast<std::size_t>(axis)] = "-" + shortest(push) + "*step(t - " + shortest(from) + ")";
  model.add_force(body,
                  Timed<Wrench(const Model&, const State&)>(
                      [=](const Model& m, const State& x) {
                        if (x.t < from) return Wrench{};
                        return Wrench{force, (m.pose(x, body).q * at).cross(force)};
                      },
                      Timing{.steady = false, .times = {from}}),
                  {"expressions", {at.x(), at.y(), at.z()}, texts});
}

}  // namespace

Scene fixture(Parameters& set) {
  const double mu = set.number("mu", 0.1, "friction between part and locators [-]", not_negative);
  const double table = set.number("table", 0.2, "friction between part and table [-]", not_negative);
  const double push = set.number("push", 8, "force of each clamp [N]", not_negative);
  const double order = set.number(
      "order", 0, "0: the clamp against the two locators first, 1: that against the single one first",
      fraction);
  const double off_x =
      set.number("off_x", 0.003, "where the part is put down, from where it seats [m]", {-0.02, 0.02});
  const double off_y = set.number("off_y", 0.002, "likewise along y [m]", {-0.02, 0.02});
  const double turn = set.number("turn", 2 * pi / 180, "and its angle [rad]", {-0.3, 0.3});
  const double radius = set.number("radius", 0.005, "of the locators [m]", positive);
  const Vector3 size(0.1, 0.06, 0.02);
  Scene s;
  s.id = "fixture";
  s.what =
      "A part on a table is pushed against three locators by two clamps, one after the other, and seats or "
      "does not";
  s.t_end = 1.2;
  const BodyId part = s.model.add_body(
      Shape::box(size),
      {.density = 2700, .material = "part", .name = "part", .pose = {.p = {0, 0, size.z() / 2}}});
  s.model.add_shape(ground, Shape::half_space(), {.material = "table", .name = "table"});
  const auto locator = [&](const char* name, double x, double y) {
    s.model.add_shape(ground, Shape::sphere(radius),
                      {.pose = {.p = {x, y, size.z() / 2}}, .material = "locator", .name = name});
  };
  locator("left", -0.035, -size.y() / 2 - radius);
  locator("right", 0.035, -size.y() / 2 - radius);
  locator("end", -size.x() / 2 - radius, 0.01);
  s.model.set_friction("part", "table", {.mu = table});
  s.model.set_friction("part", "locator", {.mu = mu});
  add_clamp(s.model, part, 1, {0.01, size.y() / 2, 0}, push, 0.1 + 0.5 * order);
  add_clamp(s.model, part, 0, {size.x() / 2, 0, 0}, push, 0.6 - 0.5 * order);
  s.start = s.model.rest();
  s.model.set_position(s.start, part, {off_x, off_y, size.z() / 2});
  s.model.set_orientation(s.start, part, rotation({0, 0, turn}));
  return s;
}

}  // namespace perp
