#include "perp/model/gaps.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "perp/model/differentiable_gap.hpp"
#include "tests/model/random_poses.hpp"

using namespace perp;
using Catch::Contains;

namespace {

Pose at(double x, double y, double z, const Vector3& angle = Vector3::Zero()) {
  return {{x, y, z}, rotation(angle)};
}

struct Named {
  const char* name;
  Gap gap;
  Pose X_WB;
};

}  // namespace

TEST_CASE("every built-in gap changes at the rate that its normal and point promise", "[gaps]") {
  const Plane tilted{{0.2, -0.1, 1}, {0.1, 0.2, 0.3}};
  const std::vector<Named> gaps = {
      {"particle_on_plane", particle_on_plane(tilted), at(0, 0, 1)},
      {"sphere_on_plane", sphere_on_plane(0.4, tilted), at(0, 0, 1)},
      {"sphere_on_sphere", sphere_on_sphere(0.4, 0.3), at(0.3, 0.5, 0.6)},
      {"sphere_in_sphere", sphere_in_sphere(2, 0.5), at(0.3, 0.5, 0.6)},
      {"capsule_on_plane", capsule_on_plane(0.2, 0.8, tilted), at(0, 0, 1, {1, 0.3, 0})},
      {"box_on_plane", box_on_plane({0.4, 0.6, 0.8}, tilted), at(0, 0, 1, {0.4, 0.3, 0.2})},
      {"ellipsoid_on_plane", ellipsoid_on_plane({0.5, 0.3, 0.2}, tilted), at(0, 0, 1, {0.4, 0.3, 0.2})},
      {"ellipsoid_on_plane, off its centre", ellipsoid_on_plane({0.5, 0.3, 0.2}, tilted, {0.1, 0.2, 0.3}),
       at(0, 0, 1, {0.4, 0.3, 0.2})},
      {"disc_on_plane", disc_on_plane(0.5, tilted), at(0, 0, 1, {0.4, 0.3, 0.2})},
      {"sphere_in_cylinder", sphere_in_cylinder(2, 0.5, {0.3, 0.2, 1}, {0.1, 0.2, 0}), at(0.3, 0.5, 0.6)},
      {"sphere_on_box, face", sphere_on_box(0.3, {1, 2, 3}), at(0.1, 0.2, 2)},
      {"sphere_on_box, edge", sphere_on_box(0.3, {1, 2, 3}), at(0.9, 1.5, 0.2)},
      {"sphere_on_box, corner", sphere_on_box(0.3, {1, 2, 3}), at(-0.9, 1.5, 2)},
      {"ellipsoid_on_plane, placed",
       placed(ellipsoid_on_plane({0.5, 0.3, 0.2}), at(0, 0, 0.3, {0.2, 0.1, 0}),
              at(0.3, 0.1, 0.2, {0.4, 1, 0})),
       at(0, 0, 1, {0.4, 0.3, 0.2})},
      {"sphere_on_box, placed",
       placed(sphere_on_box(0.3, {1, 2, 3}), at(0.2, 0, 0, {0, 0, 1}), at(0.3, 0.1, 0)), at(0.1, 0.2, 2)},
      {"disc_on_line", disc_on_line(0.4), at(0, 1, 0)},
      {"box_on_line", box_on_line(0.4, 0.6), at(0, 1, 0)},
  };
  for (const Named& g : gaps) {
    CAPTURE(g.name);
    GapCheckOptions options;
    options.X_WB = g.X_WB;
    const GapCheck check = check_gap(g.gap, options);
    CAPTURE(check.rate_error, check.normal_length_error, check.time_error);
    CHECK(check.passed);
  }
}

