#include <catch2/catch.hpp>
#include <cmath>

#include "model/time_slope.hpp"

using namespace perp;

TEST_CASE("a function's slope by time is right to nine digits from a millisecond to an hour", "[model]") {
  const double width = GENERATE(1e-3, 1e-2, 0.1, 1.0, 60.0, 3600.0);
  for (double share = -2.9; share < 3; share += 0.37) {
    const double middle = 17.3, t = middle + share * width;
    const auto pulse = [&](double s) {
      const double x = (s - middle) / width;
      return Eigen::Vector2d(std::exp(-x * x), 3 + std::sin(x));
    };
    const double x = (t - middle) / width;
    const Eigen::Vector2d right(-2 * x * std::exp(-x * x) / width, std::cos(x) / width);
    const Eigen::Vector2d found = time_slope<2>(pulse, t);
    CAPTURE(width, share);
    // rounding of t, and of values over steps of a millisecond
    CHECK((found - right).norm() < 1e-9 / width + 1e-11);
  }
}

TEST_CASE("a slope beside a corner is that of its side", "[model]") {
  const auto corner = [](double s) { return Eigen::Matrix<double, 1, 1>(std::abs(s) + s * s); };
  for (const double t : {3e-4, 2e-3, 0.1}) {
    CHECK(std::abs(time_slope<1>(corner, t)[0] - (1 + 2 * t)) < 1e-9);
    CHECK(std::abs(time_slope<1>(corner, -t)[0] - (-1 - 2 * t)) < 1e-9);
  }
}
