#include "perp/instant/friction_polygon.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace perp;

TEST_CASE("vertex k of the friction polygon lies at 2 pi k/n on the unit circle", "[friction_polygon]") {
  for (const int n : {3, 4, 5, 8, 9, 12, 32}) {
    const auto d = friction_polygon(n);
    REQUIRE(d.size() == static_cast<std::size_t>(n));
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * k / n;
      CHECK((d[static_cast<std::size_t>(k)] - Vector2(std::cos(angle), std::sin(angle))).norm() < 1e-15);
    }
  }
}

TEST_CASE("opposite vertices of the friction polygon are opposite to the last bit", "[friction_polygon]") {
  for (const std::size_t n : {4U, 6U, 8U, 64U}) {
    const auto d = friction_polygon(static_cast<int>(n));
    CHECK(d[0] == Vector2(1, 0));
    for (std::size_t k = 0; k < n; ++k) CHECK(d[k] == -d[(k + n / 2) % n]);
    if (n % 4 == 0) CHECK(d[n / 4] == Vector2(0, 1));
  }
  CHECK_THROWS_WITH(friction_polygon(2), Catch::Contains("edges is 2"));
}
