#include "perp/model/inertia.hpp"

#include <catch2/catch.hpp>

#include "perp/core/pose.hpp"

using namespace perp;
using Catch::Contains;

TEST_CASE("makers of inertia give the moments of the solids", "[inertia]") {
  CHECK(Inertia::solid_sphere(2, 3).tensor().diagonal().isApprox(Vector3::Constant(0.4 * 2 * 9)));
  CHECK(Inertia::hollow_sphere(3, 2).tensor().diagonal().isApprox(Vector3::Constant(8)));
  CHECK(Inertia::solid_box(12, {1, 2, 3}).tensor().diagonal().isApprox(Vector3(13, 10, 5)));
  CHECK(Inertia::solid_cylinder(12, 1, 2).tensor().diagonal().isApprox(Vector3(7, 7, 6)));
  CHECK(Inertia::solid_ellipsoid(5, {1, 2, 3}).tensor().diagonal().isApprox(Vector3(13, 10, 5)));
}

TEST_CASE("principal axes of a turned tensor are found and are right-handed", "[inertia]") {
  const Matrix3 R = rotation({0.3, -1.1, 0.7}).toRotationMatrix();
  const Vector3 moments(1, 2, 2.5);
  const Inertia inertia(1, R * moments.asDiagonal() * R.transpose());
  CHECK(inertia.principal_moments().isApprox(moments, 1e-13));
  const Matrix3& axes = inertia.principal_axes();
  CHECK(axes.determinant() == Approx(1));
  CHECK((axes * moments.asDiagonal() * axes.transpose()).isApprox(inertia.tensor(), 1e-13));
}

TEST_CASE("an inertia that no body can have is refused, a flat body's is not", "[inertia]") {
  CHECK_NOTHROW(Inertia::principal(1, {1, 2, 3}));  // flat: I1 + I2 = I3
  CHECK_NOTHROW(Inertia::principal(1, {1, 2, 3 * (1 + 1e-13)}));
  CHECK_THROWS_WITH(Inertia::principal(1, {1, 2, 3 * (1 + 1e-11)}),
                    Contains("3.00000000003") && Contains("no body"));
  CHECK_THROWS_WITH(Inertia::principal(1, {0, 1, 1}), Contains("principal moments") && Contains("positive"));
  CHECK_THROWS_WITH(Inertia::principal(1, {-1, 1, 1}), Contains("positive"));
  Matrix3 skew = Matrix3::Identity();
  skew(0, 1) = 0.1;
  CHECK_THROWS_WITH(Inertia(1, skew), Contains("symmetric"));
  CHECK_THROWS_WITH(Inertia(1, Matrix3::Constant(not_set)), Contains("J") && Contains("finite"));
}

TEST_CASE("a mass or a length that is not positive and finite is named", "[inertia]") {
  const double bad = GENERATE(0.0, -1.0, not_set, infinity);
  CAPTURE(bad);
  CHECK_THROWS_WITH(Inertia(bad, Matrix3::Identity()), Contains("mass"));
  CHECK_THROWS_WITH(Inertia::solid_sphere(1, bad), Contains("radius"));
  CHECK_THROWS_WITH(Inertia::solid_box(1, {1, bad, 1}), Contains("size"));
  CHECK_THROWS_WITH(Inertia::solid_cylinder(1, 1, bad), Contains("length"));
}