TEST_CASE("a placed gap is the gap between shapes at their places", "[gaps]") {
  const Gap gap = placed(sphere_on_sphere(0.5, 0.25), at(0, 2, 0), at(1, 0, 0));
  const ContactPoint c =
      points(gap, at(0, 0, 0, {0, 0, M_PI / 2}), at(3, 0, 0))[0];  // centres (-2, 0, 0), (4, 0, 0)
  CHECK(c.gap == Approx(5.25));
  CHECK((c.normal - Vector3::UnitX()).norm() < 1e-15);
  CHECK((c.point - Vector3(3.75, 0, 0)).norm() < 1e-15);
  CHECK(gap.lever_a() == 2);
  CHECK(gap.lever_b() == 1);
  CHECK(gap.recipe().known());
  CHECK_FALSE(placed(gap, {}, {}).recipe().known());
  CHECK_THROWS_AS(placed(gap, at(NAN, 0, 0), {}), std::invalid_argument);
}

TEST_CASE("gaps measure the distance along the normal from A to B", "[gaps]") {
  const ContactPoint floor = points(sphere_on_plane(0.5), {}, at(3, 4, 0.7))[0];
  CHECK(floor.gap == Approx(0.2));
  CHECK(floor.normal == Vector3::UnitZ());
  CHECK((floor.point - Vector3(3, 4, 0.2)).norm() < 1e-15);

  const ContactPoint outside = points(sphere_on_sphere(1, 0.5), {}, at(0, 2, 0))[0];
  CHECK(outside.gap == Approx(0.5));
  CHECK(outside.normal == Vector3::UnitY());
  CHECK((outside.point - Vector3(0, 1.5, 0)).norm() < 1e-15);

  const ContactPoint inside = points(sphere_in_sphere(1, 0.25), {}, at(0, 0.5, 0))[0];
  CHECK(inside.gap == Approx(0.25));
  CHECK(inside.normal == -Vector3::UnitY());
  CHECK((inside.point - Vector3(0, 0.75, 0)).norm() < 1e-15);

  const ContactPoint ring = points(disc_in_circle(1, 0.2), {}, at(0.6, 0, 0))[0];
  CHECK(ring.gap == Approx(0.2));
  CHECK(ring.normal == -Vector3::UnitX());

  const ContactPoint bead = points(particle_in_circle(1), {}, at(0.6, 0, 5))[0];
  CHECK(bead.gap == Approx(0.4));  // a tube along z
  CHECK(bead.normal == -Vector3::UnitX());
}

TEST_CASE("the lowest point of a disc's rim is where it slopes down, and along -x where it lies flat",
          "[gaps]") {
  const double tilt = 0.3;
  const ContactPoint rolling = points(disc_on_plane(2), {}, at(0, 0, 1, {tilt, 0, 0}))[0];
  CHECK(rolling.gap == Approx(1 - 2 * std::sin(tilt)));
  CHECK((rolling.point - Vector3(0, -2 * std::cos(tilt), 1 - 2 * std::sin(tilt))).norm() < 1e-15);
  const ContactPoint flat = points(disc_on_plane(2), {}, at(0, 0, 1))[0];
  CHECK(flat.gap == 1);
  CHECK(flat.point == Vector3(-2, 0, 1));
  std::vector<ContactDerivative> d(9);
  disc_on_plane(2).differentiate({}, at(0, 0, 1), 0, d);
  CHECK(d[0].point.allFinite());
}

TEST_CASE("an ellipsoid may lie about another point than its body's origin", "[gaps]") {
  const ContactPoint low = points(ellipsoid_on_plane({3, 2, 1}, {}, {0.5, 0, 0.25}), {}, at(0, 0, 1))[0];
  CHECK(low.gap == Approx(0.25));
  CHECK((low.point - Vector3(0.5, 0, 0.25)).norm() < 1e-15);
}

