#include "perp/model/shape.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "perp/instant/instant.hpp"

using namespace perp;
using Catch::Contains;

namespace {

/// Volume and moments by throwing points into the box about the shape.
void by_chance(const Shape& shape, double half, const std::function<bool(const Vector3&)>& inside,
               double tolerance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-half, half);
  const int count = 400000;
  double volume = 0;
  Matrix3 J = Matrix3::Zero();
  for (int i = 0; i < count; ++i) {
    const Vector3 x(uniform(random), uniform(random), uniform(random));
    if (!inside(x)) continue;
    volume += 1;
    J += x.squaredNorm() * Matrix3::Identity() - x * x.transpose();
  }
  const double cell = 8 * half * half * half / count;
  CHECK(shape.volume() == Approx(cell * volume).epsilon(tolerance));
  CHECK((shape.moments() - cell * J).cwiseAbs().maxCoeff() < tolerance * shape.moments().trace());
}

}  // namespace

TEST_CASE("volume and moments of a shape are those of its points", "[shape]") {
  by_chance(
      Shape::sphere(0.5), 0.5, [](const Vector3& x) { return x.norm() < 0.5; }, 0.01);
  by_chance(
      Shape::box({0.4, 0.6, 1}), 0.5,
      [](const Vector3& x) { return (x.cwiseAbs() - Vector3(0.2, 0.3, 0.5)).maxCoeff() < 0; }, 0.01);
  by_chance(
      Shape::capsule(0.2, 0.6), 0.5,
      [](const Vector3& x) { return (x - Vector3(0, 0, std::clamp(x.z(), -0.3, 0.3))).norm() < 0.2; }, 0.02);
  by_chance(
      Shape::cylinder(0.4, 0.8), 0.5,
      [](const Vector3& x) { return std::hypot(x.x(), x.y()) < 0.4 && std::abs(x.z()) < 0.4; }, 0.01);
  by_chance(
      Shape::ellipsoid({0.5, 0.3, 0.2}), 0.5,
      [](const Vector3& x) { return x.cwiseQuotient(Vector3(0.5, 0.3, 0.2)).norm() < 1; }, 0.02);
  by_chance(
      Shape::superquadric({0.5, 0.3, 0.4}, {0.6, 1.4}), 0.5,
      [](const Vector3& x) {
        const Vector3 u = x.cwiseQuotient(Vector3(0.5, 0.3, 0.4)).cwiseAbs();
        return std::pow(std::pow(u.x(), 2 / 1.4) + std::pow(u.y(), 2 / 1.4), 1.4 / 0.6) +
                   std::pow(u.z(), 2 / 0.6) <
               1;
      },
      0.02);
  CHECK(Shape::ellipse(0.5, 0.2).volume() == Approx(M_PI * 0.1));
  CHECK(Shape::ellipse(0.5, 0.2).moments()(2, 2) == Approx(M_PI * 0.1 / 4 * 0.29));
}

TEST_CASE("a polyhedron is the hull of its points about its centre of volume", "[shape]") {
  std::vector<Vector3> points{{1, 1, 1}};  // within
  for (unsigned i = 0; i < 8; ++i)
    points.emplace_back((i & 1U) != 0 ? 2 : 0, (i & 2U) != 0 ? 4 : 0, (i & 4U) != 0 ? 6 : 0);
  const Shape hull = Shape::polyhedron(points), box = Shape::box({2, 4, 6});
  CHECK(hull.vertices().size() == 8);
  CHECK(hull.faces().size() == 6);
  CHECK(hull.centre().isApprox(Vector3(1, 2, 3)));
  CHECK(hull.volume() == Approx(48));
  CHECK(hull.moments().isApprox(box.moments(), 1e-12));
  CHECK(hull.support({1, 1, 1}).isApprox(Vector3(1, 2, 3)));
  CHECK_THROWS_WITH(Shape::polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), Contains("3 points"));
  CHECK_THROWS_WITH(Shape::polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), Contains("flat"));
  CHECK_THROWS_WITH(Shape::polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, std::nan("")}}),
                    Contains("not finite"));
}

