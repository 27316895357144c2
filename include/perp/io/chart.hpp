// Charts on logarithmic axes, drawn by gnuplot: the data and the script stay beside the picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "perp/core/types.hpp"

namespace perp {

struct ChartLine {
  std::string label;         ///< in the key; empty: not there
  std::vector<double> x, y;  ///< points that are not positive and finite are left out; none: in the key only
  bool dashed = false;       ///< thin, without marks: beside the line of the same colour
  int colour = 0;            ///< number in the palette, from 0; also the shape of its marks
  std::vector<double> missing = {};  ///< x of points that have no y: crosses at the top
};

/// A triangle under a line: how steep order p is.
struct ChartSlope {
  std::size_t line = 0;
  double order = 1;
};

/// A dotted horizontal line with its value: below it a line cannot come.
struct ChartFloor {
  double y = 0;
  int colour = 0;
  std::string what = {};  ///< words before the value
};

struct Chart {
  std::string title, x_label, y_label;
  std::vector<ChartLine> lines;
  std::vector<ChartSlope> slopes = {};
  std::vector<ChartFloor> floors = {};
};

/// Colours that the colour-blind tell apart too (Okabe and Ito), as #rrggbb; after the last the first again.
[[nodiscard]] std::string palette(int colour);

/// Writes into `folder` (which it makes) NAME.csv, two columns a line; NAME.gnuplot, which draws it ("gnuplot NAME.gnuplot"
/// there); and, by running it, NAME.svg. Returns why there is no picture ("gnuplot is not installed", ...), or an empty text.
/// An older picture of that name is then gone. Throws std::invalid_argument for a name that is not of letters, digits, '-',
/// '_', '.', or files that cannot be made.
[[nodiscard]] std::string write_chart(const Chart& chart, const std::filesystem::path& folder,
                                      const std::string& name);

}  // namespace perp
