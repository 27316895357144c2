// Orders of the steps of fixed size on joints: while they move, and after friction has stopped them for good.
#include <catch2/catch.hpp>

#include "perp/step/methods.hpp"
#include "tests/order/ladder.hpp"

namespace perp {
namespace {

/// Slope of the largest error of three runs whose steps spread over [n, 1.25 n], four steps from T/1280 or T/160 on.
double observed(const char* method, const char* name, double T, int first) {
  const auto& all = methods();
  const auto of_that_name = [&](const Method& m) { return m.name == method; };
  const std::unique_ptr<Stepper> stepper = std::find_if(all.begin(), all.end(), of_that_name)->make({});
  const Scene s = scene(name);
  const State exact = s.exact(T);
  const std::vector<int> counts = ladder(first, 4);
  std::vector<double> list;
  for (const int n : counts) {
    double largest = 0;
    for (const int more : {0, n / 8, n / 4})
      largest = std::max(largest, distance(s.model, run(s, *stepper, T, n + more), exact));
    list.push_back(largest);
  }
  return order_of(counts, list);
}

auto order(double p) { return Approx(p).margin(0.1); }

}  // namespace

TEST_CASE("while joints move the LCP step and the implicit steps have order 1, the second-order step 2",
          "[order]") {
  for (const auto& [name, T] : {std::pair{"friction-pendulum", 1.0}, std::pair{"spring-block", 0.5},
                                std::pair{"heavy-top", 0.3}, std::pair{"slider-crank", 0.3}}) {
    CAPTURE(name);
    for (const char* first_order : {"lcp", "ncp", "ncp-start"})
      CHECK(observed(first_order, name, T, 1280) == order(1));
    CHECK(observed("ncp2", name, T, 160) == order(2));
  }
}

TEST_CASE("where friction has stopped a joint for good its place has at least the step's order", "[order]") {
  for (const auto& [name, T] : {std::pair{"spring-block", 4.0}, std::pair{"slider-crank", 1.3}}) {
    CAPTURE(name);
    for (const char* first_order : {"lcp", "ncp", "ncp-start"})
      CHECK(observed(first_order, name, T, 1280) > 0.9);
    CHECK(observed("ncp2", name, T, 160) > 1.9);
  }
  CHECK(observed("lcp", "friction-pendulum", 12, 1280) > 0.9);
  CHECK(observed("ncp2", "friction-pendulum", 12, 160) > 1.9);
}

}  // namespace perp