TEST_CASE("a box on a plane has its eight corners, a planar box its four", "[gaps]") {
  const auto corners = points(box_on_plane({2, 4, 6}), {}, at(0, 0, 3.5));
  REQUIRE(corners.size() == 8);
  for (std::size_t i = 0; i < 8; ++i) CHECK(corners[i].gap == Approx(i < 4 ? 0.5 : 6.5));
  const auto planar = points(box_on_line(2, 4), {}, at(0, 2.5, 0));
  REQUIRE(planar.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(planar[i].gap == Approx(i < 2 ? 0.5 : 4.5));
}

TEST_CASE("box on box touches at the corners of the overlap", "[gaps]") {
  const auto near = [](const Gap& gap, const Pose& X_WB, double most) {
    std::vector<ContactPoint> all;
    for (const ContactPoint& c : points(gap, {}, X_WB))
      if (c.gap < most) all.push_back(c);
    return all;
  };
  const Gap cubes = box_on_box({1, 1, 1}, {1, 1, 1});
  SECTION("aligned boxes of one size have four corners there") {
    const auto c = near(cubes, at(0, 0, 1.25), 0.5);
    CHECK(c.size() == 4);
    for (const ContactPoint& p : c) {
      CHECK(p.gap == Approx(0.25));
      CHECK(std::abs(std::abs(p.point.x()) - 0.5) < 1e-15);
      CHECK(std::abs(std::abs(p.point.y()) - 0.5) < 1e-15);
    }
  }
  SECTION("turned by 45 degrees a square on its like overlaps in an octagon") {
    const double side = 1, corner = side / 2 * (std::sqrt(2.0) - 1);  // half of the octagon's edge
    const auto c = near(cubes, at(0, 0, 1, {0, 0, std::atan(1)}), 0.1);
    CHECK(c.size() == 8);
    for (const ContactPoint& p : c) {
      CHECK(std::min(std::abs(p.point.x()), std::abs(p.point.y())) == Approx(corner));
      CHECK(std::abs(p.normal.z()) == Approx(1));
    }
  }
  SECTION("an overhanging block is carried by the overlap alone") {
    const auto c = near(box_on_box({2, 2, 1}, {2, 2, 1}), at(1.5, 0, 1), 0.1);
    CHECK(c.size() == 4);
    for (const ContactPoint& p : c) CHECK((p.point.x() == Approx(0.5) || p.point.x() == Approx(1)));
  }
  SECTION("side by side they touch with their sides") {
    const auto c = near(cubes, at(3, 0.25, 0), 2.1);
    CHECK(c.size() == 4);
    for (const ContactPoint& p : c) {
      CHECK(p.gap == Approx(2));
      CHECK(p.normal == Vector3::UnitX());
    }
  }
  SECTION("an edge over an edge has the distance of their crossing") {
    const auto c = near(cubes, at(1.2, 0, 1.2, {0, 0, 0}), 0.5);
    REQUIRE_FALSE(c.empty());
    for (const ContactPoint& p : c) CHECK(p.gap == Approx(0.2 * std::sqrt(2.0)));
  }
}

TEST_CASE("lengths of gaps that are not positive are named", "[gaps]") {
  CHECK_THROWS_WITH(sphere_on_plane(0), Contains("sphere_on_plane") && Contains("radius is 0"));
  CHECK_THROWS_WITH(sphere_in_sphere(1, 1), Contains("radius_a - radius_b is 0"));
  CHECK_THROWS_WITH(box_on_plane({1, -1, 1}), Contains("size is -1"));
  CHECK_THROWS_WITH(capsule_on_plane(1, not_set), Contains("length is nan"));
  CHECK_THROWS_WITH(sphere_on_plane(1, {.normal = Vector3::Zero()}), Contains("plane.normal"));
}

TEST_CASE("check_gap finds a wrong normal, a wrong point and a forgotten time derivative",
          "[gap][check_gap]") {
  const auto moving = [](double normal_error, double point_error, double rate) {
    return Gap([=](const Pose& X_WA, const Pose& X_WB, double t) {
      const Vector3 n = (X_WB.p - X_WA.p).normalized();
      const Vector3 shown = (n + normal_error * n.unitOrthogonal()).normalized();
      return ContactPoint{
          .gap = (X_WB * Vector3(0.3, 0, 0) - X_WA.p).dot(n) * 0 + (X_WB.p - X_WA.p).norm() - std::sin(t),
          .normal = shown,
          .point = X_WB.p + point_error * n.unitOrthogonal(),
          .gap_t = rate * -std::cos(t)};
    });
  };
  CHECK(check_gap(moving(0, 0, 1)).passed);
  CHECK_FALSE(check_gap(moving(1e-3, 0, 1)).passed);
  CHECK_FALSE(check_gap(moving(0, 1e-3, 1)).passed);
  CHECK_FALSE(check_gap(moving(0, 0, 0)).passed);
  const Gap broken = [](const Pose&, const Pose&, double) { return ContactPoint{.gap = not_set}; };
  CHECK_FALSE(check_gap(broken).passed);
  CHECK_FALSE(check_gap(broken).finite);
}

TEST_CASE("contact frames are right-handed and follow the documented choice", "[gap]") {
  CHECK(contact_frame(Vector3::UnitZ()).isApprox((Matrix3() << 0, 1, 0, 0, 0, 1, 1, 0, 0).finished()));
  for (const Vector3& n :
       {Vector3(1, 0, 0), Vector3(0.95, 0.3, 0), Vector3(0.2, -0.9, 0.4), Vector3(0, 0, -1)}) {
    const Matrix3 frame = contact_frame(n.normalized());
    CHECK((frame.transpose() * frame).isApprox(Matrix3::Identity(), 1e-14));
    CHECK(frame.determinant() == Approx(1));
    CHECK(frame.col(0).isApprox(n.normalized()));
  }
  CHECK(std::abs(contact_frame(Vector3(0.95, 0.3, 0).normalized())(2, 1)) <
        1e-16);  // t stays in the xy plane
  const Matrix3 wished = contact_frame(Vector3::UnitZ(), {1, 1, 5});
  CHECK(wished.col(1).isApprox(Vector3(1, 1, 0).normalized()));
  CHECK(contact_frame(Vector3::UnitZ(), {0, 0, 2})
            .col(1)
            .isApprox(Vector3::UnitX()));  // a wish along n is none
}

namespace {

/// The largest difference between a gap's own derivatives and those that differences give.
double against_differences(const Gap& gap, const Pose& X_WA, const Pose& X_WB, double t = 0.2) {
  const auto n = static_cast<std::size_t>(gap.points());
  const Gap plain = Gap::patch(gap.points(), [gap](const Pose& A, const Pose& B, double s,
                                                   std::span<ContactPoint> out) { gap(A, B, s, out); });
  CHECK(gap.has_derivatives());
  CHECK_FALSE(plain.has_derivatives());
  std::vector<ContactDerivative> exact(n), differences(n);
  gap.differentiate(X_WA, X_WB, t, exact);
  plain.differentiate(X_WA, X_WB, t, differences);
  double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const ContactDerivative &a = exact[i], &b = differences[i];
    worst = std::max({worst, (a.normal - b.normal).cwiseAbs().maxCoeff(),
                      (a.point - b.point).cwiseAbs().maxCoeff(), (a.normal_t - b.normal_t).norm(),
                      (a.point_t - b.point_t).norm(), std::abs(a.gap_tt - b.gap_tt)});
  }
  return worst;
}

}  // namespace

