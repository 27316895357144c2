#include "perp/core/pose.hpp"

#include <catch2/catch.hpp>
#include <numbers>
#include <random>

#include "perp/core/errors.hpp"

using namespace perp;

namespace {

Vector3 random_vector(std::mt19937& random, double scale) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  return {uniform(random), uniform(random), uniform(random)};
}

}  // namespace

TEST_CASE("rotation turns by its vector's length about its direction", "[pose]") {
  const Quaternion quarter = rotation({0, 0, std::numbers::pi / 2});
  CHECK((quarter * Vector3::UnitX() - Vector3::UnitY()).norm() < 1e-15);
  CHECK((quarter * Vector3::UnitZ() - Vector3::UnitZ()).norm() < 1e-15);
}

TEST_CASE("rotation and rotation_vector undo each other at every size of angle", "[pose]") {
  std::mt19937 random(1);
  for (const double size : {1e-12, 1e-9, 1e-7, 9e-5, 1.1e-4, 1e-2, 1.0}) {
    const Vector3 angle = random_vector(random, size);
    CAPTURE(size);
    CHECK((rotation_vector(rotation(angle)) - angle).norm() < 4e-16 * std::max(size, 1.0));
    CHECK(std::abs(rotation(angle).norm() - 1) < 1e-15);
  }
}

TEST_CASE("rotation_vector takes the short way round for either sign of the quaternion", "[pose]") {
  const Vector3 angle(0.3, -0.2, 0.5);
  Quaternion q = rotation(angle);
  q.coeffs() *= -1;
  CHECK((rotation_vector(q) - angle).norm() < 1e-15);
}

TEST_CASE("a pose times its inverse is the identity, and products act in turn", "[pose]") {
  std::mt19937 random(2);
  const Pose X_WA{random_vector(random, 2), rotation(random_vector(random, 2))};
  const Pose X_AB{random_vector(random, 2), rotation(random_vector(random, 2))};
  const Vector3 x = random_vector(random, 1);
  CHECK(((X_WA * X_AB) * x - X_WA * (X_AB * x)).norm() < 1e-14);
  CHECK((X_WA.inverse() * (X_WA * x) - x).norm() < 1e-14);
  CHECK((X_WA.R() * x + X_WA.p - X_WA * x).norm() < 1e-14);
}

TEST_CASE("a twist gives a material point v + w x r", "[pose]") {
  const Twist V{{1, 2, 3}, {0, 0, 2}};
  CHECK((V.at({1, 0, 0}) - Vector3(1, 4, 3)).norm() == 0);
}

TEST_CASE("refuse names place, argument, value and need", "[errors]") {
  CHECK_THROWS_WITH(refuse("place", "h", -0.5, "needs to be positive"),
                    "place: h is -0.5, needs to be positive");
  CHECK_THROWS_AS(refuse("place", "h", "x", "need"), std::invalid_argument);
}
