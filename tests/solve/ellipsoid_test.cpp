#include "solve/blocks/ellipsoid.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "friction_examples.hpp"

using namespace perp;

namespace {

struct Example {
  Vector3 axes, z;
  double size;
};

/// Axes from a thousandth to some, at times zero or alike; z inside, outside, or far away.
Example example(unsigned seed) {
  Draw draw(seed);
  Example e;
  for (int k = 0; k < 3; ++k) e.axes(k) = draw.integer(0, 5) == 0 ? 0 : std::pow(10, draw.uniform(-3, 1));
  if (draw.integer(0, 4) == 0) e.axes.setConstant(e.axes.maxCoeff());
  e.size = draw.integer(0, 9) == 0 ? 0 : std::pow(10, draw.uniform(-3, 2));
  e.z = draw.matrix(3, 1) * std::pow(10, draw.uniform(-4, 3));
  return e;
}

}  // namespace

TEST_CASE("no point of an ellipsoid is nearer than the projection, whatever its axes",
          "[friction][ellipsoid]") {
  for (unsigned seed = 0; seed < 2000; ++seed) {
    const auto [axes, z, size] = example(seed);
    const Vector3 p = project_on_ellipsoid(axes, size, z).p;
    CAPTURE(seed, axes.transpose(), size, z.transpose(), p.transpose());
    REQUIRE(ellipsoid_gauge(axes, p) <= size * (1 + 1e-14));
    // the set lies on the far side of the plane through p across z - p: its support there is p's
    const Vector3 normal = z - p;
    const double support = size * ellipsoid_support(axes, normal);
    REQUIRE(std::abs(support - normal.dot(p)) <= 1e-13 * normal.norm() * (p.norm() + size * axes.maxCoeff()));
  }
}

TEST_CASE("the derivatives of an ellipsoid's projection are those of differences", "[friction][ellipsoid]") {
  int outside = 0;
  for (unsigned seed = 0; seed < 500; ++seed) {
    const auto [axes, z, size] = example(seed);
    const EllipsoidProjection at = project_on_ellipsoid(axes, size, z);
    const double gauge = ellipsoid_gauge(axes * size, z.cwiseProduct(axes.cwiseSign()));
    if (size == 0 || std::abs(gauge - 1) < 1e-3) continue;
    outside += !at.inside;
    const EllipsoidSlope slope = differentiate(at, axes, size, z);
    CAPTURE(seed, axes.transpose(), size, z.transpose());
    for (int k = 0; k < 4; ++k) {
      const double step = 1e-6 * (k < 3 ? z.norm() : size);
      const auto moved = [&](double by) {
        return project_on_ellipsoid(axes, k < 3 ? size : size + by,
                                    k < 3 ? Vector3(z + by * Vector3::Unit(k)) : z)
            .p;
      };
      const Vector3 difference = (moved(step) - moved(-step)) / (2 * step);
      const Vector3 derivative = k < 3 ? Vector3(slope.dz.col(k)) : slope.ds;
      REQUIRE((difference - derivative).norm() <= 1e-5 * (k < 3 ? 1 : axes.maxCoeff()));
    }
  }
  CHECK(outside > 200);
}

TEST_CASE("the support of an ellipsoid is its largest product, and its gradient where that is taken",
          "[friction][ellipsoid]") {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const auto [axes, u, size] = example(seed);
    Draw draw(seed + 1000);
    const Vector3 best = ellipsoid_support_gradient(axes, u);
    const double support = ellipsoid_support(axes, u);
    CHECK(best.dot(u) == Approx(support).margin(1e-300));
    if (support > 0) CHECK(ellipsoid_gauge(axes, best) == Approx(1));
    for (int k = 0; k < 50; ++k) {
      Vector3 x = axes.cwiseProduct(Vector3(draw.matrix(3, 1).normalized()));
      CHECK(x.dot(u) <= support * (1 + 1e-14));
    }
  }
}
