// Runs that are stopped, killed, out of disk or out of time: what is on the disk is whole, and --resume goes on to the same bytes.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>

#include "tests/cli/program.hpp"

namespace perp {
namespace {

const std::vector<std::string> tables = {"trajectory.csv", "contacts.csv", "joints.csv", "report.csv"};

void check_same_bytes(const Scratch& scratch, const std::string& a, const std::string& b) {
  for (const std::string& table : tables) {
    CAPTURE(table);
    const std::string left = contents(scratch / (a + "/" + table)),
                      right = contents(scratch / (b + "/" + table));
    CHECK(left.size() > 10);
    CHECK((left == right));  // not printed: they are long
  }
}

void check_whole_rows(const std::string& folder) {
  for (const std::string& table : tables) {
    const std::string text = contents(folder + "/" + table);
    CAPTURE(folder, table);
    REQUIRE_FALSE(text.empty());
    CHECK(text.back() == '\n');
    const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
    std::istringstream lines(text);
    std::string header, line;
    std::getline(lines, header);
    while (std::getline(lines, line)) REQUIRE(commas(line) == commas(header));
  }
}

nlohmann::json record(const std::string& folder) {
  return nlohmann::json::parse(contents(folder + "/run.json"));
}

struct Case {
  const char* method;
  const char* scene;  // and its step and end, some seconds of work
};

// The tower's contacts are redundant, and its implicit methods begin each step from the impulses of the last.
const Case cases[] = {{"lcp", "tower --set count=3 --step 1e-4 --until 0.6"},
                      {"ncp", "tower --set count=3 --step 2e-4 --until 0.4"},
                      {"ncp2", "oblique-sphere --step 2e-5 --until 2"},
                      {"event", "double-pendulum --tolerance 1e-11 --until 100"}};

std::string run_of(const Case& c) {
  return std::string("run ") + c.scene + " --method " + c.method + " --every 3 --out ";
}

/// Interrupts the run of `c` after `seconds`, by `signal`, until it is complete; how often that was.
int to_the_end_by_pieces(const Scratch& scratch, const Case& c, const std::string& signal, double seconds) {
  const std::string stop = "timeout --preserve-status -s " + signal + " " + std::to_string(seconds);
  Outcome piece = run_perp(scratch, run_of(c) + (scratch / "cut"), stop);
  int pieces = 1, told = 0;
  while (piece.status != 0) {
    REQUIRE(pieces < 200);
    if (!std::filesystem::exists(scratch / "cut/run.json")) {  // the signal came before the run
      piece = run_perp(scratch, run_of(c) + (scratch / "cut"),
                       "timeout --preserve-status -s " + signal + " " + std::to_string(seconds * ++pieces));
      continue;
    }
    const bool before_main = piece.status > 128 && piece.err.empty();  // of a program that is being loaded
    if (signal != "KILL" && !before_main) {
      ++told;
      CHECK(piece.status == 1);
      CHECK_THAT(piece.err, Catch::Contains("stopped by SIG" + signal + " at t = ") &&
                                Catch::Contains("perp run --resume"));
      check_whole_rows(scratch / "cut");
      CHECK(record(scratch / "cut")["exit_status"] == 1);
    }
    // longer each time: a method that can only begin again needs its whole time at last
    piece = run_perp(scratch, "run --resume " + (scratch / "cut"),
                     "timeout --preserve-status -s " + signal + " " + std::to_string(seconds * ++pieces));
  }
  if (signal != "KILL" && pieces > 1) CHECK(told > 0);
  return pieces;
}

TEST_CASE("a run that is stopped or killed goes on with --resume to the bytes of the run left alone",
          "[resume]") {
  const auto& c = cases[GENERATE(0, 1, 2, 3)];
  const std::string signal = GENERATE("TERM", "KILL");
  CAPTURE(c.method, signal);
  const Scratch scratch(std::string("resume-") + c.method + signal);
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(run_perp(scratch, run_of(c) + (scratch / "alone")).status == 0);
  const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - begin;
  int pieces = 0;
  for (double part = 0.3; pieces <= 1 && part > 0.03; part /= 2) {  // the machine may have become faster
    std::filesystem::remove_all(scratch / "cut");
    pieces = to_the_end_by_pieces(scratch, c, signal, part * whole.count());
  }
  CHECK(pieces > 1);
  check_same_bytes(scratch, "alone", "cut");
  CHECK(record(scratch / "cut")["exit_status"] == 0);
  CHECK_FALSE(std::filesystem::exists(scratch / "cut/run.restart"));
  const Outcome again = run_perp(scratch, "run --resume " + (scratch / "cut"));
  CHECK(again.status == 0);
  CHECK_THAT(again.out, Catch::Contains("is complete"));
}

TEST_CASE("ten moments, three signals, each method: the same bytes", "[resume][slow]") {
  const auto& c = cases[GENERATE(0, 1, 2, 3)];
  const std::string signal = GENERATE("TERM", "INT", "KILL");
  const Scratch scratch(std::string("moments-") + c.method + signal);
  REQUIRE(run_perp(scratch, run_of(c) + (scratch / "alone")).status == 0);
  for (int moment = 1; moment <= 10; ++moment) {
    CAPTURE(c.method, signal, moment);
    std::filesystem::remove_all(scratch / "cut");
    (void)to_the_end_by_pieces(scratch, c, signal, 0.07 * moment);
    check_same_bytes(scratch, "alone", "cut");
  }
}

TEST_CASE("rows are on the disk a second after they were computed, whatever ends the run", "[resume]") {
  const Scratch scratch("resume-rows");
  const std::string run =
      "run oblique-sphere --method ncp2 --step 1e-7 --until 2 --verbose --out " + (scratch / "o");
  (void)run_perp(scratch, run, "timeout -s KILL 2");
  // what it printed last, and what it wrote last
  const std::string out = contents(scratch / "stdout");
  const std::size_t last = out.rfind("\nt = ", out.size() - 2);
  REQUIRE(last != std::string::npos);
  const double printed = std::stod(out.substr(last + 5));
  auto table = columns(scratch / "o/trajectory.csv");
  const double written = std::stod(table["t"][table["t"].size() - 2]);  // the last may be cut
  CHECK(printed > 0);
  CHECK(written > 0.4 * printed);  // one second of two
}

TEST_CASE("a budget ends a run with status 1, whole rows, and a sentence that says how to go on",
          "[resume]") {
  const Scratch scratch("resume-budget");
  const std::string run = run_of(cases[2]);
  const Outcome ended = run_perp(scratch, run + (scratch / "o") + " --budget 0.2");
  CHECK(ended.status == 1);
  CHECK_THAT(ended.err, Catch::Contains("stopped by --budget 0.2 at t = ") &&
                            Catch::Contains("perp run --resume " + (scratch / "o")));
  check_whole_rows(scratch / "o");
  const nlohmann::json json = record(scratch / "o");
  CHECK(json["exit_status"] == 1);
  CHECK(json["ended"].get<std::string>().substr(0, 30) == "stopped by --budget 0.2 at t =");
  CHECK(run_perp(scratch, "run --resume " + (scratch / "o") + " --quiet").out.empty());
  REQUIRE(run_perp(scratch, run + (scratch / "alone")).status == 0);
  check_same_bytes(scratch, "alone", "o");
}

TEST_CASE("a full disk leaves whole rows and says why and where, and --resume goes on", "[resume]") {
  const Scratch scratch("resume-full");
  const std::string run = run_of(cases[2]);
  const Outcome full = run_perp(scratch, run + (scratch / "o"), "ulimit -f 600;");  // 512 or 1024 bytes each
  CHECK(full.status == 3);
  CHECK_THAT(full.err, Catch::Contains(".csv: File too large") && Catch::Contains("rows are whole") &&
                           Catch::Contains("had come to t = "));
  check_whole_rows(scratch / "o");
  CHECK(run_perp(scratch, "run --resume " + (scratch / "o")).status == 0);
  REQUIRE(run_perp(scratch, run + (scratch / "alone")).status == 0);
  check_same_bytes(scratch, "alone", "o");
}

TEST_CASE(
    "what is taken up again refuses a folder whose scene, version, method or restart is not that of the run",
    "[resume]") {
  const Scratch scratch("resume-refuses");
  std::ofstream(scratch / "s.toml") << run_perp(scratch, "scenes oblique-sphere --toml").out;
  const std::string run = "run " + (scratch / "s.toml") +
                          " --method ncp2 --step 2e-5 --until 2 --budget 0.4 --out " + (scratch / "o");
  REQUIRE(run_perp(scratch, run).status == 1);
  const auto refused = [&](const std::string& file, const std::string& from, const std::string& to,
                           const std::string& says) {
    const std::string before = contents(scratch / file);
    std::string text = before;
    REQUIRE(text.find(from) != std::string::npos);
    text.replace(text.find(from), from.size(), to);
    std::ofstream(scratch / file) << text;
    const std::string rows = contents(scratch / "o/trajectory.csv");
    const Outcome outcome = run_perp(scratch, "run --resume " + (scratch / "o"));
    CAPTURE(file, to, outcome.err);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.err, Catch::Contains(says));
    CHECK(contents(scratch / "o/trajectory.csv") == rows);
    std::ofstream(scratch / file) << before;
  };
  refused("s.toml", "gravity", "# other\ngravity", "s.toml is no longer that of the run");
  refused("o/run.json", "\"method\": \"ncp2\"", "\"method\": \"ncp\"", "the method in run.json");
  refused("o/run.json", "\"step\": 2e-05", "\"step\": 2e-04", "the method in run.json");
  refused("o/run.json", "\"perp\": \"0.", "\"perp\": \"9.", "made by perp 9.");
  refused("o/run.json", "\"command\"", "\"commando\"", "run.json:1:1: ");
  refused("o/run.json", "{", "{{", "run.json:1:2: this is no JSON");
  refused("o/run.restart", "nu ", "nu 1", "damaged");
  CHECK(run_perp(scratch, "run --resume " + (scratch / "o") + " --step 1").status == 2);
  CHECK(run_perp(scratch, "run --resume " + (scratch / "nowhere")).status == 2);
  std::filesystem::remove(scratch / "s.toml");  // nothing else is needed
  CHECK(run_perp(scratch, "run --resume " + (scratch / "o")).status == 0);
}

TEST_CASE("a folder takes one run at a time", "[folder]") {
  const Scratch scratch("run-lock");
  const std::string long_run =
      "run oblique-sphere --method ncp2 --step 1e-7 --until 2 --out " + (scratch / "o");
  const Outcome second = run_perp(scratch, "run seed-sphere --method lcp --step 0.1 --out " + (scratch / "o"),
                                  "timeout 3 " PERP_PROGRAM " " + long_run + " >/dev/null 2>&1 & sleep 1;");
  CHECK(second.status == 2);
  CHECK_THAT(second.err, Catch::Contains("another run is writing to it"));
  CHECK(contents(scratch / "o/run.json").find("oblique-sphere") != std::string::npos);
}

TEST_CASE("a folder that vanishes while a run goes on is an error that names it", "[folder]") {
  const Scratch scratch("run-vanishes");
  const Outcome gone =
      run_perp(scratch, "run oblique-sphere --method ncp2 --step 1e-7 --until 2 --out " + (scratch / "o"),
               "(sleep 1; rm -r " + (scratch / "o") + ") & timeout 20");
  CHECK(gone.status == 3);
  CHECK_THAT(gone.err, Catch::Contains((scratch / "o")) && Catch::Contains("No such file or directory"));
}

TEST_CASE("a run by event says how many events and evaluations it had", "[folder]") {
  const Scratch scratch("run-evaluations");
  const Outcome run =
      run_perp(scratch, "run seed-sphere --method event --tolerance 1e-8 --out " + (scratch / "o"));
  REQUIRE(run.status == 0);
  const std::size_t events = columns(scratch / "o/events.csv")["t"].size();
  CHECK(events > 0);
  CHECK_THAT(run.out, Catch::Contains(std::to_string(events) + " events, "));
  CHECK(run.out.find(", 0 evaluations") == std::string::npos);
}

TEST_CASE("run.json says what was run, from what, with what, when and how it ended", "[folder]") {
  const Scratch scratch("run-json");
  REQUIRE(run_perp(scratch,
                   "run seed-sphere --method lcp --step 0.1 --edges 6 --set mu=0.25 --out " + (scratch / "o"))
              .status == 0);
  const nlohmann::json json = record(scratch / "o");
  CHECK(json["command"][1] == "run");
  CHECK(json["command"].size() == 13);
  CHECK(json["scene"]["given"] == "seed-sphere");
  CHECK_THAT(json["scene"]["text"].get<std::string>(), Catch::Contains("[[body]]"));
  CHECK(json["parameters"]["mu"] == 0.25);
  CHECK(json["set"] == nlohmann::json{{"mu", 0.25}});
  CHECK(json["run"]["method"] == "lcp");
  CHECK(json["run"]["edges"] == 6);
  CHECK(json["run"]["step"] == 0.1);
  CHECK(json["run"]["until"] == 0.6);
  CHECK("perp " + json["versions"]["perp"].get<std::string>() + "\n" == run_perp(scratch, "--version").out);
  CHECK(json["versions"].contains("eigen"));
  CHECK_FALSE(json["build"].get<std::string>().empty());
  CHECK_FALSE(json["machine"].get<std::string>().empty());
  CHECK(json["start"].get<std::string>() <= json["end"].get<std::string>());
  CHECK(json["end"].get<std::string>().size() == 20);
  CHECK(json["exit_status"] == 0);
}

/// Largest resident memory of `perp ARGUMENTS` [kB], which ends with 0.
long memory_of(const Scratch& scratch, const std::string& arguments) {
  const std::string command = "exec " PERP_PROGRAM " " + arguments + " >" + (scratch / "stdout") + " 2>&1";
  const pid_t child = fork();
  if (child == 0) {
    execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = -1;
  rusage used{};
  REQUIRE(wait4(child, &status, 0, &used) == child);
  CAPTURE(arguments, contents(scratch / "stdout"));
  CHECK(status == 0);
  return used.ru_maxrss;
}

#if defined(__SANITIZE_ADDRESS__)
constexpr long most_memory = 1000000;  // the sanitizers' own
#else
constexpr long most_memory = 100000;
#endif

TEST_CASE("a run's memory does not grow with its steps, whatever --every", "[folder]") {
  const Scratch scratch("run-memory");
  const std::string out = " --quiet --out " + (scratch / "o");
  CHECK(memory_of(scratch, "run seed-sphere --method lcp --step 6e-7 --every 1000" + out) < most_memory);
  CHECK(memory_of(scratch, "run seed-sphere --method lcp --step 6e-6 --every 1" + out) < most_memory);
}

TEST_CASE("a million steps stay below 100 MB, every row written", "[folder][slow]") {
  const Scratch scratch("run-million");
  const std::string out = " --quiet --out " + (scratch / "o");
  CHECK(memory_of(scratch, "run seed-sphere --method lcp --step 6e-7 --every 1" + out) < most_memory);
}

}  // namespace
}  // namespace perp
