#include <catch2/catch.hpp>
#include <fstream>

#include "tests/cli/program.hpp"

namespace perp {
namespace {

const char* const lcp_file = "2\n0\n2\n2\n2 2\n2 1\n1 2\n-5 -6\n";  // z = (4/3, 7/3)
const char* const infeasible_file = "1\n0\n1\n1\n1 1\n-1\n-1\n";    // -z - 1 >= 0
const char* const mixed_file =
    "1 0\n1\n1\n0 1 2\n0 1\n0 2 2\n2 2\n2 1\n0 1\n-4 -1\n";  // 2 u = 4, 0 <= v ⟂ u + v - 1
const char* const broken_file = "2\n0\n2\n2\n2 2\n2 1\n1 two\n";

void write(const std::string& path, const char* text) { std::ofstream(path) << text; }

TEST_CASE("perp solve --csv has a row a file, finds out its kind and goes on after a bad one", "[solve]") {
  const Scratch scratch("solve-csv");
  write(scratch / "a.dat", lcp_file);
  write(scratch / "b.dat", broken_file);
  write(scratch / "c.dat", mixed_file);
  const std::string files = (scratch / "a.dat") + " " + (scratch / "b.dat") + " " + (scratch / "c.dat");
  const Outcome done = run_perp(scratch, "solve --csv " + files);
  CHECK(done.status == 2);
  CHECK(done.err.find("b.dat:7:3: matrix entry is \"two\", a finite number is needed") != std::string::npos);
  CHECK(done.out.substr(0, done.out.find('\n')) ==
        "file,kind,contacts,rank,status,stage,iterations,residual_absolute,residual_relative,residual_file,"
        "seconds,existence");
  auto table = columns(scratch / "stdout");
  CHECK(table["kind"] == std::vector<std::string>{"lcp", "lcp", "mlcp"});
  CHECK(table["status"] == std::vector<std::string>{"solved", "bad-file", "solved"});
  CHECK(table["rank"] == std::vector<std::string>{"2", "", "1"});
  CHECK(std::stod(table["residual_absolute"][0]) < 1e-14);
  CHECK(std::stod(table["residual_relative"][2]) < 1e-14);
}

TEST_CASE("perp solve ends with 0 where all is solved, 1 where a problem is not, 2 where it cannot be read",
          "[solve]") {
  const Scratch scratch("solve-status");
  write(scratch / "good.dat", lcp_file);
  write(scratch / "none.dat", infeasible_file);
  CHECK(run_perp(scratch, "solve " + (scratch / "good.dat")).status == 0);
  CHECK(run_perp(scratch, "solve --solver lemke --kind lcp " + (scratch / "good.dat")).status == 0);
  const Outcome none = run_perp(scratch, "solve " + (scratch / "good.dat") + " " + (scratch / "none.dat"));
  CHECK(none.status == 1);
  CHECK(none.out.find("none.dat: lcp no-solution") != std::string::npos);
  CHECK(run_perp(scratch, "solve " + (scratch / "absent.dat")).status == 2);
  CHECK(run_perp(scratch, "solve --solver simplex " + (scratch / "good.dat")).status == 2);
  CHECK(run_perp(scratch, "solve --kind puzzle " + (scratch / "good.dat")).status == 2);
  CHECK(run_perp(scratch, "solve").status == 2);
}

TEST_CASE("perp solve --solutions writes z and w of each file", "[solve]") {
  const Scratch scratch("solve-solutions");
  write(scratch / "a.dat", lcp_file);
  write(scratch / "c.dat", mixed_file);
  REQUIRE(run_perp(scratch, "solve --solutions " + (scratch / "s") + " " + (scratch / "a.dat") + " " +
                                (scratch / "c.dat"))
              .status == 0);
  auto lcp = columns(scratch / "s/a.dat.csv");
  CHECK(std::stod(lcp["z"][0]) == Approx(4.0 / 3).epsilon(1e-14));
  CHECK(std::stod(lcp["z"][1]) == Approx(7.0 / 3).epsilon(1e-14));
  auto mixed = columns(scratch / "s/c.dat.csv");
  CHECK(mixed["variable"] == std::vector<std::string>{"u", "v"});
  CHECK(std::stod(mixed["value"][0]) == Approx(2).epsilon(1e-14));
  CHECK(std::stod(mixed["value"][1]) == 0);
  CHECK(std::stod(mixed["w"][1]) == Approx(1).epsilon(1e-14));
}

TEST_CASE("on a terminal perp solve says which file it is at, elsewhere nothing of it", "[solve]") {
  if (std::system("command -v script >/dev/null") != 0) {
    WARN("skipped: script (bsdutils) is not installed");
    return;
  }
  const Scratch scratch("solve-terminal");
  write(scratch / "a.dat", lcp_file);
  write(scratch / "b.dat", "nonsense");
  const std::string files = (scratch / "a.dat") + " " + (scratch / "b.dat");
  const std::string shown = scratch / "shown";
  REQUIRE(std::system(("script -qec '" PERP_PROGRAM " solve " + files + "' /dev/null >" + shown).c_str()) !=
          -1);
  const std::string text = contents(shown);
  CHECK(text.find("[1/2] " + (scratch / "a.dat") + "\r\033[K" + (scratch / "a.dat") + ": lcp solved") !=
        std::string::npos);
  CHECK(text.find("[2/2] " + (scratch / "b.dat") + "\r\033[Kperp: ") != std::string::npos);
  CHECK(run_perp(scratch, "solve " + files).err.find("[1/2]") == std::string::npos);
}

}  // namespace
}  // namespace perp