TEST_CASE("a polygon is the hull of its corners", "[shape]") {
  const Shape p = Shape::polygon({{0, 0}, {2, 0}, {1, 0.5}, {2, 3}, {0, 3}, {1, 0}});
  CHECK(p.vertices().size() == 4);
  CHECK(p.volume() == Approx(6));
  CHECK(p.centre().isApprox(Vector3(1, 1.5, 0)));
  CHECK(p.moments()(2, 2) == Approx(6.0 / 12 * (4 + 9)));
  CHECK_THROWS_WITH(Shape::polygon({{0, 0}, {1, 1}, {2, 2}}), Contains("corners"));
}

TEST_CASE("a size that no solid can have is named", "[shape]") {
  CHECK_THROWS_WITH(Shape::sphere(-1), Contains("Shape::sphere: radius is -1"));
  CHECK_THROWS_WITH(Shape::capsule(1, 0), Contains("length is 0"));
  CHECK_THROWS_WITH(Shape::box({1, 0, 1}), Contains("size is 0"));
  CHECK_THROWS_WITH(Shape::superquadric({1, 1, 1}, {0, 1}), Contains("exponents is 0"));
  CHECK_THROWS_WITH(Shape::ellipse(1, -1), Contains("b is -1"));
  CHECK_THROWS_WITH(Shape::formula({}), Contains("without f or gradient"));
  MassProperties mass;
  CHECK_THROWS_WITH(mass.add(Shape::box({1, 1, 1}), {}, 0), Contains("density is 0"));
  CHECK_THROWS_WITH(mass.add(Shape::half_space(), {}, 1), Contains("no volume of its own"));
}

TEST_CASE("masses of several shapes add up about their common centre", "[shape]") {
  MassProperties halves;
  halves.add(Shape::box({1, 2, 3}), {{0.5, 0, 0}, Quaternion::Identity()}, 2);
  halves.add(Shape::box({3, 2, 1}), {{1.5, 0, 0}, rotation({0, M_PI / 2, 0})}, 2);
  const Shape whole = Shape::box({2, 2, 3});
  CHECK(halves.mass == Approx(24));
  CHECK(halves.centre.isApprox(Vector3(1, 0, 0)));
  CHECK(halves.J.isApprox(2 * whole.moments(), 1e-12));
}

namespace {

/// Pairs of shapes that have a gap at x, in the model's order.
std::vector<std::string> meet(const Model& model, const State& x) {
  Instant now;
  evaluate(model, x, now);
  std::vector<std::string> all;
  for (const ContactInstant& c : now.contacts)
    if (const std::string name = model.contact_name(c.contact); all.empty() || all.back() != name)
      all.push_back(name);
  return all;
}

const Inertia some = Inertia::solid_sphere(1, 1);

}  // namespace

TEST_CASE("bodies with shapes touch by default, joined and listed ones do not", "[shape]") {
  Model model;
  const BodyId brick = model.add_body(some, {.name = "brick"}), ball = model.add_body(some, {.name = "ball"}),
               peg = model.add_body(some, {.name = "peg"});
  model.add_shape(brick, Shape::box({0.2, 0.1, 0.02}), {.material = "clay"});
  model.add_shape(ball, Shape::sphere(0.1));
  model.add_shape(peg, Shape::capsule(0.1, 1));
  model.add_shape(ground, Shape::half_space(), {.material = "floor"});
  State x = model.rest();
  model.set_position(x, brick, {0, 0, 1});
  model.set_position(x, ball, {0, 1, 1});
  model.set_position(x, peg, {1, 0, 1});
  CHECK(meet(model, x).size() == 6);
  model.no_contact(ground, ball);
  model.add_joint(perp::ball(brick, peg, {.point = {0, 0, 1}}));
  CHECK(meet(model, x) == std::vector<std::string>{"brick.box|ball.sphere", "ball.sphere|peg.capsule",
                                                   "ground.half_space|brick.box",
                                                   "ground.half_space|peg.capsule"});
  model.set_friction("clay", "floor", {.mu = 0.4, .e = 0.2});
  Instant now;
  evaluate(model, x, now);
  for (const ContactInstant& c : now.contacts) {
    const std::string name = (*model.point_names())[static_cast<std::size_t>(c.point)];
    const bool floor = name.starts_with("ground.half_space|brick.box|");
    CHECK(c.mu == (floor ? 0.4 : 0));
    CHECK(c.e == (floor ? 0.2 : 0));
    CHECK(c.tangents == (floor ? 2 : 0));
  }
  model.add_shape(ball, Shape::sphere(0.2));
  CHECK(model.shapes().back().name == "sphere-2");
  CHECK(model.find_shape(ball, "sphere-2") == ShapeId{4});
}

