#include "perp/model/recipe.hpp"

#include <catch2/catch.hpp>

#include "perp/model/gaps.hpp"

using namespace perp;

TEST_CASE("a gap says its maker and all that it was given", "[recipe]") {
  const Plane slope{{1, 0, 2}, {3, 4, 5}};
  const Recipe recipe = sphere_on_plane(0.5, slope).recipe();
  CHECK(recipe.maker == "sphere_on_plane");
  CHECK(recipe.numbers ==
        std::vector<double>{0.5, 1, 0, 2, 3, 4, 5});  // the normal as given, not as normalised
  CHECK(disc_on_line(0.5).recipe().maker == "disc_on_line");
  CHECK(box_on_box({1, 2, 3}, {4, 5, 6}).recipe().numbers == std::vector<double>{1, 2, 3, 4, 5, 6});
  const Gap own = [](const Pose&, const Pose&, double) { return ContactPoint{}; };
  CHECK_FALSE(own.recipe().known());
}

TEST_CASE("a sphere meets the faces, edges and corners of a box", "[gap]") {
  const Gap gap = sphere_on_box(0.1, {2, 1, 0.4});
  const auto at = [&](const Vector3& centre, const Pose& box = {}) {
    ContactPoint c;
    gap(box, {box * centre, Quaternion::Identity()}, 0, std::span(&c, 1));
    return c;
  };
  CHECK(at({0.3, 0.2, 0.5}).gap == Approx(0.2));
  CHECK(at({0.3, 0.2, 0.5}).normal == Vector3::UnitZ());
  CHECK(at({1.3, 0, 0.6}).gap == Approx(0.4));  // 3-4-5 from the edge x = 1, z = 0.2
  CHECK(at({1.3, 0, 0.6}).normal.isApprox(Vector3(0.6, 0, 0.8)));
  CHECK(at({1.3, 0, 0.6}).point.isApprox(Vector3(1.24, 0, 0.52)));
  CHECK(at({-1.2, -0.7, -0.3}).gap == Approx(0.3 - 0.1));  // 1-2-2 from the corner
  CHECK(at({0.3, 0.2, 0.15}).gap == Approx(-0.15));        // inside: out through the top
  CHECK(at({0.3, 0.2, -0.15}).normal == Vector3(0, 0, -1));
  CHECK_THROWS_WITH(sphere_on_box(0.1, {1, 0, 1}), Catch::Contains("size is 0"));

  const Pose turned{{1, 2, 3}, rotation({0.3, 0.2, 0.1})};
  CHECK(at({1.3, 0, 0.6}, turned).gap == Approx(0.4));
  for (const Vector3& place :
       {Vector3(0, 0, 0.5), Vector3(1.3, 0, 0.6), Vector3(1.3, 0.9, 0.6), Vector3(-1.5, 0, 0)}) {
    GapCheckOptions options;
    options.X_WB.p = place;
    options.spread = 0.02;
    CHECK(check_gap(gap, options).passed);
  }
}

TEST_CASE("a point of a body keeps its distance from a plane as the body turns", "[gap]") {
  const Gap gap = point_on_plane({0.5, 0, -1}, {{0, 0, 2}, {0, 0, 0.1}});
  ContactPoint c;
  gap({}, {{0, 0, 1}, rotation({0, M_PI / 2, 0})}, 0, std::span(&c, 1));  // x to -z, z to x
  CHECK(c.gap == Approx(1 - 0.5 - 0.1));
  CHECK(c.point.isApprox(Vector3(-1, 0, 0.5)));
  CHECK(check_gap(gap).passed);
}
