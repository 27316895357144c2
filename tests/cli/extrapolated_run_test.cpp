// perp run and perp study with the extrapolated step, and with an accuracy in place of a step.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/cli/program.hpp"

namespace perp {

TEST_CASE("perp run takes extrapolated by a tolerance, and by a step with an order", "[run]") {
  const Scratch scratch("run-extrapolated");
  REQUIRE(
      run_perp(scratch, "run seed-sphere --method extrapolated --step 0.1 --order 6 --out " + (scratch / "o"))
          .status == 0);
  auto events = columns(scratch / "o/events.csv");
  REQUIRE(events["kind"] == std::vector<std::string>{"stick"});
  CHECK(std::abs(std::stod(events["t"][0]) - 0.291247997670016019) < 1e-14);
  auto table = columns(scratch / "o/trajectory.csv");
  REQUIRE(table["t"].size() == 9);  // 0, 0.1, ... and two rows at the event
  CHECK(std::stod(table["ball.x"].back()) == Approx(0.94035657076286172).epsilon(1e-13));
  CHECK(run_perp(scratch, "run seed-sphere --method extrapolated --tolerance 1e-9 --out " + (scratch / "p"))
            .status == 0);
}

TEST_CASE("perp run refuses an order without a step, with a tolerance, and of other methods", "[run]") {
  const Scratch scratch("run-order");
  const std::string out = " --out " + (scratch / "o");
  for (const std::string arguments :
       {"extrapolated --order 4", "extrapolated --order 4 --step 0.1 --tolerance 1e-8",
        "ncp2 --order 4 --step 0.1", "extrapolated --order 0 --step 0.1",
        "extrapolated --order 5 --step 0.1"}) {
    CAPTURE(arguments);
    const Outcome done = run_perp(scratch, "run seed-sphere --method " + arguments + out);
    CHECK(done.status == 2);
    CHECK(done.err.find("order") != std::string::npos);
  }
}

TEST_CASE("perp study finds the orders that extrapolated is asked for", "[study]") {
  const Scratch scratch("study-extrapolated");
  REQUIRE(run_perp(scratch,
                   "study bowl --until 0.6 --methods extrapolated --order 4,6 --steps "
                   "T/8,T/12,T/16,T/24,T/32,T/48,T/64,T/96,T/128,T/192,T/256 --out " +
                       (scratch / "o"))
              .status == 0);
  auto orders = columns(scratch / "o/orders.csv");
  REQUIRE(orders["parameter"] == std::vector<std::string>{"order=4", "order=6"});
  CHECK(orders["expected"] == std::vector<std::string>{"4", "6"});
  CHECK(std::stod(orders["order"][0]) == Approx(4).margin(0.3));
  CHECK(std::stod(orders["order"][1]) == Approx(6).margin(0.3));
}

TEST_CASE("A run of an accuracy says at every row how far it is from the motion", "[run]") {
  const Scratch scratch("run-accuracy");
  for (const std::string method : {"ncp2", "extrapolated"}) {
    CAPTURE(method);
    const std::string out = scratch / method;
    REQUIRE(run_perp(scratch, "run bowl --method " + method + " --accuracy 1e-4 --out " + out).status == 0);
    auto report = columns(out + "/report.csv");
    REQUIRE(!report["error_estimate"].empty());
    for (const std::string& error : report["error_estimate"]) {
      CHECK(std::stod(error) >= 0);
      CHECK(std::stod(error) <= 1e-4);
    }
    CHECK(std::stod(report["error_estimate"].back()) > 0);
  }
  const Outcome not_reached =
      run_perp(scratch, "run bowl --method ncp --accuracy 1e-9 --until 0.01 --out " + (scratch / "ncp"));
  CHECK(not_reached.status == 1);
  CHECK(not_reached.err.find("--accuracy 1e-09 was not reached by ncp") != std::string::npos);
  const std::string out = " --out " + (scratch / "refused");
  for (const std::string other : {"--step 0.1", "--tolerance 1e-6"})
    CHECK(run_perp(scratch, "run bowl --method extrapolated --accuracy 1e-4 " + other + out).status == 2);
  CHECK(run_perp(scratch, "run bowl --method ncp2 --accuracy 0" + out).status == 2);
}

}  // namespace perp