TEST_CASE("a shape that a body cannot have changes nothing", "[shape]") {
  Model model;
  const BodyId brick = model.add_body(Shape::box({1, 1, 1}), {.density = 1, .name = "brick"});
  model.add_shape(ground, Shape::half_space());
  const BodyId bead = model.add_particle(1, {.name = "bead"});
  const int contacts = model.contact_count();
  CHECK_THROWS_WITH(model.add_shape(brick, Shape::sphere(1), {.name = "box"}),
                    Contains("taken already on 'brick'"));
  CHECK_THROWS_WITH(model.add_shape(brick, Shape::line()), Contains("spatial shape"));
  CHECK_THROWS_WITH(model.add_shape(bead, Shape::box({1, 1, 1})), Contains("only a sphere"));
  CHECK_THROWS_WITH(model.add_shape(brick, Shape::half_space(), {}),
                    Contains("half_space on 'brick', has no gap to the half_space on 'ground'"));
  CHECK_THROWS_WITH(model.add_shape({7}, Shape::sphere(1)), Contains("body is 7"));
  CHECK_THROWS_WITH(model.add_shape(brick, Shape::sphere(1), {.pose = {.p = {infinity, 0, 0}}}),
                    Contains("not finite"));
  CHECK_THROWS_WITH(model.add_body(Shape::half_space(), {.density = 1}), Contains("no volume"));
  CHECK_THROWS_WITH(model.add_body(Shape::sphere(1), {}), Contains("density is 0"));
  CHECK_THROWS_WITH(model.set_friction("a", "b", {.mu = -1}), Contains("mu is -1"));
  CHECK_THROWS_WITH(model.find_shape(brick, "sphere"), Contains("needs to be one of: box"));
  CHECK_THROWS_WITH(model.no_contact(brick, BodyId{7}), Contains("b is 7"));
  CHECK(model.shapes().size() == 2);
  CHECK(model.contact_count() == contacts);
}

TEST_CASE("a body made of a shape has its mass about its centre", "[shape]") {
  Model model;
  const BodyId brick = model.add_body(Shape::box({0.2, 0.1, 0.02}),
                                      {.density = 2400, .name = "brick", .pose = {.p = {1, 2, 3}}});
  CHECK(model.body(brick).mass == Approx(0.96));
  CHECK(model.body(brick).J(2, 2) == Approx(0.96 / 12 * (0.04 + 0.01)));
  CHECK(model.position(model.rest(), brick) == Vector3(1, 2, 3));
  const BodyId plate = model.add_body(Shape::box(0.2, 0.1), {.density = 50});
  CHECK(model.body(plate).kind == BodyKind::Planar);
  CHECK(model.body(plate).J(2, 2) == Approx(1.0 / 12 * (0.04 + 0.01)));
}

TEST_CASE("pairs of shapes that overlap at the start can be left out, and only these", "[shape]") {
  Model model;
  std::vector<BodyId> balls;
  for (const char* name : {"a", "b", "c"}) {
    balls.push_back(model.add_body(some, {.name = name}));
    model.add_shape(balls.back(), Shape::sphere(1));
  }
  State x = model.rest();
  model.set_position(x, balls[1], {1.5, 0, 0});
  model.set_position(x, balls[2], {3.5, 0, 0});
  CHECK(model.leave_out_overlapping(x) == std::vector<std::string>{"a.sphere|b.sphere"});
  CHECK(meet(model, x) == std::vector<std::string>{"a.sphere|c.sphere", "b.sphere|c.sphere"});
  model.no_contact(ShapeId{1}, ShapeId{2});
  CHECK(meet(model, x) == std::vector<std::string>{"a.sphere|c.sphere"});
}
