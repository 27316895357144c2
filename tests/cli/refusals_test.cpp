// What cannot be meant, or would not be used, is refused; nothing ends in a crash or in silence.
#include <catch2/catch.hpp>

#include "tests/cli/program.hpp"

namespace perp {
namespace {

using Catch::Contains;

void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

const char* const lcp_file = "2\n0\n2\n2\n2 2\n2 1\n1 2\n-5 -6\n";

struct Line {
  const char *arguments, *says;
};

TEST_CASE("numbers that are none, empty values and options that nothing uses are refused by name",
          "[refusals]") {
  const Scratch scratch("refusals");
  const std::string out = " --out " + (scratch / "o");
  const Line lines[] = {
      {"run seed-sphere --method lcp --step 0.1 --until nan", "--until"},
      {"run seed-sphere --method lcp --step 0.1 --until inf", "--until"},
      {"run seed-sphere --method event --tolerance nan", "--tolerance"},
      {"run seed-sphere --method lcp --step nan", "--step"},
      {"run seed-sphere --method lcp --step ''", "--step"},
      {"run seed-sphere --method lcp --step 0x1p-3", "--step"},
      {"run seed-sphere --method lcp --step 0.7 --until 0.6", "no longer than the run"},
      {"run seed-sphere --method lcp --step 1e-320", "steps at most"},
      {"run seed-sphere --method '' --step 0.1", "--method"},
      {"run '' --method lcp --step 0.1", "SCENE"},
      {"run seed-sphere --method lcp --step 0.1 --set ''", "--set"},
      {"run seed-sphere --method lcp --step 0.1 --set mu=", "mu="},
      {"run seed-sphere --method lcp --step 0.1 --set mu=nan", "mu"},
      {"run seed-sphere --method ncp --step 0.1 --edges 8", "--edges"},
      {"run seed-sphere --method event --edges 8", "--edges"},
      {"run seed-sphere --method lcp --step 0.1 --edges 8.5", "--edges"},
      {"run seed-sphere --method lcp --step 0.1 --edges 0x10", "--edges"},
      {"run seed-sphere --method lcp --step 0.1 --edges ''", "--edges"},
      {"run seed-sphere --method lcp --step 0.1 --edges 99999999999999999999", "--edges"},
      {"run seed-sphere --method lcp --step 0.1 --every 1e3", "--every"},
      {"run seed-sphere --method ncp --step 0.1 --tolerance 1e-6", "--tolerance"},
      {"run seed-sphere --method lcp --step 0.1 --integrator ida", "--integrator"},
      {"run seed-sphere --method event --reactions minimum-norm", "--reactions"},
      {"run seed-sphere --method lcp --step 0.1 --budget nan", "--budget"},
      {"run seed-sphere --method lcp --step 0.1 --budget -1", "--budget"},
      {"run seed-sphere --method lcp --step 0.1 --quiet --verbose", "--quiet"},
      {"study seed-sphere --methods ncp --edges 8", "--edges"},
      {"study seed-sphere --methods event --steps 0.1", "--steps"},
      {"study seed-sphere --methods lcp --steps nan", "nan"},
      {"study seed-sphere --methods event --tolerances nan", "--tolerances"},
      {"study seed-sphere --methods lcp --until nan", "--until"},
      {"study seed-sphere --methods lcp --budget nan", "--budget"},
      {"study seed-sphere --methods lcp --jobs 0", "--jobs"},
      {"study seed-sphere --methods lcp --jobs 2.5", "--jobs"},
      {"study seed-sphere --methods lcp --shard 2/1", "--shard"},
      {"generate box4 --seed -1 --count 1", "--seed"},
      {"generate box4 --seed 1 --count 0", "--count"},
      {"generate box4 --seed 1 --count 1 --contacts 100", "--contacts"},
  };
  for (const Line& line : lines) {
    const Outcome done = run_perp(scratch, line.arguments + out);
    CAPTURE(line.arguments, done.err);
    CHECK(done.status == 2);
    CHECK(done.err.substr(0, 6) == "perp: ");
    CHECK(done.err.find(line.says) != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(scratch / "o"));
  }
  for (const char* tolerance : {"nan", "0", "-1", "inf", "''"}) {
    write(scratch / "a.dat", lcp_file);
    const Outcome done = run_perp(scratch, "solve " + (scratch / "a.dat") + " --tolerance " + tolerance);
    CAPTURE(tolerance, done.err);
    CHECK(done.status == 2);
    CHECK_THAT(done.err, Contains("--tolerance"));
  }
  CHECK(run_perp(scratch, "run seed-sphere --method lcp --step 0.1 --out ''").status == 2);
}

TEST_CASE("numbers with zeros in front are decimal", "[refusals]") {
  const Scratch scratch("zeros");
  const auto run = [&](const std::string& options, const std::string& to) {
    const Outcome done = run_perp(
        scratch, "run oblique-sphere --method lcp --step 0.05 " + options + " --out " + (scratch / to));
    CAPTURE(options, done.err);
    CHECK(done.status == 0);
    return contents(scratch / (to + "/trajectory.csv"));
  };
  const std::string ten = run("--edges 10", "a"), eight = run("--edges 8", "b");
  CHECK(ten != eight);
  CHECK(run("--edges 010", "c") == ten);
  CHECK(run("--edges 08", "d") == eight);
  CHECK(run("--edges 8 --every 0002", "e") == run("--edges 8 --every 2", "f"));
  CHECK(run("--edges 8 --set mu=00.2", "g") == run("--edges 8 --set mu=0.2", "h"));
}

TEST_CASE("an output that is full is an error of every command, with a sentence", "[refusals]") {
  const Scratch scratch("full");
  write(scratch / "good.dat", lcp_file);
  for (const std::string& arguments :
       {"solve " + (scratch / "good.dat"), "solve --csv " + (scratch / "good.dat"), std::string("scenes"),
        std::string("scenes seed-sphere --toml"), std::string("methods"), std::string("check seed-sphere"),
        std::string("--version"), std::string("--help"), std::string("run --help"),
        "run seed-sphere --method lcp --step 0.1 --out " + (scratch / "o"),
        "study seed-sphere --methods lcp --steps 0.1,0.05 --out " + (scratch / "s")}) {
    const int raw =
        std::system((PERP_PROGRAM " " + arguments + " >/dev/full 2>" + (scratch / "err")).c_str());
    CAPTURE(arguments);
    CHECK(WEXITSTATUS(raw) == 3);
    CHECK_THAT(contents(scratch / "err"), Contains("perp: standard output could not be written"));
  }
}

TEST_CASE("perp solve goes on past what is no file, and says what it is", "[refusals]") {
  const Scratch scratch("solve-folder");
  write(scratch / "good.dat", lcp_file);
  std::filesystem::create_directories(scratch / "folder");
  const Outcome done = run_perp(scratch, "solve " + (scratch / "folder") + " " + (scratch / "good.dat"));
  CHECK(done.status == 2);
  CHECK_THAT(done.err, Contains((scratch / "folder") + ": Is a directory"));
  CHECK_THAT(done.out, Contains("good.dat: lcp solved"));
}

TEST_CASE("more jobs than a system has threads are as many as it gives", "[refusals]") {
  const Scratch scratch("jobs");
  const Outcome done =
      run_perp(scratch, "study seed-sphere --methods lcp --steps 0.1,0.05,0.025 --jobs 100000 --out " +
                            (scratch / "o"));
  CHECK(done.status == 0);
  CHECK_THAT(done.out, Contains("3 runs: 3 made now"));
}

TEST_CASE("a journal's row that is well-formed and no run of this study is made again", "[refusals]") {
  const Scratch scratch("journal");
  const std::string study = "study seed-sphere --methods lcp --steps 0.1,0.05 --out " + (scratch / "o");
  REQUIRE(run_perp(scratch, study).status == 0);
  const std::string rows = contents(scratch / "o/runs.journal");
  const auto checksum = [](const std::string& text) {  // FNV-1a
    std::uint64_t hash = 0xcbf29ce484222325U;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
    return std::string(digits);
  };
  const std::size_t row = rows.find("\tR\t");
  const std::string good = rows.substr(row + 1, rows.find('\n', row) - row - 1);
  std::vector<std::string> cells;
  std::istringstream in(good);
  for (std::string cell; std::getline(in, cell, '\t');) cells.push_back(cell);
  cells.resize(14);
  for (std::size_t i = 2; i < cells.size(); ++i)
    for (const char* wrong : {"", "many", "1e999", "-1e300", "nan", "1 2 3"}) {
      std::vector<std::string> changed = cells;
      changed[i] = wrong;
      std::string line;
      for (const std::string& cell : changed) line += (line.empty() ? "" : "\t") + cell;
      write(scratch / "o/runs.journal", checksum(line) + "\t" + line + "\n" + checksum("R\tx") + "\tR\tx\n");
      const Outcome again = run_perp(scratch, study);
      CAPTURE(i, wrong, again.err);
      CHECK(again.status == 0);
    }
}

TEST_CASE("a start that overlaps is said once, and run only if it is small or meant", "[refusals]") {
  const Scratch scratch("overlap");
  const auto scene = [&](const std::string& z) {
    write(scratch / "s.toml",
          "[[body]]\nname = \"ball\"\nkind = \"spatial\"\nmass = 1\ninertia = { shape = \"solid_sphere\", "
          "radius = 0.1 }\n"
          "position = [0, 0, " +
              z +
              "]\n[[contact]]\nname = \"floor\"\na = \"ground\"\nb = \"ball\"\n"
              "gap = { kind = \"sphere_on_plane\", radius = 0.1 }\nmu = 0.3\n");
  };
  const auto run = [&](const std::string& options) {
    return run_perp(scratch, "run " + (scratch / "s.toml") + " --method ncp2 --step 0.01 --until 0.1 --out " +
                                 (scratch / "o") + options);
  };
  scene("0.05");
  const Outcome refused = run("");
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("contact floor overlaps by 0.05 m") && Contains("--allow-overlap") &&
                              Contains("--assemble"));
  CHECK_FALSE(std::filesystem::exists(scratch / "o"));
  const Outcome meant = run(" --allow-overlap");
  CHECK(meant.status == 0);
  CHECK_THAT(meant.err, Contains("contact floor overlaps by 0.05 m"));
  CHECK(std::stod(columns(scratch / "o/trajectory.csv")["ball.vz"][1]) > 1);  // pushed out within a step
  const Outcome assembled = run(" --assemble");
  CHECK(assembled.status == 0);
  CHECK(assembled.err.empty());
  CHECK(std::abs(std::stod(columns(scratch / "o/trajectory.csv")["ball.vz"].back())) < 1e-9);
  scene("0.09999");
  const Outcome small = run("");
  CHECK(small.status == 0);
  CHECK_THAT(small.err, Contains("contact floor overlaps by 1e-05 m"));
  scene("0.1");
  CHECK(run("").err.empty());
}

TEST_CASE("a quaternion far from unit length is refused where it stands", "[refusals]") {
  const Scratch scratch("quaternion");
  const auto check = [&](const std::string& q) {
    write(scratch / "s.toml",
          "[[body]]\nname = \"box\"\nkind = \"spatial\"\nmass = 1\ninertia = { shape = \"box\", size = [1, "
          "1, 1] }\n"
          "orientation = " +
              q + "\n");
    return run_perp(scratch, "check " + (scratch / "s.toml"));
  };
  CHECK(check("[0.7071, 0, 0.7071, 0]").status == 0);
  for (const char* q :
       {"[2, 0, 0, 0]", "[1, 0, 1, 0]", "[0.5, 0, 0, 0]", "[0, 0, 0, 0]", "[1e200, 1e200, 0, 0]"}) {
    const Outcome refused = check(q);
    CAPTURE(q, refused.err);
    CHECK(refused.status == 2);
    CHECK_THAT(refused.err, Contains("s.toml:6:15: a quaternion of length "));
  }
}

TEST_CASE("a run of one step may be written with fewer digits than the step", "[refusals]") {
  const Scratch scratch("one-step");
  CHECK(run_perp(scratch,
                 "run seed-sphere --method lcp --step 0.0123456 --until 0.0123 --out " + (scratch / "o"))
            .status == 0);
  CHECK(columns(scratch / "o/trajectory.csv")["t"].back() == "0.0123");
}

TEST_CASE("a quiet run prints nothing, a verbose one a line a step", "[refusals]") {
  const Scratch scratch("verbose");
  const std::string run = "run seed-sphere --method lcp --step 0.1 --out " + (scratch / "o");
  CHECK(run_perp(scratch, run + " --quiet").out.empty());
  const std::string out = run_perp(scratch, run + " --verbose").out;
  CHECK_THAT(out, Contains("t = 0.3, h = 0.0999") && Contains("lemke"));
  std::size_t lines = 0;
  for (std::size_t at = 0; (at = out.find("t = 0.", at)) != std::string::npos; ++at) ++lines;
  CHECK(lines == 7);  // six steps and the summary
}

}  // namespace
}  // namespace perp