TEST_CASE("a gap's derivatives are what fourth-order differences give, to nine digits", "[gaps]") {
  const Plane tilted{{0.2, -0.1, 1}, {0.1, 0.2, 0.3}};
  const Pose A = at(0.1, -0.2, 0.05, {0.2, 0.1, -0.3}), B = at(0.3, 0.5, 1.6, {0.4, 0.3, 0.2});
  CHECK(against_differences(sphere_on_plane(0.4, tilted), A, B) < 1e-9);
  CHECK(against_differences(box_on_plane({0.4, 0.6, 0.8}, tilted), A, B) < 1e-9);
  CHECK(against_differences(ellipsoid_on_plane({0.5, 0.3, 0.2}, tilted), A, B) < 1e-9);
  CHECK(against_differences(ellipsoid_on_plane({0.5, 0.3, 0.2}, tilted, {0.1, 0.2, 0.3}), A, B) < 1e-9);
  CHECK(against_differences(disc_on_plane(0.5, tilted), A, at(0.3, 0.5, 1.6, {1.4, 0.3, 0.2})) < 1e-9);
  CHECK(against_differences(sphere_on_sphere(0.4, 0.3), A, B) < 1e-9);
  CHECK(against_differences(sphere_in_sphere(3, 0.3), A, B) < 1e-9);
  CHECK(against_differences(sphere_in_cylinder(3, 0.3, {0.3, 0.2, 1}, {0.1, 0.2, 0}), A, B) < 1e-9);
  CHECK(against_differences(sphere_on_box(0.3, {1, 2, 3}), A, B) < 1e-9);
  CHECK(against_differences(box_on_box({1, 1, 1}, {1, 1, 1}), A, B) < 1e-9);
  CHECK(against_differences(ellipse_on_line(0.4, 0.2), {}, at(0, 1, 0, {0, 0, 0.3})) < 1e-9);
  CHECK(against_differences(disc_in_circle(1, 0.2), {}, at(0.3, 0.5, 0)) < 1e-9);
  CHECK(against_differences(particle_in_circle(1), {}, at(0.3, 0.5, 2)) < 1e-9);
}

