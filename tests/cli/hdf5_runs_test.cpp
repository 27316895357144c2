// perp run --format hdf5: the same tables, columns and numbers as CSV has, and the same way to go on.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/cli/program.hpp"

#ifdef PERP_HAS_HDF5
#include "solve/files/hdf5_handle.hpp"

namespace perp {
namespace {

hsize_t length(hid_t set) {
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  return static_cast<hsize_t>(H5Sget_simple_extent_npoints(space));
}

/// Every column of every CSV file in `csv` stands in `file`, to the last bit.
void check_same_tables(const std::string& csv, const std::string& file) {
  const Hdf5Handle h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  REQUIRE(h5.valid());
  for (const std::string table : {"trajectory", "contacts", "joints", "report"})
    for (const auto& [name, cells] : columns(csv + "/" + table + ".csv")) {
      CAPTURE(table, name);
      const Hdf5Handle set(H5Dopen2(h5, (table + "/" + name).c_str(), H5P_DEFAULT), H5Dclose);
      REQUIRE(set.valid());
      REQUIRE(length(set) == cells.size());
      const Hdf5Handle type(H5Dget_type(set), H5Tclose);
      if (cells.empty()) continue;
      if (H5Tget_class(type) == H5T_STRING) {
        std::vector<char*> texts(cells.size());
        REQUIRE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()) >= 0);
        for (std::size_t i = 0; i < cells.size(); ++i) REQUIRE(texts[i] == cells[i]);
      } else {
        std::vector<double> numbers(cells.size());
        REQUIRE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) >= 0);
        for (std::size_t i = 0; i < cells.size(); ++i) {
          if (cells[i].empty())
            REQUIRE(std::isnan(numbers[i]));
          else
            REQUIRE(numbers[i] == std::stod(cells[i]));
        }
      }
    }
}

TEST_CASE("an HDF5 file holds the tables of CSV, and a run that was stopped goes on to the same numbers",
          "[hdf5]") {
  const Scratch scratch("run-hdf5");
  const std::string run = "run friction-pendulum --method ncp2 --step 2e-5 --until 0.4 --out ";
  REQUIRE(run_perp(scratch, run + (scratch / "csv")).status == 0);
  const Outcome whole = run_perp(scratch, run + (scratch / "whole") + " --format hdf5");
  CAPTURE(whole.err);
  REQUIRE(whole.status == 0);
  CHECK_FALSE(std::filesystem::exists(scratch / "whole/trajectory.csv"));
  check_same_tables(scratch / "csv", scratch / "whole/run.h5");
  Outcome piece = run_perp(scratch, run + (scratch / "cut") + " --format hdf5 --budget 0.3");
  int pieces = 1;
  for (; piece.status == 1 && pieces < 100; ++pieces)
    piece = run_perp(scratch, "run --resume " + (scratch / "cut") + " --budget 0.8");
  CAPTURE(piece.err);
  CHECK(pieces > 1);
  CHECK(piece.status == 0);
  check_same_tables(scratch / "csv", scratch / "cut/run.h5");
}

}  // namespace
}  // namespace perp

#endif
