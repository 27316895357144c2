#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include "perp/io/sweep.hpp"
#include "tests/cli/program.hpp"

extern char** environ;

namespace perp {
namespace {

const std::string block = "study incline-block --methods ncp2 --steps 0.02 ";

std::size_t lines(const std::filesystem::path& file) {
  const std::string text = contents(file);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("a sweep over friction slides as far as mechanics says, and holds from tan(theta) on", "[sweep]") {
  const Scratch scratch("sweep-block");
  const Outcome done = run_perp(
      scratch, block + "--sweep mu=0.3:0.7:5 --until 1 --ask block.vx --pass 'block.vx > 0.01' --out " +
                   (scratch / "out"));
  CAPTURE(done.err);
  REQUIRE(done.status == 0);
  const auto table = columns(scratch / "out/sweep.csv");
  REQUIRE(table.at("mu").size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    const double mu = 0.3 + 0.1 * double(i), a = 9.81 * (0.5 - mu * std::sqrt(0.75));
    CHECK(std::stod(table.at("mu")[i]) == Approx(mu));
    CHECK(std::stod(table.at("t")[i]) == 1);
    CHECK(table.at("failed")[i] == "0");
    CHECK(table.at("pass")[i] == (mu < std::tan(M_PI / 6) ? "1" : "0"));
    CHECK(std::abs(std::stod(table.at("block.vx")[i])) <= std::max(a, 0.0) + 1e-9);
  }
  CHECK(columns(scratch / "out/shares.csv").at("passed") ==
        std::vector<std::string>{"1", "1", "1", "0", "0"});
}

TEST_CASE("shards of a sweep, and a sweep that was killed and taken up again, make the CSV of one run",
          "[sweep]") {
  const Scratch scratch("sweep-shards");
  const std::string what =
      block + "--sweep mu=0.1:0.5:7 --draw v0=1:3 --draws 9 --seed 4 --ask block.vx --out ";
  REQUIRE(run_perp(scratch, what + (scratch / "one")).status == 0);
  const std::string one = contents(scratch / "one/sweep.csv");
  CHECK(std::count(one.begin(), one.end(), '\n') == 64);
  for (const char* shard : {"1", "2", "3"})
    REQUIRE(
        run_perp(scratch, what + (scratch / (std::string("s") + shard)) + " --jobs 2 --shard " + shard + "/3")
            .status == 0);
  REQUIRE(run_perp(scratch, "study --merge " + (scratch / "s1") + " " + (scratch / "s2") + " " +
                                (scratch / "s3") + " --out " + (scratch / "all"))
              .status == 0);
  CHECK(contents(scratch / "all/sweep.csv") == one);

  // cut in the middle of a line, as a kill may leave it
  std::filesystem::create_directories(scratch / "cut");
  const std::string journal = contents(scratch / "one/sweep.journal");
  std::ofstream(scratch / "cut/sweep.journal", std::ios::binary) << journal.substr(0, journal.size() / 2);
  const Outcome again = run_perp(scratch, what + (scratch / "cut"));
  REQUIRE(again.status == 0);
  CHECK(again.out.find("63 runs: 63 made now") == std::string::npos);
  CHECK(contents(scratch / "cut/sweep.csv") == one);
}

TEST_CASE("a sweep that is killed goes on where it stopped, to the same bytes", "[sweep]") {
  const Scratch scratch("sweep-killed");
  const std::string out = scratch / "killed";
  std::vector<std::string> arguments{
      PERP_PROGRAM, "study",         "incline-block", "--methods", "ncp2",  "--steps", "0.005",
      "--sweep",    "mu=0.1:0.5:60", "--ask",         "block.vx",  "--out", out};
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  REQUIRE(posix_spawn(&child, PERP_PROGRAM, nullptr, nullptr, argv.data(), environ) == 0);
  while (lines(std::filesystem::path(out) / "sweep.journal") < 5 && waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  const std::string what =
      "study incline-block --methods ncp2 --steps 0.005 --sweep mu=0.1:0.5:60 --ask block.vx --out ";
  REQUIRE(run_perp(scratch, what + out).status == 0);
  REQUIRE(run_perp(scratch, what + (scratch / "whole")).status == 0);
  CHECK(contents(out + "/sweep.csv") == contents(scratch / "whole/sweep.csv"));
}

TEST_CASE("a sweep refuses what it cannot run, and a run that the scene refuses is a row that says why",
          "[sweep]") {
  const Scratch scratch("sweep-refused");
  const auto complaint = [&](const std::string& arguments) {
    const Outcome done = run_perp(scratch, block + arguments + " --out " + (scratch / "out"));
    CHECK(done.status == 2);
    return done.err;
  };
  CHECK_THAT(complaint("--sweep nu=0:1:3 --ask block.x"), Catch::Contains("nu") && Catch::Contains("mu"));
  CHECK_THAT(complaint("--sweep mu=0:1 --ask block.x"), Catch::Contains("NAME=LO:HI:N"));
  CHECK_THAT(complaint("--sweep mu=0:1:0 --ask block.x"), Catch::Contains("NAME=LO:HI:N"));
  CHECK_THAT(complaint("--sweep mu=0:1:3"), Catch::Contains("--ask"));
  CHECK_THAT(complaint("--sweep mu=0:1:3 --ask block.height"), Catch::Contains("block.height"));
  CHECK_THAT(complaint("--sweep mu=0:1:3 --pass block.x"), Catch::Contains("A > B"));
  CHECK_THAT(complaint("--sweep mu=0:1:3 --ask block.x --envelope 4"), Catch::Contains("--envelope"));
  const Outcome done =
      run_perp(scratch, block + "--sweep mu=-0.1:0.3:2 --ask block.x --out " + (scratch / "half"));
  CHECK(done.status == 1);
  const auto table = columns(scratch / "half/sweep.csv");
  CHECK(table.at("failed") == std::vector<std::string>{"1", "0"});
  CHECK_THAT(contents(scratch / "half/sweep.csv"), Catch::Contains("mu"));
}

TEST_CASE(
    "the fixture seats a part whose clamp against two locators comes first, and not the other way round",
    "[sweep]") {
  const Scratch scratch("sweep-fixture");
  const std::string fixture = std::string(PERP_TEST_FOLDER) + "/../../examples/scenes/fixture.toml";
  const Outcome done =
      run_perp(scratch, "study " + fixture +
                            " --methods ncp2 --steps 0.002 --sweep order=0:1:2 --sweep mu=0.2:0.3:2 " +
                            "--pass 'hypot(part.x, part.y) < 1e-5' --out " + (scratch / "out"));
  REQUIRE(done.status == 0);
  const auto shares = columns(scratch / "out/shares.csv");
  CHECK(shares.at("order") == std::vector<std::string>{"0", "0", "1", "1"});
  CHECK(shares.at("n") == std::vector<std::string>{"1", "1", "1", "1"});
  CHECK(shares.at("passed") == std::vector<std::string>{"1", "1", "0", "0"});
}

TEST_CASE("the feeder sets most of its parts on their base, as many under lcp as under ncp2", "[sweep]") {
  const Scratch scratch("sweep-feeder");
  const Outcome done =
      run_perp(scratch,
               "study feeder --methods ncp2,lcp --steps 0.002 --set e=0.2 --draw turn=0:6.283185307179586 "
               "--draw start_x=-0.05:0.02 --draws 30 --seed 1 --pass 'cos(cup.angle) > 0.99' --out " +
                   (scratch / "out"));
  REQUIRE(done.status <= 1);  // a part may end with a step that says why it does not advance
  const auto shares = columns(scratch / "out/shares.csv");
  REQUIRE(shares.at("method") == std::vector<std::string>{"ncp2", "lcp"});
  for (const std::string& n : shares.at("n")) CHECK(std::stoi(n) >= 27);
  const auto share = [&](const char* column, std::size_t i) { return std::stod(shares.at(column)[i]); };
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(share("share", i) > 0.5);
    CHECK(share("share", i) > share("low", 1 - i));
    CHECK(share("share", i) < share("high", 1 - i));
  }
}

TEST_CASE("the feeder and the fixture are the same built in and as files", "[sweep]") {
  const Scratch scratch("machines");
  const std::string scenes = std::string(PERP_TEST_FOLDER) + "/../../examples/scenes/";
  for (const std::string name : {"feeder", "fixture"}) {
    CAPTURE(name);
    for (const auto& [scene, out] :
         {std::pair(name, "/built-in"), std::pair(scenes + name + ".toml", "/file")})
      REQUIRE(run_perp(scratch, "run " + scene + " --method ncp2 --step 0.002 --until 0.3 --out " +
                                    (scratch / (name + out)))
                  .status == 0);
    const auto built_in = columns(scratch / (name + "/built-in/trajectory.csv"));
    const auto file = columns(scratch / (name + "/file/trajectory.csv"));
    REQUIRE(built_in.size() == file.size());
    for (const auto& [column, values] : built_in) {
      CAPTURE(column);
      REQUIRE(file.at(column).size() == values.size());
      CHECK(std::abs(std::stod(file.at(column).back()) - std::stod(values.back())) < 1e-4);
    }
  }
}

TEST_CASE("Wilson's interval of a share is the textbook's", "[sweep]") {
  const Share some = wilson(8, 10);  // 0.490 to 0.943
  CHECK(some.share == 0.8);
  CHECK(some.low == Approx(0.4901624715).epsilon(1e-8));
  CHECK(some.high == Approx(0.9433178485).epsilon(1e-8));
  CHECK(wilson(0, 10).low == 0);
  CHECK(wilson(10, 10).high == 1);
}

}  // namespace perp
