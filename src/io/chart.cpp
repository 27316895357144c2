#include "perp/io/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "core/files.hpp"
#include "io/gnuplot.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/csv_file.hpp"

namespace perp {
namespace {

constexpr std::array colours{"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222"};
constexpr std::array marks{7, 5, 9, 13, 11, 6, 4, 8, 12, 10};  // gnuplot's point types, the filled ones first

bool drawable(double x) { return x > 0 && std::isfinite(x); }

/// Decades from a little below the least to a little above the largest value.
struct Range {
  double low = infinity, high = 0;

  void add(double x) {
    if (!drawable(x)) return;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  bool empty() const { return !(low <= high); }
  /// Room around what was added, and two powers of ten at least, which are the ticks that have numbers.
  void widen(double below, double above) {
    if (empty()) low = high = 1;
    low /= below;
    high *= above;
    const double first = std::ceil(std::log10(low)), last = std::floor(std::log10(high));
    if (last > first) return;
    low = std::min(low, std::pow(10, last == first ? first : last));
    high = std::max(high, std::pow(10, last == first ? first + 1 : first));
  }
  std::string text() const { return "[" + shortest(low) + ":" + shortest(high) + "]"; }
};

void write_data(const Chart& chart, const std::filesystem::path& path) {
  std::vector<std::string> header;
  std::size_t rows = 0;
  for (const ChartLine& line : chart.lines) {
    const std::string label = line.label.empty() ? "" : line.label + ": ";
    header.push_back(label + chart.x_label);
    header.push_back(label + chart.y_label);
    rows = std::max(rows, line.x.size());
  }
  CsvFile csv(path, header);
  for (std::size_t i = 0; i < rows; ++i) {
    for (const ChartLine& line : chart.lines) {
      const bool there = i < line.x.size() && drawable(line.x[i]) && drawable(line.y[i]);
      csv.cell(there ? line.x[i] : not_set).cell(there ? line.y[i] : not_set);
    }
    csv.end_row();
  }
  csv.finish();
}

/// y of a line at x, between its points in logarithms; NaN outside of them.
double height(const ChartLine& line, double x) {
  std::vector<std::array<double, 2>> points;
  for (std::size_t i = 0; i < line.x.size(); ++i)
    if (drawable(line.x[i]) && drawable(line.y[i]))
      points.push_back({std::log(line.x[i]), std::log(line.y[i])});
  std::sort(points.begin(), points.end());
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto [x0, y0] = points[i - 1];
    const auto [x1, y1] = points[i];
    if (x1 > x0 && std::log(x) >= x0 && std::log(x) <= x1)
      return std::exp(y0 + (y1 - y0) * (std::log(x) - x0) / (x1 - x0));
  }
  return not_set;
}

/// A right triangle of order p under the middle of a line: its base a factor of 4 in x.
std::array<std::array<double, 2>, 3> triangle(const ChartLine& line, double order) {
  Range x;
  for (std::size_t i = 0; i < line.x.size(); ++i)
    if (drawable(line.y[i])) x.add(line.x[i]);
  const double middle = std::sqrt(x.low * x.high), base = std::min(4.0, std::sqrt(x.high / x.low));
  const double left = middle / std::sqrt(base), right = middle * std::sqrt(base);
  const double bottom = 0.4 * std::min(height(line, left), height(line, right) / std::pow(base, order));
  return {{{left, bottom}, {right, bottom}, {right, bottom * std::pow(base, order)}}};
}

std::string script(const Chart& chart, const std::string& name) {
  Range x, y;
  for (const ChartLine& line : chart.lines) {
    for (std::size_t i = 0; i < line.x.size(); ++i)
      if (drawable(line.x[i]) && drawable(line.y[i])) x.add(line.x[i]), y.add(line.y[i]);
    for (const double at : line.missing) x.add(at);
  }
  for (const ChartFloor& floor : chart.floors) y.add(floor.y);

  std::ostringstream out;
  out.imbue(std::locale::classic());
  int objects = 0;
  std::ostringstream shapes;
  shapes.imbue(std::locale::classic());
  for (const ChartSlope& slope : chart.slopes) {
    const auto corners = triangle(chart.lines.at(slope.line), slope.order);
    if (!drawable(corners[0][1])) continue;
    y.add(corners[0][1]);
    ++objects;
    shapes << "set object " << objects << " polygon";
    for (const std::size_t corner : {0U, 1U, 2U, 0U})
      shapes << (corner == 0 && shapes.str().back() == 'n' ? " from " : " to ")
             << shortest(corners[corner][0]) << "," << shortest(corners[corner][1]);
    shapes << " fillstyle solid 0.25 border linecolor \"#888888\" fillcolor \"#bbbbbb\" back\n";
    shapes << "set label " << objects << " \"" << shortest(slope.order) << "\" at "
           << shortest(corners[1][0] * 1.06) << "," << shortest(std::sqrt(corners[1][1] * corners[2][1]))
           << " left textcolor \"#666666\" font \",14\"\n";
  }
  x.widen(1.4, 1.4);
  y.widen(2, 2.5);

  out << "# Draws " << name << ".svg from " << name << ".csv:  gnuplot " << name << ".gnuplot\n"
      << "set terminal svg size 900,560 dynamic enhanced font \"Helvetica,16\" background \"white\"\n"
      << "set output \"" << name << ".svg\"\n"
      << "set datafile separator \",\"\n"
      << "set logscale xy\n"
      << "set format xy \"10^{%T}\"\n"
      << "set border 3 linecolor \"#666666\"\n"
      << "set tics nomirror out textcolor \"#333333\"\n"
      << "set mxtics 10\nset mytics 10\n"
      << "set grid xtics ytics linecolor \"#dddddd\" linetype 1 linewidth 0.7\n"
      << "set key outside right center spacing 1.3 samplen 2.5 Left reverse textcolor \"#333333\"\n"
      << "set title " << in_gnuplot_quotes(chart.title) << "\n"
      << "set xlabel " << in_gnuplot_quotes(chart.x_label) << "\n"
      << "set ylabel " << in_gnuplot_quotes(chart.y_label) << "\n"
      << "set xrange " << x.text() << "\nset yrange " << y.text() << "\n"
      << shapes.str();
  int label = objects;
  for (const ChartFloor& floor : chart.floors) {
    char value[32];
    std::snprintf(value, sizeof value, "%.2g", floor.y);
    const std::string at = shortest(floor.y);
    ++label;
    out << "set arrow from graph 0, first " << at << " to graph 1, first " << at << " nohead linecolor \""
        << palette(floor.colour) << "\" linewidth 1.2 dashtype 3 back\n"
        << "set label " << label << " " << quoted(floor.what + (floor.what.empty() ? "" : " ") + value)
        << " at graph 0.01, first " << at << " left offset 0,0.5 textcolor \"" << palette(floor.colour)
        << "\" font \",13\"\n";
  }
  for (const ChartLine& line : chart.lines)
    for (const double at : line.missing) {
      if (!drawable(at)) continue;
      ++label;
      out << "set label " << label << " \"\" at first " << shortest(at)
          << ", graph 0.97 point pointtype 2 pointsize 1.1 linewidth 2.5 linecolor \"" << palette(line.colour)
          << "\"\n";
    }

  const char* separator = "plot ";
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    const ChartLine& line = chart.lines[i];
    // the first lines are the widest, so that those that others cover are seen behind them
    const double wider = 1 - double(i + 1) / double(chart.lines.size());
    out << separator;
    if (line.x.empty())
      out << "keyentry";
    else
      out << "\"" << name << ".csv\" using " << 2 * i + 1 << ":" << 2 * i + 2;
    if (line.dashed)
      out << " with lines linewidth 1.4 dashtype 2";
    else
      out << " with linespoints linewidth " << 2 + 2 * wider << " pointsize " << 0.75 + 0.5 * wider
          << " pointtype " << marks[static_cast<std::size_t>(line.colour) % marks.size()];
    out << " linecolor \"" << palette(line.colour) << "\"";
    line.label.empty() ? out << " notitle" : out << " title " << in_gnuplot_quotes(line.label);
    separator = ", \\\n     ";
  }
  if (std::all_of(chart.lines.begin(), chart.lines.end(), [](const ChartLine& l) { return l.x.empty(); }))
    out << separator << "1/0 notitle";  // gnuplot draws no key alone
  out << "\n";
  return out.str();
}

}  // namespace

std::string palette(int colour) { return colours[static_cast<std::size_t>(colour) % colours.size()]; }

std::string write_chart(const Chart& chart, const std::filesystem::path& folder, const std::string& name) {
  const bool plain =
      !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
               c == '_' || c == '.';
      });
  if (!plain) refuse("write_chart", "name", name, "needs letters, digits, '-', '_' and '.' alone");
  for (const ChartLine& line : chart.lines)
    if (line.x.size() != line.y.size()) refuse("write_chart", "line", line.label, "needs as many x as y");
  write_data(chart, folder / (name + ".csv"));
  const std::filesystem::path script_path = folder / (name + ".gnuplot"), picture = folder / (name + ".svg");
  replace_file(script_path, script(chart, name));
  std::error_code none_there;
  std::filesystem::remove(picture, none_there);
  const std::string failed = run_gnuplot(folder, name + ".gnuplot");
  if (!failed.empty()) std::filesystem::remove(picture, none_there);
  return failed;
}

}  // namespace perp
