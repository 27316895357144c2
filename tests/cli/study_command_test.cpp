#include <spawn.h>
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include "perp/step/event_driven.hpp"
#include "tests/cli/program.hpp"

extern char** environ;

namespace perp {
namespace {

using Table = std::map<std::string, std::vector<std::string>>;

/// study.csv as text without what is measured: the column of seconds.
Table without_seconds(const std::filesystem::path& folder) {
  Table table = columns(folder / "study.csv");
  REQUIRE(table.count("seconds") == 1);
  table.erase("seconds");
  return table;
}

std::size_t runs_there(const std::filesystem::path& folder) {
  const std::string journal = contents(folder / "runs.journal");
  std::size_t runs = 0;
  for (std::size_t at = 0; (at = journal.find("\tR\t", at)) != std::string::npos; ++at) ++runs;
  return runs;
}

/// Starts perp with these arguments and kills it as soon as its journal has `runs` runs.
void kill_after(std::size_t runs, std::vector<std::string> arguments, const std::filesystem::path& folder) {
  arguments.insert(arguments.begin(), PERP_PROGRAM);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  REQUIRE(posix_spawn(&child, PERP_PROGRAM, nullptr, nullptr, argv.data(), environ) == 0);
  while (runs_there(folder) < runs && waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  REQUIRE(WIFSIGNALED(status));
}

const std::string scenes = "study oblique-sphere bead-in-ring --methods lcp,lcp-ap ";
const std::string steps = "--steps T/20,T/40,T/80,T/160,T/320 ";

}  // namespace

TEST_CASE("perp study finds order 1 in position on the seed's sphere and writes tables, charts and the page",
          "[study]") {
  const Scratch scratch("study-seed");
  const Outcome done =
      run_perp(scratch, "study seed-sphere --methods lcp --steps 0.04,0.02,0.01,0.005,0.0025 --out " +
                            (scratch / "o"));
  CHECK(done.status == 0);
  CHECK(done.err.empty());  // no terminal, no progress
  const std::string study = contents(scratch / "o/study.csv");
  CHECK(study.rfind("scene,method,parameter,h,rtol,error_q,error_v,seconds,steps,iterations,failed", 0) == 0);
  auto runs = columns(scratch / "o/study.csv");
  CHECK(runs["h"] == std::vector<std::string>{"0.04", "0.02", "0.01", "0.005", "0.0025"});
  CHECK(runs["steps"] == std::vector<std::string>{"15", "30", "60", "120", "240"});
  CHECK(runs["parameter"] == std::vector<std::string>(5, "edges=8"));
  CHECK(runs["failed"] == std::vector<std::string>(5, "0"));
  const std::string orders = contents(scratch / "o/orders.csv");
  CHECK(orders.rfind("scene,method,parameter,reference,order,order_v,points,expected", 0) == 0);
  auto table = columns(scratch / "o/orders.csv");
  REQUIRE(table["order"].size() == 1);
  CHECK(std::stod(table["order"][0]) == Approx(1).margin(0.1));
  CHECK(table["expected"][0] == "1");
  CHECK(table["reference"][0] == "exact");
  const std::string page = contents(scratch / "o/study.html");
  CHECK(page.find("All steps of 5 runs reached their tolerance") != std::string::npos);
  CHECK(page.find("http") == page.find("http://www.w3.org"));  // names of SVG's spaces, and nothing to fetch
  for (const char* word : {"<script", "<link", "src=", "@import", "https://"})
    CHECK(page.find(word) == std::string::npos);
  for (const char* chart : {"seed-sphere-convergence", "seed-sphere-work"}) {
    CHECK_FALSE(contents(scratch / ("o/" + std::string(chart) + ".csv")).empty());
    CHECK_FALSE(contents(scratch / ("o/" + std::string(chart) + ".gnuplot")).empty());
    if (std::system("command -v gnuplot >/dev/null") == 0)
      CHECK(contents(scratch / ("o/" + std::string(chart) + ".svg")).find("</svg>") != std::string::npos);
  }
}

TEST_CASE(
    "orders.csv has the orders of theory, two-sided, against a polygon's own limit where friction turns",
    "[study]") {
  const Scratch scratch("study-orders");
  REQUIRE(run_perp(scratch,
                   "study seed-sphere oblique-sphere cross-incline bead-in-ring --methods lcp,lcp-ap "
                   "--steps T/20,T/40,T/80,T/160,T/320,T/640,T/1280,T/2560 --out " +
                       (scratch / "o"))
              .status == 0);
  auto table = columns(scratch / "o/orders.csv");
  REQUIRE(table["scene"].size() == 12);  // 8, and 4 limits
  int judged = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    CAPTURE(table["scene"][i], table["method"][i], table["reference"][i]);
    const bool turns = table["scene"][i] == "oblique-sphere" || table["scene"][i] == "cross-incline";
    if (turns && table["reference"][i] == "exact") {
      CHECK(table["expected"][i].empty());
      CHECK(table["note"][i].find("stalls at") == 0);
      continue;
    }
    CHECK(table["reference"][i] == (turns ? "limit" : "exact"));
    const bool second = table["scene"][i] == "bead-in-ring" && table["method"][i] == "lcp";
    CHECK(table["expected"][i] == (second ? "2" : "1"));
    CHECK(std::stod(table["order"][i]) == Approx(second ? 2 : 1).margin(0.1));
    ++judged;
  }
  CHECK(judged == 8);
}

TEST_CASE("a study killed in the middle and started again gives the tables of one that was left alone",
          "[study]") {
  const Scratch scratch("study-killed");
  REQUIRE(run_perp(scratch, scenes + steps + "--out " + (scratch / "alone")).status == 0);

  const std::string folder = scratch / "killed";
  kill_after(7,
             {"study", "oblique-sphere", "bead-in-ring", "--methods", "lcp,lcp-ap", "--steps",
              "T/20,T/40,T/80,T/160,T/320", "--out", folder},
             folder);
  const std::size_t survived = runs_there(folder);
  REQUIRE(survived >= 7);
  REQUIRE(survived < 20);
  std::ofstream(folder + "/runs.journal", std::ios::app)
      << "0123456789abcdef\tR\tcut of";  // a line half written
  const Outcome again = run_perp(scratch, scenes + steps + "--out " + folder);
  CHECK(again.status == 0);
  CHECK(again.out.find("20 runs: " + std::to_string(20 - survived) + " made now, " +
                       std::to_string(survived) + " found there, 0 failed") != std::string::npos);
  CHECK(without_seconds(folder) == without_seconds(scratch / "alone"));
  CHECK(contents(folder + "/orders.csv") == contents(scratch / "alone/orders.csv"));
  CHECK(run_perp(scratch, scenes + steps + "--out " + folder).out.find("0 made now, 20 found") !=
        std::string::npos);
}

TEST_CASE("a journal's run whose line was damaged is made again", "[study]") {
  const Scratch scratch("study-damaged");
  const std::string command = "study bead-in-ring --methods lcp " + steps + "--out " + (scratch / "o");
  REQUIRE(run_perp(scratch, command).status == 0);
  const Table before = without_seconds(scratch / "o");
  std::string journal = contents(scratch / "o/runs.journal");
  journal[journal.rfind("\tR\t") + 60] ^= 1;
  std::ofstream(scratch / "o/runs.journal", std::ios::binary) << journal;
  CHECK(run_perp(scratch, command).out.find("5 runs: 1 made now, 4 found there") != std::string::npos);
  CHECK(without_seconds(scratch / "o") == before);
}

TEST_CASE("runs of another setting are not taken for those of this one", "[study]") {
  const Scratch scratch("study-settings");
  const std::string command = "study bead-in-ring --methods lcp --steps T/20,T/40 --out " + (scratch / "o");
  REQUIRE(run_perp(scratch, command).status == 0);
  for (const char* change : {" --set mu=0.2", " --until 0.5", " --edges 4", " --velocity l1"})
    CHECK(run_perp(scratch, command + change).out.find("2 made now, 0 found") != std::string::npos);
  CHECK(run_perp(scratch, command).out.find("0 made now, 2 found") != std::string::npos);
}

TEST_CASE("shards put together are the whole study, and so are threads", "[study]") {
  const Scratch scratch("study-shards");
  REQUIRE(run_perp(scratch, scenes + steps + "--out " + (scratch / "whole")).status == 0);
  std::string merge = "study --out " + (scratch / "merged") + " --merge";
  for (const char* shard : {"1/3", "2/3", "3/3"}) {
    const std::string folder = scratch / ("part" + std::string(1, shard[0]));
    const Outcome part = run_perp(scratch, scenes + steps + "--shard " + shard + " --out " + folder);
    CHECK(part.status == 0);
    CHECK(runs_there(folder) >= 6);
    CHECK(runs_there(folder) <= 7);
    CHECK_FALSE(std::filesystem::exists(folder + "/study.csv"));
    merge += " " + folder;
  }
  CHECK(run_perp(scratch, merge).status == 0);
  CHECK(without_seconds(scratch / "merged") == without_seconds(scratch / "whole"));
  CHECK(contents(scratch / "merged/orders.csv") == contents(scratch / "whole/orders.csv"));
  const Outcome partial = run_perp(scratch, "study --merge " + (scratch / "part1") + " " +
                                                (scratch / "part3") + " --out " + (scratch / "two"));
  CHECK(partial.status == 1);
  CHECK(partial.err.find("runs are left: a shard is missing") != std::string::npos);
  CHECK(contents(scratch / "two/study.html").find("of 20 runs have not been made yet") != std::string::npos);

  REQUIRE(run_perp(scratch, scenes + steps + "--jobs 3 --out " + (scratch / "threads")).status == 0);
  CHECK(without_seconds(scratch / "threads") == without_seconds(scratch / "whole"));
}

TEST_CASE("a budget ends a study between two runs, and the same command goes on with it", "[study]") {
  const Scratch scratch("study-budget");
  const std::string command = scenes + steps + "--out " + (scratch / "o");
  const Outcome none = run_perp(scratch, command + " --budget 0");
  CHECK(none.status == 1);
  CHECK(none.err.find("20 runs are left: the same command goes on with them") != std::string::npos);
  CHECK(run_perp(scratch, command).status == 0);
}

TEST_CASE("a run that fails is a row, an exit status of 1 and a sentence on the page", "[study]") {
  const Scratch scratch("study-failed");
  std::ofstream(scratch / "wild.toml") << "[[body]]\nname = \"bead\"\nkind = \"particle\"\nmass = 1\n"
                                       << "[[force]]\nbody = \"bead\"\n"  // not a number near t = 0.53
                                       << "force = [\"sqrt((t - 0.53)^2 - 0.0001)\", 0, 0]\n";
  const Outcome done =
      run_perp(scratch, "study " + (scratch / "wild.toml") + " --methods lcp --steps 0.1,0.05,0.025 --out " +
                            (scratch / "o"));
  CHECK(done.status == 1);
  CHECK(done.err.find("1 runs ended at a step that did not reach its tolerance") != std::string::npos);
  auto table = columns(scratch / "o/study.csv");
  CHECK(table["failed"] == std::vector<std::string>{"0", "0", "1"});
  CHECK(table["steps"] == std::vector<std::string>{"10", "20", "20"});
  CHECK(table["error_q"][2].empty());
  CHECK(table["message"][2].find("did not advance") != std::string::npos);
  CHECK(columns(scratch / "o/orders.csv")["order"][0].empty());
  const std::string page = contents(scratch / "o/study.html");
  CHECK(page.find("In 1 of 3 runs a step did not reach its tolerance") != std::string::npos);
}

TEST_CASE("a study is refused before it runs anything", "[study]") {
  const Scratch scratch("study-refused");
  const auto error = [&](const std::string& arguments) {
    const Outcome done = run_perp(scratch, "study " + arguments + " --out " + (scratch / "o"));
    CHECK(done.status == 2);
    CHECK_FALSE(std::filesystem::exists(scratch / "o/study.csv"));
    return done.err;
  };
  CHECK(error("seed-sphere --methods lpc").find("lcp, lcp-ap") != std::string::npos);
  CHECK(error("no-such-scene --methods lcp").find("no-such-scene") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp --steps 0.1,T/0").find("T/0") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp --steps=-0.1").find("-0.1") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp --shard 4/3").find("4/3") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp --edges 2").find("edges") != std::string::npos);
  CHECK(error("seed-sphere seed-sphere --methods lcp").find("once") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp,lcp").find("once") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp --set colour=3").find("colour") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp --velocity end-ish").find("end, l1 or graph") != std::string::npos);
  CHECK(error("seed-sphere --methods lcp --tolerances 1e-3").find("--tolerances") != std::string::npos);
  CHECK(error("seed-sphere").find("--methods") != std::string::npos);
  CHECK(error("--merge " + (scratch / "nothing")).find("holds no study") != std::string::npos);
}

