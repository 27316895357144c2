// The examples of doc/problem-files.md, as the page prints them.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "tests/cli/program.hpp"

#ifdef PERP_HAS_HDF5
#include "solve/files/hdf5_handle.hpp"
#endif

namespace perp {
namespace {

/// The page's block that is headed ```NAME.
std::string page_example(const std::string& name) {
  const std::string page = contents(std::filesystem::path(PERP_TEST_FOLDER) / "../../doc/problem-files.md");
  const std::size_t begin = page.find("```" + name + "\n");
  REQUIRE(begin != std::string::npos);
  const std::size_t first = begin + name.size() + 4;
  return page.substr(first, page.find("```", first) - first);
}

std::string write_example(const Scratch& scratch, const std::string& name) {
  std::ofstream(scratch / name) << page_example(name);
  return scratch / name;
}

/// perp solve finds the kind and solves; the solution's columns.
std::map<std::string, std::vector<std::string>> page_solution(const Scratch& scratch, const std::string& file,
                                                              const std::string& kind) {
  const Outcome done = run_perp(scratch, "solve --csv --solutions " + (scratch / "answers") + " " + file);
  CAPTURE(done.out, done.err);
  REQUIRE(done.status == 0);
  REQUIRE(columns(scratch / "stdout")["kind"] == std::vector<std::string>{kind});
  return columns((scratch / "answers") + "/" + std::filesystem::path(file).filename().string() + ".csv");
}

void check_row(std::map<std::string, std::vector<std::string>> table,
               const std::map<std::string, double>& wanted) {
  for (const auto& [name, value] : wanted) {
    CAPTURE(name);
    REQUIRE(table[name].size() == 1);
    CHECK(std::stod(table[name][0]) == Approx(value).margin(1e-12));
  }
}

const std::map<std::string, double> rolling_ball{
    {"rn", 2},  {"rt1", -1.0 / 7}, {"rt2", 0},           {"un", 0},         {"ut1", 0},
    {"ut2", 0}, {"r_rolling1", 0}, {"r_rolling2", -0.2}, {"u_rolling1", 0}, {"u_rolling2", 13.0 / 14}};

#ifdef PERP_HAS_HDF5
/// Lines "/group/.../name int|real numbers" as datasets; with `swap` the triplets' i and p change places.
void write_hdf5(const std::string& listing, const std::string& path, bool swap) {
  const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  const Hdf5Handle with_groups(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(with_groups, 1);
  std::istringstream lines(listing);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, type;
    words >> name >> type;
    if (swap && name.size() > 2 && name[name.size() - 2] == '/' && (name.back() == 'i' || name.back() == 'p'))
      name.back() = name.back() == 'i' ? 'p' : 'i';
    std::vector<double> x;
    for (double value; words >> value;) x.push_back(value);
    const std::vector<int> integers(x.begin(), x.end());
    const hsize_t length = x.size();
    const bool real = type == "real";
    const hid_t kind = real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT;
    const Hdf5Handle space(H5Screate_simple(1, &length, nullptr), H5Sclose);
    const Hdf5Handle set(H5Dcreate2(file, name.c_str(), kind, space, with_groups, H5P_DEFAULT, H5P_DEFAULT),
                         H5Dclose);
    REQUIRE(set.valid());
    const void* from = real ? static_cast<const void*>(x.data()) : integers.data();
    REQUIRE(H5Dwrite(set, kind, H5S_ALL, H5S_ALL, H5P_DEFAULT, from) >= 0);
  }
}

TEST_CASE("the page's FCLIB example is a rolling ball and solves as its text does", "[solve]") {
  const Scratch scratch("page-fclib");
  write_hdf5(page_example("rolling.hdf5"), scratch / "rolling.hdf5", false);
  check_row(page_solution(scratch, scratch / "rolling.hdf5", "friction"), rolling_ball);
  CHECK(contents(scratch / "stderr").empty());
}

TEST_CASE("FCLIB triplets that fit only with p as the row are read so, and it is said", "[solve]") {
  const Scratch scratch("page-fclib-swapped");
  std::string listing =
      page_example("rolling.hdf5");  // the sixth velocity gets an entry, which is no column of H
  const auto change = [&](const std::string& from, const std::string& to) {
    REQUIRE(listing.find(from) != std::string::npos);
    listing.replace(listing.find(from), from.size(), to);
  };
  change("H/nz          int   7", "H/nz          int   8");
  change("2 0 4 1 3 3 4", "2 0 4 1 3 3 4 5");
  change("0 1 1 2 2 3 4", "0 1 1 2 2 3 4 0");
  change("1 1 -1 1 1 1 1", "1 1 -1 1 1 1 1 0");
  write_hdf5(listing, scratch / "usual.hdf5", false);
  write_hdf5(listing, scratch / "swapped.hdf5", true);
  check_row(page_solution(scratch, scratch / "usual.hdf5", "friction"), rolling_ball);
  CHECK(contents(scratch / "stderr").empty());
  check_row(page_solution(scratch, scratch / "swapped.hdf5", "friction"), rolling_ball);
  CHECK(contents(scratch / "stderr").find("p as the row") != std::string::npos);
}
#endif

TEST_CASE("the page's example of rolling solves to what the page says", "[solve]") {
  const Scratch scratch("page-rolling");
  const auto table = page_solution(scratch, write_example(scratch, "rolling.dat"), "friction");
  check_row(table, rolling_ball);
  const std::string said = page_example("rolling.dat.csv");
  CHECK(contents((scratch / "answers") + "/rolling.dat.csv").substr(0, said.find('\n')) ==
        said.substr(0, said.find('\n')));
}

TEST_CASE("the page's examples of torsion, and of torsion with rolling, solve to the closed form",
          "[solve]") {
  const Scratch scratch("page-twist");
  check_row(
      page_solution(scratch, write_example(scratch, "torsion.dat"), "friction"),
      {{"rn", 2}, {"rt1", 0}, {"rt2", 0}, {"un", 0}, {"r_torsion", -0.2}, {"u_torsion", 3 - 0.2 * 1.25}});
  // friction that keeps the ball rolling and torsion share one ellipsoid, at whose surface they are
  auto both = page_solution(scratch, write_example(scratch, "twist.dat"), "friction");
  check_row(both, {{"rn", 2}, {"r_rolling2", -0.2}, {"u_rolling1", 0}});
  CHECK(std::hypot(std::stod(both["rt1"].at(0)) / 0.3, std::stod(both["r_torsion"].at(0)) / 0.1) ==
        Approx(2));
  CHECK(std::stod(both["rt1"].at(0)) < -1e-3);
}

TEST_CASE("an LCP as n, A, b is read row by row and told from others by its content", "[solve]") {
  const Scratch scratch("page-lcp");
  auto table = page_solution(scratch, write_example(scratch, "plain.lcp"), "lcp");
  REQUIRE(table["z"].size() == 2);
  CHECK(std::stod(table["z"][0]) == Approx(1));
  CHECK(std::stod(table["z"][1]) == Approx(1));
}

TEST_CASE("files whose first numbers are those of two kinds are told apart by the rest", "[solve]") {
  const Scratch scratch("kinds-alike");
  // "2 1 2 2": an LCP of two rows in sparse blocks, or one planar contact whose matrix is compressed text
  std::ofstream(scratch / "lcp.dat") << "2 1 2 2 1 1 1 2 2 2 1 0 1 0 0 2 0 0 2 -1 -1\n";
  std::ofstream(scratch / "planar.dat")
      << "2 1\n2\n2 2\n1\nfree text\ntriplet: 2-by-2, nzmax: 2 nnz: 2\n0 0 : 1\n1 1 : 1\n-1 0.1\n0.5\n";
  CHECK(page_solution(scratch, scratch / "lcp.dat", "lcp")["z"].size() == 2);
  check_row(page_solution(scratch, scratch / "planar.dat", "friction"), {{"rn", 1}, {"rt1", -0.1}});
}

}  // namespace
}  // namespace perp
