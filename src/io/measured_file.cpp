#include "perp/io/measured_file.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

#include "perp/core/errors.hpp"
#include "perp/io/csv_reader.hpp"

namespace perp {
namespace {

/// The column of .qw whose .qx, .qy, .qz follow somewhere; -1 where they do not.
std::vector<std::array<int, 4>> quaternions(const CsvReader& file) {
  std::vector<std::array<int, 4>> all;
  for (const std::string& name : file.header()) {
    if (!name.ends_with(".qw")) continue;
    const std::string stem = name.substr(0, name.size() - 1);
    const std::array<int, 4> four{file.find(name), file.find(stem + "x"), file.find(stem + "y"),
                                  file.find(stem + "z")};
    if (four[1] >= 0 && four[2] >= 0 && four[3] >= 0) all.push_back(four);
  }
  return all;
}

}  // namespace

MeasuredMotion read_measured(const std::filesystem::path& path) {
  CsvReader file(path);
  const std::string name = path.string();
  const auto columns = static_cast<int>(file.header().size());
  if (file.header()[0] != "t")
    throw std::invalid_argument(name + ":1:1: the first column is '" + file.header()[0] +
                                "', needs to be t [s]");
  if (columns < 2) throw std::invalid_argument(name + ":1:1: t alone, needs a column of something measured");
  MeasuredMotion motion{.name = path.stem().string(),
                        .columns = {file.header().begin() + 1, file.header().end()}};
  const std::vector<std::array<int, 4>> rotations = quaternions(file);
  std::vector<double> values;
  bool measured = false;
  while (file.next()) {
    const double t = file.number(0);
    if (!std::isfinite(t)) file.refuse_cell(0, "a finite time is needed");
    if (!motion.t.empty() && !(t > motion.t.back()))
      file.refuse_cell(0, "a time after " + shortest(motion.t.back()) + " is needed");
    motion.t.push_back(t);
    for (int c = 1; c < columns; ++c) {
      const double value = file.number(c);
      if (!file.text(c).empty() && !std::isfinite(value)) file.refuse_cell(c, "a finite number is needed");
      measured = measured || !std::isnan(value);
      values.push_back(value);
    }
    const double* row = values.data() + values.size() - (columns - 1);
    for (const std::array<int, 4>& four : rotations) {
      double square = 0;
      for (const int c : four) square += row[c - 1] * row[c - 1];
      constexpr double off = 0.1;  // noise of a per cent or a few; anything more is no rotation
      if (std::abs(std::sqrt(square) - 1) > off)
        file.refuse_cell(four[0],
                         "needs to be of a quaternion of length 1, which is " + shortest(std::sqrt(square)));
    }
  }
  if (motion.t.empty()) throw std::invalid_argument(name + ":2:1: no row, one is needed");
  if (!measured) throw std::invalid_argument(name + ":2:2: only empty cells, needs something measured");
  motion.values = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), static_cast<Eigen::Index>(motion.t.size()), columns - 1);
  return motion;
}

}  // namespace perp