TEST_CASE("a method that chooses its steps takes tolerances for levels, and its error follows them",
          "[study]") {
  if (!has_sundials()) return;
  const Scratch scratch("study-tolerances");
  const Outcome done = run_perp(
      scratch, "study seed-sphere --methods ncp2,event --steps T/20,T/40 --tolerances 1e-5,1e-9 --out " +
                   (scratch / "o"));
  CHECK(done.status == 0);
  const Table table = columns(scratch / "o/study.csv");
  REQUIRE(table.at("method") == std::vector<std::string>{"ncp2", "ncp2", "event", "event"});
  CHECK(std::stod(table.at("rtol")[2]) == 1e-5);
  CHECK(std::stod(table.at("rtol")[3]) == 1e-9);
  CHECK(table.at("h")[2].empty());
  CHECK(std::stod(table.at("error_q")[2]) < 1e-3);
  CHECK(std::stod(table.at("error_q")[3]) < 1e-7);
  CHECK(std::stod(table.at("error_q")[0]) > std::stod(table.at("error_q")[3]));
  CHECK(contents(scratch / "o/study.html").find("event") != std::string::npos);
}

TEST_CASE("without gnuplot all but the pictures is written, and it is said", "[study]") {
  const Scratch scratch("study-no-gnuplot");
  const Outcome done =
      run_perp(scratch, "study seed-sphere --methods lcp --steps T/20,T/40,T/80 --out " + (scratch / "o"),
               "PATH=/nowhere");
  CHECK(done.status == 0);
  CHECK(done.err == "perp: no pictures: gnuplot is not installed; their data and scripts are there\n");
  CHECK(std::filesystem::exists(scratch / "o/seed-sphere-work.csv"));
  CHECK(std::filesystem::exists(scratch / "o/seed-sphere-work.gnuplot"));
  CHECK_FALSE(std::filesystem::exists(scratch / "o/seed-sphere-work.svg"));
  CHECK(contents(scratch / "o/study.html").find("seed-sphere-work: no picture") != std::string::npos);
}

}  // namespace perp
