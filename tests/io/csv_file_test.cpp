#include "perp/io/csv_file.hpp"

#include <catch2/catch.hpp>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <locale>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace perp {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A folder of the test's own, gone with it.
struct Scratch {
  fs::path path;
  explicit Scratch(const char* name) : path(fs::temp_directory_path() / (std::string("perp-") + name)) {
    fs::remove_all(path);
  }
  ~Scratch() { fs::remove_all(path); }
};

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST_CASE("a CSV file has its header, commas between cells and quotes where they are needed", "[csv]") {
  const Scratch folder("csv-cells");
  CsvFile file(folder.path / "deep" / "table.csv", {"a", "b", "c"});
  file.cell(1).cell(0.1).cell("plain").end_row();
  file.cell(-2).cell(std::nan("")).cell("a \"quoted\", text").end_row();
  file.finish();
  CHECK(contents(folder.path / "deep" / "table.csv") ==
        "a,b,c\n1,0.1,plain\n-2,,\"a \"\"quoted\"\", text\"\n");
}

TEST_CASE("numbers in a CSV file read back to the same double under any locale", "[csv]") {
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const Scratch folder("csv-numbers");
  std::mt19937_64 random(7);
  std::vector<double> values = {0.1, -0.0, 1e-300, 5e-324, std::numeric_limits<double>::max()};
  std::uniform_real_distribution<double> mantissa(-1, 1), exponent(-300, 300);
  for (int i = 0; i < 1000; ++i) values.push_back(mantissa(random) * std::pow(10, exponent(random)));
  CsvFile file(folder.path / "t.csv", {"x"});
  for (const double value : values) {
    file.cell(value);
    file.end_row();
  }
  file.finish();
  std::locale::global(old);

  std::ifstream in(folder.path / "t.csv");
  std::string line;
  std::getline(in, line);
  for (const double value : values) {
    REQUIRE(std::getline(in, line));
    double back = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), back);
    CHECK(end == line.data() + line.size());
    CHECK(std::signbit(back) == std::signbit(value));
    CHECK(back == value);
  }
}

TEST_CASE("a CSV file that is not finished leaves nothing, neither itself nor its parts", "[csv]") {
  const Scratch folder("csv-half");
  {
    CsvFile file(folder.path / "t.csv", {"x"});
    for (int i = 0; i < 100000; ++i) file.cell(i).end_row();
    CHECK_FALSE(fs::exists(folder.path / "t.csv"));
    CHECK(fs::exists(folder.path / "t.csv.part"));
  }
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE("a CSV file where none can be is refused by name", "[csv]") {
  CHECK_THROWS_WITH(CsvFile("/dev/null/t.csv", {"x"}), Catch::Contains("/dev/null/t.csv"));
  CHECK_THROWS_AS(CsvFile("/dev/null/t.csv", {"x"}), std::invalid_argument);
}

}  // namespace
}  // namespace perp
