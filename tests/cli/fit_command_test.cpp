#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "tests/cli/program.hpp"

namespace perp {
namespace {

const std::string pendulum = std::string(PERP_TEST_FOLDER) + "/../../examples/scenes/rough-pendulum.toml";

/// Columns of a run's trajectory as a data file; every third cell of the last column is not measured.
void keep(const Scratch& scratch, const std::string& run, const std::vector<std::string>& names,
          const std::string& file) {
  const auto table = columns(scratch / (run + "/trajectory.csv"));
  std::ofstream out(scratch / file);
  out << "t";
  for (const std::string& name : names) out << "," << name;
  for (std::size_t k = 0; k < table.at("t").size(); ++k) {
    out << "\n" << table.at("t")[k];
    for (const std::string& name : names)
      out << "," << (name == names.back() && k % 3 == 2 ? "" : table.at(name)[k]);
  }
  out << "\n";
}

double number(const std::string& text) { return std::stod(text); }

}  // namespace

TEST_CASE(
    "perp fit finds the parameters of a run from its own trajectory, and writes tables, a picture and a page",
    "[fit]") {
  const Scratch scratch("fit-own");
  REQUIRE(
      run_perp(scratch, "run " + pendulum + " --method ncp2 --step 0.02 --until 2 --out " + (scratch / "run"))
          .status == 0);
  keep(scratch, "run", {"rod.angle", "rod.omega"}, "data.csv");
  const Outcome done =
      run_perp(scratch, "fit " + pendulum + " --data " + (scratch / "data.csv") +
                            " --free friction,damping=0:1 --set friction=0.15 --set damping=0.06 --step 0.02 "
                            "--hold-back 0.2 --out " +
                            (scratch / "out"));
  CAPTURE(done.err, done.out);
  REQUIRE(done.status == 0);
  const auto fit = columns(scratch / "out/fit.csv");
  REQUIRE(fit.at("name") == std::vector<std::string>{"friction", "damping"});
  CHECK(number(fit.at("value")[0]) == Approx(0.05).epsilon(1e-4));
  CHECK(number(fit.at("value")[1]) == Approx(0.02).epsilon(1e-4));
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(fit.at("identifiable")[i] == "1");
    CHECK(number(fit.at("low")[i]) <= number(fit.at("value")[i]));
    CHECK(number(fit.at("high")[i]) >= number(fit.at("value")[i]));
  }
  const auto residuals = columns(scratch / "out/residuals.csv");
  const auto held = std::count(residuals.at("held_back").begin(), residuals.at("held_back").end(), "1");
  CHECK(held > 20);  // of 101 rows the last fifth, of both columns
  CHECK(held < 45);
  for (const std::string& r : residuals.at("residual")) CHECK(std::abs(number(r)) < 1e-3);
  const auto prediction = columns(scratch / "out/prediction.csv");
  CHECK(prediction.at("what") == std::vector<std::string>{"rotation", "spin"});
  CHECK(contents(scratch / "out/fit.html").find("friction") != std::string::npos);
  CHECK_THAT(done.out, Catch::Contains("held back"));
}

TEST_CASE("perp fit says where a data file is wrong", "[fit]") {
  const Scratch scratch("fit-wrong");
  const auto complaint = [&](const std::string& text) {
    std::ofstream(scratch / "d.csv") << text;
    const Outcome done = run_perp(scratch, "fit " + pendulum + " --data " + (scratch / "d.csv") +
                                               " --free friction --out " + (scratch / "out"));
    CHECK(done.status == 2);
    return done.err;
  };
  CHECK_THAT(complaint("t,rod.angle\n0,1\n0.1,1x\n"),
             Catch::Contains("d.csv:3:5: column 'rod.angle' is '1x'"));
  CHECK_THAT(complaint("t,rod.angle\n0,1\n0.1,inf\n"), Catch::Contains("d.csv:3:5:"));
  CHECK_THAT(complaint("t,rod.angle\n0.1,1\n0.1,1\n"), Catch::Contains("d.csv:3:1: column 't' is '0.1'"));
  CHECK_THAT(complaint("t,rod.angle\n,1\n"), Catch::Contains("d.csv:2:1: column 't'"));
  CHECK_THAT(complaint("rod.angle,t\n0,1\n"), Catch::Contains("d.csv:1:1: the first column is 'rod.angle'"));
  CHECK_THAT(complaint("t,rod.angle\n"), Catch::Contains("d.csv:2:1: no row"));
  CHECK_THAT(complaint("t,rod.angle\n0,\n1,\n"), Catch::Contains("only empty cells"));
  CHECK_THAT(complaint("t,rod.angle\n0,1,2\n"), Catch::Contains("d.csv:2: the row has 3 cells"));
  CHECK_THAT(complaint("t,rod.height\n0,1\n"), Catch::Contains("rod.height"));
  CHECK_THAT(complaint(""), Catch::Contains("the file is empty"));
}

TEST_CASE("perp fit refuses what cannot be free and options that the method does not use", "[fit]") {
  const Scratch scratch("fit-refused");
  std::ofstream(scratch / "d.csv") << "t,rod.angle\n0,1\n0.1,0.9\n0.2,0.8\n";
  const auto complaint = [&](const std::string& arguments) {
    const Outcome done = run_perp(scratch, "fit " + pendulum + " --data " + (scratch / "d.csv") + " --out " +
                                               (scratch / "out") + " " + arguments);
    CHECK(done.status == 2);
    return done.err;
  };
  CHECK_THAT(complaint("--free stiffness"),
             Catch::Contains("stiffness") && Catch::Contains("friction, damping"));
  CHECK_THAT(complaint("--free friction=2:1"), Catch::Contains("NAME=LO:HI"));
  CHECK_THAT(complaint("--free friction=a:1"), Catch::Contains("NAME=LO:HI"));
  CHECK_THAT(complaint("--free friction --method ncp2 --tolerance 1e-6"), Catch::Contains("--tolerance"));
  CHECK_THAT(complaint("--free friction --method event --step 0.1"), Catch::Contains("--step"));
  CHECK_THAT(complaint("--free friction --hold-back 1"), Catch::Contains("hold_back"));
}

}  // namespace perp
