#include <catch2/catch.hpp>
#include <Eigen/Dense>
#include <filesystem>
#include <fstream>

#include "perp/solve/friction_io.hpp"
#include "perp/solve/friction_residual.hpp"
#include "tests/cli/program.hpp"

namespace perp {
namespace {

TEST_CASE("what perp generate writes perp solve solves, and its solutions pass when looked at again",
          "[solve]") {
  const std::string format = GENERATE("text", "fclib");
  if (format == "fclib" && !has_hdf5()) return;
  const Scratch scratch("generate-" + format);
  const std::string problems = scratch / "problems", answers = scratch / "answers";
  REQUIRE(run_perp(scratch, "generate box4 --seed 3 --count 4 --out " + problems + " --format " + format)
              .status == 0);
  const Outcome solved = run_perp(scratch, "solve --csv --solutions " + answers + " " + problems + "/*");
  CHECK(solved.status == 0);
  auto table = columns(scratch / "stdout");
  CHECK(table["kind"] == std::vector<std::string>(4, "friction"));
  CHECK(table["contacts"] == std::vector<std::string>(4, "4"));
  CHECK(table["status"] == std::vector<std::string>(4, "solved"));
  int files = 0;
  for (const auto& file : std::filesystem::directory_iterator(problems)) {
    ++files;
    const FrictionProblem problem = read_friction_problem(file.path().string());
    auto rows = columns(answers + "/" + file.path().filename().string() + ".csv");
    Vector r(12);
    for (int i = 0; i < 4; ++i)
      r.segment<3>(3 * i) << std::stod(rows["rn"][i]), std::stod(rows["rt1"][i]), std::stod(rows["rt2"][i]);
    const FrictionResidual residual = friction_residual(problem, r);
    CHECK(residual.relative <= 1e-10);
    CHECK(residual.absolute <= 1e-8);
  }
  CHECK(files == 4);
}

TEST_CASE("perp generate writes the same bytes twice and others from another seed", "[generate]") {
  const Scratch scratch("generate-bytes");
  for (const char* folder : {"a", "b"})
    REQUIRE(run_perp(scratch, "generate wedge --seed 5 --count 1 --out " + (scratch / folder)).status == 0);
  REQUIRE(run_perp(scratch, "generate wedge --seed 6 --count 1 --out " + (scratch / "c")).status == 0);
  const std::string a = contents((scratch / "a") + "/wedge-5-000.dat");
  CHECK_FALSE(a.empty());
  CHECK(a == contents((scratch / "b") + "/wedge-5-000.dat"));
  CHECK_FALSE(a == contents((scratch / "c") + "/wedge-6-000.dat"));
}

TEST_CASE("perp solve tells a contact problem's bad number with its place and solves the others", "[solve]") {
  const Scratch scratch("friction-bad");
  std::ofstream(scratch / "bad.dat") << "3 1\n0\n3 3\n3 3\n1 0 0\n0 1 0\n0 0 1\n-1 0 x\n0.5\n";
  std::ofstream(scratch / "good.dat") << "3 1\n0\n3 3\n3 3\n1 0 0\n0 1 0\n0 0 1\n-1 0 0\n0.5\n";
  const Outcome done =
      run_perp(scratch, "solve --csv " + (scratch / "bad.dat") + " " + (scratch / "good.dat"));
  CHECK(done.status == 2);
  CHECK(done.err.find("bad.dat:8:6") != std::string::npos);
  CHECK(columns(scratch / "stdout")["status"] == std::vector<std::string>{"bad-file", "solved"});
}

TEST_CASE("perp solve tells an FCLIB file that is cut short or not one and solves the others", "[solve]") {
  if (!has_hdf5()) return;
  const Scratch scratch("fclib-bad");
  REQUIRE(
      run_perp(scratch, "generate box4 --seed 3 --count 2 --format fclib --out " + (scratch / "p")).status ==
      0);
  const std::string first = (scratch / "p") + "/box4-3-000.hdf5",
                    other = (scratch / "p") + "/box4-3-001.hdf5";
  std::filesystem::resize_file(first, std::filesystem::file_size(first) / 2);
  const Outcome done = run_perp(scratch, "solve --csv " + first + " " + other);
  CHECK(done.status == 2);
  CHECK(done.err.find(first + ":") != std::string::npos);
  CHECK(columns(scratch / "stdout")["status"] == std::vector<std::string>{"bad-file", "solved"});
}

TEST_CASE("an infeasible peg ends as no-solution and with status 1", "[solve]") {
  const Scratch scratch("friction-peg");
  REQUIRE(run_perp(scratch, "generate infeasible-peg --seed 1 --count 1 --out " + (scratch / "p")).status ==
          0);
  for (const std::string tolerance : {"", "--tolerance 1e-4 "}) {  // whatever passes a loose one
    CAPTURE(tolerance);
    const Outcome done = run_perp(scratch, "solve --csv " + tolerance + (scratch / "p") + "/*");
    CHECK(done.status == 1);
    auto table = columns(scratch / "stdout");
    CHECK(table["status"] == std::vector<std::string>{"no-solution"});
    CHECK(table["existence"] == std::vector<std::string>{"none"});
  }
}

}  // namespace
}  // namespace perp
