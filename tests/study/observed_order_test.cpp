#include "perp/study/observed_order.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <stdexcept>

namespace perp {
namespace {

template <class Error>
ObservedOrder fit(const std::vector<double>& h, Error error, double round_off = 0) {
  std::vector<double> errors;
  for (const double step : h) errors.push_back(error(step));
  return observed_order(h, errors, std::vector<double>(h.size(), round_off));
}

}  // namespace

TEST_CASE("err = 3 h^2 has order 2 at any spacing of h, in any order", "[observed_order]") {
  const auto error = [](double h) { return 3 * h * h; };
  for (const std::vector<double>& h : {halvings(0.1, 8), {0.1, 0.07, 0.01}, {0.003, 0.5, 0.02, 0.021}}) {
    const ObservedOrder order = fit(h, error);
    CHECK(order.order == Approx(2).epsilon(1e-12));
    CHECK(order.points == static_cast<int>(h.size()));
    CHECK(order.note.empty());
  }
}

TEST_CASE("a method whose errors grow has a negative order", "[observed_order]") {
  CHECK(fit(halvings(0.1, 6), [](double h) { return 1e-3 / h; }).order == Approx(-1).epsilon(1e-12));
  CHECK(fit(halvings(0.1, 6), [](double h) { return 0.2 * std::pow(h, -0.5); }).order == Approx(-0.5));
}

TEST_CASE("errors that stall give no order, and are said to stall where they do", "[observed_order]") {
  const ObservedOrder order = fit(halvings(0.1, 8), [](double h) { return 3 * h * h + 1e-3; });
  CHECK_FALSE(order.known());
  CHECK(order.floor == Approx(1e-3).epsilon(0.01));
  CHECK(order.note == "stalls at 0.001");
  CHECK_FALSE(fit(halvings(0.1, 4), [](double) { return 0.5; }).known());
  // two equal errors in a row, or three within a factor of 2 in h, are no stall
  CHECK(fit({0.4, 0.2, 0.1}, [](double h) { return h == 0.2 ? 0.1 : h; }).known());
  CHECK(fit({0.4, 0.2, 0.1, 0.09, 0.08}, [](double h) { return h; }).order == Approx(1));
}

TEST_CASE("points at round-off are left out of the slope, and counted", "[observed_order]") {
  const auto error = [](double h) { return std::max(h * h * h * h, 1e-13); };
  const ObservedOrder order = fit(halvings(0.1, 14), error, 2e-13);
  CHECK(order.order == Approx(4).epsilon(1e-12));
  CHECK(order.points == 8);  // 0.1/2^7 gives 3.7e-13
  CHECK(order.note == "6 of 14 at round-off");
  const ObservedOrder exact = fit(halvings(0.1, 5), [](double) { return 0.0; });
  CHECK_FALSE(exact.known());
  CHECK(exact.note == "exact to round-off");
}

TEST_CASE("runs that failed are left out and said; too few points give no order", "[observed_order]") {
  const auto error = [](double h) { return h > 0.06 ? not_set : h; };
  const ObservedOrder order = fit(halvings(0.1, 5), error);
  CHECK(order.order == Approx(1).epsilon(1e-12));
  CHECK(order.points == 4);
  CHECK(order.note == "1 of 5 without an answer");
  CHECK(fit(halvings(0.1, 3), error).note == "1 of 3 without an answer; too few points for an order");
  CHECK_FALSE(fit({0.1, 0.05}, [](double h) { return h; }).known());
  CHECK_FALSE(fit({0.1, 0.08, 0.06}, [](double h) { return h; }).known());  // they span less than 4
  CHECK(fit({0.2, 0.1, 0.05}, [](double h) { return h; }).known());
}

TEST_CASE("the order of errors that jump by a factor of 3 from step to step is that of their trend",
          "[observed_order]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> factor(std::log(0.58), std::log(1.73));
  const ObservedOrder order = fit(halvings(0.1, 10), [&](double h) { return h * std::exp(factor(random)); });
  CHECK(order.order == Approx(1).margin(0.2));
}

TEST_CASE("nonsense is refused", "[observed_order]") {
  CHECK_THROWS_AS(halvings(0, 3), std::invalid_argument);
  CHECK_THROWS_AS(halvings(0.1, 0), std::invalid_argument);
  CHECK_THROWS_AS(observed_order({0.1}, {0.1, 0.2}, {0}), std::invalid_argument);
  CHECK_THROWS_AS(observed_order({-0.1}, {0.1}, {0}), std::invalid_argument);
  CHECK_THROWS_AS(observed_order({0.1}, {-0.1}, {0}), std::invalid_argument);
}

TEST_CASE("halvings and ladders are exact halves", "[observed_order]") {
  CHECK(halvings(0.1, 3) == std::vector<double>{0.1, 0.05, 0.025});
  CHECK(ladder(0.6, 20, 2) == std::vector<double>{0.6 / 20, 0.3 / 20});
}

TEST_CASE("extrapolation removes the leading error of order p, of orientations and their velocities too",
          "[observed_order]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1));
  const Vector3 place(1, 2, 3), v(4, 5, 6), w(-3, 1, 2), error(0.3, -0.2, 0.1);
  const Quaternion turn = rotation({1, 0.4, -2});
  const double p = GENERATE(1, 2, 4), ratio = GENERATE(2.0, 1.5);
  const auto answer = [&](double h) {
    State x = model.rest();
    const double e = std::pow(h, p);
    model.set_position(x, ball, place + e * error);
    model.set_orientation(x, ball, turn * rotation(e * error));
    model.set_velocity(x, ball, v + e * error, w - e * error);
    return x;
  };
  const State limit = extrapolated(model, answer(0.1 * ratio), answer(0.1), ratio, p);
  CHECK((model.position(limit, ball) - place).norm() < 1e-13);
  CHECK(model.pose(limit, ball).q.angularDistance(turn) < 1e-7);  // acos near 1
  CHECK((model.velocity(limit, ball) - v).norm() < 1e-13);
  CHECK((model.angular_velocity(limit, ball) - w).norm() < 1e-13);
}

}  // namespace perp
