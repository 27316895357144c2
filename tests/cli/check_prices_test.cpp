// What perp check says of the size of a step: no more is modelled than a scene needs.
#include <catch2/catch.hpp>

#include "perp/step/auto_method.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/study/scene.hpp"
#include "tests/cli/program.hpp"

namespace perp {

TEST_CASE("the seed's sphere on four edges is an LCP of (48)'s six unknowns", "[check]") {
  LcpStepper stepper({.edges = 4});
  const Scene s = scene("seed-sphere");
  const std::vector<Lcp> problems = stepper.problems(s.model, s.start, 0.01);
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].b.size() == 6);
}

TEST_CASE("perp check prints unknowns, rows and the price of a step of every method", "[check]") {
  const Scratch scratch("check-prices");
  const std::string sphere = run_perp(scratch, "check seed-sphere").out;
  CHECK(sphere.find("1 contact rows, 2 friction rows, 0 joint rows, 0 joint frictions") != std::string::npos);
  CHECK(sphere.find("price lcp          10 unknowns in 1 LCPs; ") != std::string::npos);
  CHECK(sphere.find("price ncp2         9 unknowns: 6 velocities, 3 impulses; ") != std::string::npos);
  CHECK(sphere.find(" us a step") != std::string::npos);
  const std::string smooth = run_perp(scratch, "check seed-sphere --set mu=0").out;
  CHECK(smooth.find("1 contact rows, 0 friction rows") != std::string::npos);  // absence costs nothing
  CHECK(smooth.find("price lcp          1 unknowns in 1 LCPs; ") != std::string::npos);
  CHECK(smooth.find("price ncp2         7 unknowns: 6 velocities, 1 impulses; ") != std::string::npos);
  const std::string flight = run_perp(scratch, "check dzhanibekov").out;
  CHECK(flight.find("price lcp          0 unknowns in 0 LCPs; ") != std::string::npos);
  const std::string pendulum = run_perp(scratch, "check friction-pendulum").out;
  CHECK(pendulum.find("0 contact rows, 0 friction rows, 2 joint rows, 1 joint frictions") !=
        std::string::npos);
}

TEST_CASE("The method auto takes what the scene needs, and says why in one line", "[auto]") {
  const Scratch scratch("auto");
  const auto chosen = [&](const std::string& arguments) {
    const Outcome done =
        run_perp(scratch, "run " + arguments + " --method auto --until 0.1 --out " + (scratch / "o"));
    CHECK(done.status == 0);
    CHECK(done.out.find("auto: ") == 0);
    return done.out.substr(6, done.out.find(':', 6) - 6);
  };
  CHECK(chosen("bouncing-ball --step 0.01") == "lcp");  // a particle over a plane
  CHECK(contents(scratch / "o/run.json").find("\"method\": \"lcp\"") != std::string::npos);
  CHECK(chosen("oblique-sphere --step 0.01") == "ncp2");
  CHECK(chosen("double-pendulum --step 0.01") == "ncp2");
  CHECK(chosen("roller-in-cylinder --step 0.01") == "ncp2");
  if (has_sundials()) CHECK(chosen("oblique-sphere") == "event");
  CHECK(choose_method(scene("pile", {{"count", 200}}).model, true).method == "ncp");
  CHECK_THROWS_WITH(choose_method(scene("pile").model, false),
                    Catch::Contains("--step is not given, is needed"));
}

}  // namespace perp
