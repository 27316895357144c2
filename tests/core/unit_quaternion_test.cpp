#include <catch2/catch.hpp>
#include <random>

#include "perp/core/pose.hpp"

using namespace perp;

TEST_CASE("what was normalised once keeps its bits", "[pose]") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 10000; ++i) {
    const Quaternion q(normal(random), normal(random), normal(random), normal(random));
    const Quaternion once = unit(q), twice = unit(once);
    CHECK(std::abs(once.norm() - 1) < 1e-15);
    CHECK(once.coeffs() == twice.coeffs());
    CHECK(once.angularDistance(q.normalized()) < 1e-7);
  }
  CHECK(unit(Quaternion(2, 0, 0, 0)).w() == 1);
}
