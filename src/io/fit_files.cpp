#include "perp/io/fit_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/files.hpp"
#include "io/gnuplot.hpp"
#include "io/html.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/chart.hpp"
#include "perp/io/csv_file.hpp"

namespace perp {
namespace {

std::string digits(double x, int n = 5) {
  if (std::isnan(x)) return "-";
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", n, x);
  return text;
}

/// Unit and panel of a column.
std::string unit_of(const std::string& column) {
  const std::string part = column.substr(column.rfind('.') + 1);
  if (part == "x" || part == "y" || part == "z") return "m";
  if (part == "angle") return "rad";
  if (part[0] == 'q' && part.size() == 2 && part[1] >= 'w') return "quaternion";
  if (part == "omega" || (part[0] == 'w' && part.size() == 2)) return "rad/s";
  if (part[0] == 'v' && part.size() == 2 && part[1] >= 'x') return "m/s";
  return "own coordinates";
}

/// A panel for each unit, a colour for each column, what was held back in hollow marks.
std::string script(const FitResult& result) {
  std::vector<std::pair<std::string, std::vector<std::string>>> panels;
  bool held = false;
  for (const FitResult::Noise& noise : result.noise) {
    const std::string unit = unit_of(noise.column);
    const auto found =
        std::find_if(panels.begin(), panels.end(), [&](const auto& p) { return p.first == unit; });
    (found == panels.end() ? panels.emplace_back(unit, std::vector<std::string>{}) : *found)
        .second.push_back(noise.column);
  }
  for (const FitResidual& r : result.residuals) held = held || r.held_back;
  std::string text =
      "# Draws residuals.svg from residuals.csv:  gnuplot residuals.gnuplot\nset terminal svg size 900," +
      std::to_string(60 + 260 * std::max<std::size_t>(1, panels.size())) +
      " dynamic enhanced font \"Helvetica,15\" background \"white\"\nset output \"residuals.svg\"\n"
      "set datafile separator \",\"\nset border 3 linecolor \"#666666\"\nset tics nomirror out\n"
      "set grid ytics linecolor \"#dddddd\"\nset key outside right center samplen 1\nset multiplot layout " +
      std::to_string(std::max<std::size_t>(1, panels.size())) + ",1\n";
  for (const auto& [unit, columns] : panels) {
    text += "set ylabel " + in_gnuplot_quotes("fitted - measured [" + unit + "]") + "\n";
    text += &unit == &panels.back().first ? "set xlabel \"t [s]\"\n" : "unset xlabel\n";
    const char* separator = "plot ";
    for (std::size_t c = 0; c < columns.size(); ++c)
      for (int h = 0; h < (held ? 2 : 1); ++h) {
        text += std::string(separator) + "\"residuals.csv\" every ::1 using (strcol(2) eq \"" + columns[c] +
                "\" && $7 == " + std::to_string(h) + " ? $3 : NaN):6 with points pointtype " +
                (h == 0 ? "7" : "6") + " pointsize 0.4 linecolor \"" + palette(static_cast<int>(c)) + "\" " +
                (h == 0 ? "title " + in_gnuplot_quotes(columns[c]) : std::string("notitle"));
        separator = ", \\\n     ";
      }
    text += "\n";
  }
  return text + "unset multiplot\n";
}

void write_tables(const FitResult& result, const std::filesystem::path& folder) {
  CsvFile fit(folder / "fit.csv", {"name", "value", "low", "high", "identifiable", "note"});
  for (const FittedValue& v : result.values)
    fit.cell(v.name)
        .cell(v.value)
        .cell(v.low)
        .cell(v.high)
        .cell(v.identifiable ? 1 : 0)
        .cell(v.note)
        .end_row();
  fit.finish();
  CsvFile residuals(folder / "residuals.csv",
                    {"motion", "column", "t", "measured", "fitted", "residual", "held_back"});
  for (const FitResidual& r : result.residuals) {
    residuals.cell(r.motion)
        .cell(r.column)
        .cell(r.t)
        .cell(r.measured)
        .cell(r.fitted)
        .cell(r.fitted - r.measured);
    residuals.cell(r.held_back ? 1 : 0).end_row();
  }
  residuals.finish();
  CsvFile prediction(folder / "prediction.csv", {"motion", "body", "what", "rows", "rms", "largest", "end"});
  for (const PredictionError& p : result.prediction)
    prediction.cell(p.motion)
        .cell(p.body)
        .cell(p.what)
        .cell(p.rows)
        .cell(p.rms)
        .cell(p.largest)
        .cell(p.end)
        .end_row();
  prediction.finish();
}

/// Median over the motions of each body's prediction errors.
struct Median {
  std::string body, what;
  double rms = 0, largest = 0, end = 0;
  std::size_t motions = 0;
};

std::vector<Median> medians(const FitResult& result) {
  std::map<std::pair<std::string, std::string>, std::vector<const PredictionError*>> groups;
  for (const PredictionError& p : result.prediction) groups[{p.body, p.what}].push_back(&p);
  std::vector<Median> all;
  for (const auto& [key, errors] : groups) {
    const auto median = [&](double PredictionError::*what) {
      std::vector<double> values;
      for (const PredictionError* p : errors) values.push_back(p->*what);
      std::sort(values.begin(), values.end());
      return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
    };
    all.push_back({key.first, key.second, median(&PredictionError::rms), median(&PredictionError::largest),
                   median(&PredictionError::end), errors.size()});
  }
  return all;
}

std::string page(const FitResult& result, const std::filesystem::path& folder) {
  const bool good = result.status == FitStatus::Converged && result.flat.empty();
  std::string text = std::string("<div class=") + (good ? "good" : "bad") + "><p>The fit " +
                     escaped_html(result.message) + ".</p>";
  for (const std::string& flat : result.flat) text += "<p>" + escaped_html(flat) + ".</p>";
  text += "</div>\n<table>\n<tr><th>quantity</th><th>value</th><th>95 % from</th><th>to</th><th></th></tr>\n";
  for (const FittedValue& v : result.values)
    text += "<tr><td>" + escaped_html(v.name) + "</td><td class=n>" + digits(v.value, 7) +
            "</td><td class=n>" + digits(v.low) + "</td><td class=n>" + digits(v.high) + "</td><td>" +
            escaped_html(v.identifiable ? v.note : "not told by the data") + "</td></tr>\n";
  text += "</table>\n<h2>Residuals</h2>\n" + svg_of(folder / "residuals.svg") +
          "<table>\n<tr><th>column</th><th>standard deviation</th><th>cells</th></tr>\n";
  for (const FitResult::Noise& n : result.noise)
    text += "<tr><td>" + escaped_html(n.column) + "</td><td class=n>" + digits(n.sigma) +
            "</td><td class=n>" + std::to_string(n.cells) + "</td></tr>\n";
  text +=
      "</table>\n<p>Neighbouring residuals are correlated by " + digits(result.correlation, 2) + ".</p>\n";
  if (!result.prediction.empty()) {
    text +=
        "<h2>What was held "
        "back</h2>\n<table>\n<tr><th>motion</th><th>body</th><th></th><th>rows</th><th>rms</th><th>largest</"
        "th>"
        "<th>at the end</th></tr>\n";
    for (const PredictionError& p : result.prediction)
      text += "<tr><td>" + escaped_html(p.motion) + "</td><td>" + escaped_html(p.body) + "</td><td>" +
              escaped_html(p.what) + "</td><td class=n>" + std::to_string(p.rows) + "</td><td class=n>" +
              digits(p.rms, 3) + "</td><td class=n>" + digits(p.largest, 3) + "</td><td class=n>" +
              digits(p.end, 3) + "</td></tr>\n";
    for (const Median& m : medians(result))
      text += "<tr><th>median of " + std::to_string(m.motions) + "</th><td>" + escaped_html(m.body) +
              "</td><td>" + escaped_html(m.what) + "</td><td></td><td class=n>" + digits(m.rms, 3) +
              "</td><td class=n>" + digits(m.largest, 3) + "</td><td class=n>" + digits(m.end, 3) +
              "</td></tr>\n";
    text += "</table>\n";
  }
  text += "<h2>The search</h2>\n<p>" + std::to_string(result.runs) + " runs, " +
          std::to_string(result.failed) + " of which failed and cost a penalty.</p>\n";
  for (const std::string& sentence : result.search) text += "<p>" + escaped_html(sentence) + ".</p>\n";
  return html_page("Fit to measured motions", text);
}

}  // namespace

std::string write_fit(const FitResult& result, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  write_tables(result, folder);
  replace_file(folder / "residuals.gnuplot", script(result));
  std::error_code none_there;
  std::filesystem::remove(folder / "residuals.svg", none_there);
  const std::string no_picture =
      result.residuals.empty() ? "nothing to draw" : run_gnuplot(folder, "residuals.gnuplot");
  if (!no_picture.empty()) std::filesystem::remove(folder / "residuals.svg", none_there);
  replace_file(folder / "fit.html", page(result, folder));
  return no_picture;
}

std::string summary_of(const FitResult& result) {
  std::string text = "the fit " + result.message + "\n";
  char line[200];
  std::snprintf(line, sizeof line, "%-24s %14s %14s %14s\n", "quantity", "value", "95 % from", "to");
  text += line;
  for (const FittedValue& v : result.values) {
    std::snprintf(line, sizeof line, "%-24s %14s %14s %14s  ", v.name.c_str(), digits(v.value, 7).c_str(),
                  digits(v.low).c_str(), digits(v.high).c_str());
    text += line + (v.identifiable ? v.note : std::string("not told by the data")) + "\n";
  }
  for (const std::string& flat : result.flat) text += flat + "\n";
  for (const Median& m : medians(result)) {
    std::snprintf(line, sizeof line,
                  "held back: %s of %s, median of %zu: rms %.3g, largest %.3g, at the end %.3g\n",
                  m.what.c_str(), m.body.c_str(), m.motions, m.rms, m.largest, m.end);
    text += line;
  }
  for (const std::string& sentence : result.search) text += "search: " + sentence + "\n";
  return text + std::to_string(result.runs) + " runs, " + std::to_string(result.failed) + " failed\n";
}

}  // namespace perp
