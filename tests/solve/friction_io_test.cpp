#include "perp/solve/friction_io.hpp"

#include <catch2/catch.hpp>
#include <cstdio>
#include <Eigen/Dense>
#include <filesystem>
#include <fstream>

#include "friction_examples.hpp"

using namespace perp;
using Catch::Matchers::Contains;

namespace {

std::string scratch(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("perp-" + name)).string();
}

void check_same(const FrictionProblem& a, const FrictionProblem& b) {
  CHECK(a.is_global() == b.is_global());
  CHECK(a.W.to_dense() == b.W.to_dense());
  CHECK(a.M.to_dense() == b.M.to_dense());
  CHECK(a.H.to_dense() == b.H.to_dense());
  CHECK(a.q == b.q);
  CHECK(a.f == b.f);
  CHECK(a.w == b.w);
  CHECK(a.mu == b.mu);
}

FrictionProblem from_text(const std::string& text) {
  return read_friction_text(TextReader(text, "made.dat"));
}

}  // namespace

TEST_CASE("a problem written as text reads back to the same bits", "[friction][io]") {
  const std::string path = scratch("text.dat");
  const FrictionProblem local = random_friction_problem(8), global = cube_on_plane({1, 2, -10}, 0.3);
  write_friction_text(local, path);
  check_same(local, read_friction_problem(path));
  write_friction_text(global, path);
  check_same(global, read_friction_problem(path));
  std::remove(path.c_str());
}

TEST_CASE("a problem written as FCLIB reads back to the same bits", "[friction][io]") {
  if (!has_hdf5()) return;
  const std::string path = scratch("fclib.hdf5");
  const FrictionProblem local = random_friction_problem(8), global = cube_on_plane({1, 2, -10}, 0.3);
  write_fclib(local, path);
  CHECK(is_hdf5_file(path));
  check_same(local, read_friction_problem(path));
  write_fclib(global, path);
  check_same(global, read_friction_problem(path));
  std::remove(path.c_str());
}

TEST_CASE("a problem with moments reads back to the same bits from either format", "[friction][io]") {
  for (const int rows : {3, 4, 5, 6})
    for (const bool fclib : {false, true}) {
      if (fclib && !has_hdf5()) continue;
      const std::string path = scratch(fclib ? "moments.hdf5" : "moments.dat");
      Draw draw(static_cast<unsigned>(rows));
      FrictionProblem problem;
      problem.W = draw.matrix(2 * rows, 2 * rows);
      problem.q = draw.matrix(2 * rows, 1);
      problem.mu = Eigen::Vector2d(0.3, 0.4);
      problem.mu_o = Eigen::Vector2d(0.1, 0.2);
      if (rows == 4 || rows == 6) problem.torsion = Eigen::Vector2d(0.01, 0.02);
      if (rows >= 5) problem.rolling = Eigen::Vector2d(0.03, 0);
      fclib ? write_fclib(problem, path) : write_friction_text(problem, path);
      const FrictionProblem back = read_friction_problem(path);
      check_same(problem, back);
      CAPTURE(rows, fclib);
      CHECK(back.kind(0) == problem.kind(0));
      CHECK(back.mu_o == problem.mu_o);
      CHECK(back.torsion == problem.torsion);
      CHECK(back.rolling == problem.rolling);
      std::remove(path.c_str());
    }
}

TEST_CASE("planar contacts that roll have a place in FCLIB's layout alone", "[friction][io]") {
  const std::string path = scratch("wheel.hdf5");
  FrictionProblem wheel;
  wheel.W = Matrix::Identity(3, 3);
  wheel.q = Vector3(-1, 0.2, 3);
  wheel.mu = wheel.rolling = Vector::Constant(1, 0.5);
  wheel.kinds = {BlockKind::PlanarRolling};
  CHECK_THROWS_WITH(write_friction_text(wheel, scratch("never.dat")), Contains("rolling"));
  if (!has_hdf5()) return;
  write_fclib(wheel, path);
  const FrictionProblem back = read_friction_problem(path);
  CHECK(back.kind(0) == BlockKind::PlanarRolling);
  CHECK(back.rolling == wheel.rolling);
  std::remove(path.c_str());
}

TEST_CASE("a planar problem in dense storage is read column by column", "[friction][io]") {
  const FrictionProblem p = from_text("2 1\n0\n2 2\n2 2\n1 2\n3 4\n-1 0.5\n0.3\nwords that follow");
  CHECK(p.kind(0) == BlockKind::Planar);
  CHECK(p.W.to_dense()(1, 0) == 2);
  CHECK(p.W.to_dense()(0, 1) == 3);
  CHECK(p.q(0) == -1);
  CHECK(p.mu(0) == 0.3);
}

TEST_CASE("what is wrong in a file is told with its place", "[friction][io]") {
  CHECK_THROWS_WITH(from_text("7 1\n"), Contains("made.dat:1:1"));
  CHECK_THROWS_WITH(from_text("3 1\n0\n2 2\n2 2\n1 0\n0 1\n0 0\n1\n"),
                    Contains("made.dat:") && Contains("3 rows"));
  CHECK_THROWS_WITH(from_text("2 1\n0\n2 2\n2 2\n1 0\n0 1\n0 0\n-1\n"),
                    Contains("made.dat:8:1") && Contains("mu of contact 0"));
  CHECK_THROWS_WITH(from_text("2 1\n0\n2 2\n2 2\n1 0\n0 1\n0\n"), Contains("made.dat:"));
  CHECK_THROWS_WITH(from_text("4 1\n0 4 4 4 4\n1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n0 0 0 1\n0.5 -2\n"),
                    Contains("made.dat:5:5") && Contains("torsion of contact 0"));
  CHECK_THROWS_WITH(from_text("4 1\n0 4 4 4 4\n1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n0 0 0 1\n0.5\n"),
                    Contains("torsion of contact 0") && Contains("missing at the end"));
}

TEST_CASE("a damaged FCLIB file is told by name", "[friction][io]") {
  if (!has_hdf5()) return;
  const std::string path = scratch("damaged.hdf5");
  std::ofstream(path, std::ios::binary) << "\x89HDF\r\n\x1a\n and nothing more";
  CHECK_THROWS_WITH(read_friction_problem(path), Contains("damaged.hdf5"));
  std::remove(path.c_str());
}

TEST_CASE("kinds that a format has no place for are refused", "[friction][io]") {
  FrictionProblem problem;
  problem.W = Matrix::Identity(1, 1);
  problem.q = Vector::Zero(1);
  problem.mu = Vector::Zero(1);
  problem.kinds = {BlockKind::Interval};
  CHECK_THROWS_WITH(write_friction_text(problem, scratch("never.dat")), Contains("kinds"));
}