TEST_CASE("a gap written on a scalar type has the derivatives of its formula", "[gaps]") {
  // a sphere of radius 1/2 over a floor that rises as sin t and tilts with A
  const Gap gap = differentiable([]<class S>(const PoseOf<S>& A, const PoseOf<S>& B, S t) {
    using std::cos;
    using std::sin;
    ContactPointOf<S> c;
    c.normal = A.R.col(2);
    const Eigen::Matrix<S, 3, 1> d = B.p - A.p;
    c.gap = c.normal.dot(d) - 0.5 - sin(t);
    c.point = B.p - 0.5 * c.normal;
    c.gap_t = -cos(t);
    return c;
  });
  const Pose A = at(0.1, -0.2, 0.05, {0.2, 0.1, -0.3}), B = at(0.3, 0.5, 1.6, {0.4, 0.3, 0.2});
  CHECK(against_differences(gap, A, B) < 1e-9);
  CHECK(check_gap(gap).passed);
  std::vector<ContactDerivative> d(1);
  gap.differentiate(A, B, 0.3, d);
  CHECK(d[0].gap_tt == Approx(std::sin(0.3)));
}

TEST_CASE("rectangles touch with the corners of each on the faces of the other", "[gaps]") {
  const Gap gap = rectangle_on_rectangle({2, 1}, {1, 1});
  int present = 0;
  for (const ContactPoint& c : points(gap, {}, at(0, 1.25, 0))) {
    if (c.gap == infinity || c.gap > 1) continue;
    ++present;
    CHECK(c.gap == Approx(0.25));
    CHECK(c.normal == Vector3::UnitY());
    CHECK(c.point.y() == Approx(0.625));  // half way
  }
  CHECK(present == 2);  // the lower corners of B; those of A lie beside it
  present = 0;
  for (const ContactPoint& c : points(rectangle_on_rectangle({1, 1}, {3, 1}), {}, at(0.2, 1, 0))) {
    if (c.gap == infinity || c.gap > 0.5) continue;
    ++present;
    CHECK(std::abs(c.gap) < 1e-15);
    CHECK((c.normal - Vector3::UnitY()).norm() < 1e-15);  // from A to B on B's face too
  }
  CHECK(present == 2);  // the upper corners of A
  CHECK(against_differences(gap, at(0.1, -0.2, 0, {0, 0, 0.2}), at(0.3, 1.3, 0, {0, 0, -0.4})) < 1e-9);
}

TEST_CASE("check_gap tells of derivatives that are not the gap's", "[gaps]") {
  Gap gap = sphere_on_sphere(0.4, 0.3);
  gap.differentiated_by(
      [](const Pose&, const Pose&, double, std::span<ContactDerivative> out) { out[0] = {}; });
  GapCheckOptions options;
  options.X_WB = at(0.3, 0.5, 0.6);
  const GapCheck check = check_gap(gap, options);
  CHECK(check.rate_error < 1e-8);
  CHECK(check.derivative_error > 0.1);
  CHECK_FALSE(check.passed);
}
