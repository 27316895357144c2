#include "perp/model/shape.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "perp/model/model.hpp"

using namespace perp;
using Catch::Contains;

namespace {

/// Volume and moments by throwing points into the box about the shape.
void by_chance(const Shape& shape, double half, const std::function<bool(const Vector3&)>& inside, double tolerance) {
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
  by_chance(Shape::sphere(0.5), 0.5, [](const Vector3& x) { return x.norm() < 0.5; }, 0.01);
  by_chance(Shape::box({0.4, 0.6, 1}), 0.5,
            [](const Vector3& x) { return (x.cwiseAbs() - Vector3(0.2, 0.3, 0.5)).maxCoeff() < 0; }, 0.01);
  by_chance(Shape::capsule(0.2, 0.6), 0.5,
            [](const Vector3& x) { return (x - Vector3(0, 0, std::clamp(x.z(), -0.3, 0.3))).norm() < 0.2; }, 0.02);
  by_chance(Shape::cylinder(0.4, 0.8), 0.5,
            [](const Vector3& x) { return std::hypot(x.x(), x.y()) < 0.4 && std::abs(x.z()) < 0.4; }, 0.01);
  by_chance(Shape::ellipsoid({0.5, 0.3, 0.2}), 0.5,
            [](const Vector3& x) { return x.cwiseQuotient(Vector3(0.5, 0.3, 0.2)).norm() < 1; }, 0.02);
}

TEST_CASE("a polyhedron is the hull of its points about its centre of volume", "[shape]") {
  std::vector<Vector3> points{{1, 1, 1}};  // within
  for (unsigned i = 0; i < 8; ++i) points.emplace_back((i & 1U) != 0 ? 2 : 0, (i & 2U) != 0 ? 4 : 0, (i & 4U) != 0 ? 6 : 0);
  const Shape hull = Shape::polyhedron(points), box = Shape::box({2, 4, 6});
  CHECK(hull.vertices().size() == 8);
  CHECK(hull.faces().size() == 6);
  CHECK(hull.centre().isApprox(Vector3(1, 2, 3)));
  CHECK(hull.volume() == Approx(48));
  CHECK(hull.moments().isApprox(box.moments(), 1e-12));
  CHECK(hull.support({1, 1, 1}).isApprox(Vector3(1, 2, 3)));
  CHECK_THROWS_WITH(Shape::polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), Contains("3 points"));
  CHECK_THROWS_WITH(Shape::polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), Contains("flat"));
  CHECK_THROWS_WITH(Shape::polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, std::nan("")}}), Contains("not finite"));
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
  Model model;
  CHECK_THROWS_WITH(model.add_body(Shape::box({1, 1, 1}), {}), Contains("density is 0"));
  CHECK_THROWS_WITH(model.add_body(Shape::half_space(), {.density = 1}), Contains("no volume of its own"));
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

TEST_CASE("bodies with shapes touch by default, joined and listed ones do not", "[shape]") {
  Model model;
  const BodyId brick = model.add_body(Shape::box({0.2, 0.1, 0.02}), {.density = 2400, .material = "clay", .name = "brick"});
  CHECK(model.body(brick).mass == Approx(0.96));
  model.add_shape(ground, Shape::half_space(), {.material = "floor"});
  model.set_friction("floor", "clay", {.mu = 0.4, .e = 0.2});
  REQUIRE(model.contacts().size() == 1);
  const Contact& c = model.contacts()[0];
  CHECK(c.name == "ground.half_space|brick.box");
  CHECK(c.a == ground);
  CHECK(c.mu == 0.4);
  CHECK(c.e == 0.2);
  CHECK(c.tangents == 2);
  CHECK((*model.point_names())[3] == "ground.half_space|brick.box|b3");

  const BodyId ball = model.add_body(Shape::sphere(0.1), {.density = 1000, .name = "ball"});
  REQUIRE(model.contacts().size() == 3);
  model.add_joint(perp::ball(brick, ball, {.point = {0, 0, 1}}));
  int on = 0;
  for (const Contact& contact : model.contacts()) on += contact.off ? 0 : 1;
  CHECK(on == 2);
  model.no_contact(ground, ball);
  CHECK(model.find_contact("ground.half_space|ball.sphere").index >= 0);
  CHECK(model.contacts()[static_cast<std::size_t>(model.find_contact("ground.half_space|ball.sphere").index)].off);
  CHECK_THROWS_WITH(model.add_shape(brick, Shape::line()), Contains("spatial shape"));
  CHECK_THROWS_WITH(model.set_friction("a", "b", {.mu = -1}), Contains("mu is -1"));
}

TEST_CASE("pairs of shapes that overlap at the start can be left out, and only these", "[shape]") {
  Model model;
  const BodyId a = model.add_body(Shape::sphere(1), {.density = 1, .name = "a"});
  const BodyId b = model.add_body(Shape::sphere(1), {.density = 1, .name = "b"});
  const BodyId c = model.add_body(Shape::sphere(1), {.density = 1, .name = "c"});
  State x = model.rest();
  model.set_position(x, b, {1.5, 0, 0});
  model.set_position(x, c, {3.5, 0, 0});
  CHECK(model.leave_out_overlapping(x) == std::vector<std::string>{"a.sphere|b.sphere"});
  (void)a;
}
