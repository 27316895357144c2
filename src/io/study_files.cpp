#include "perp/io/study_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "perp/io/csv_file.hpp"
#include "perp/study/work_precision.hpp"

namespace perp {
namespace {

/// The word of study.csv: what error_q and error_v are counted from.
std::string_view reference_of(const ConvergenceTable& table) {
  return table.reference == OrderReference::Limit ? "own-limit" : name_of(table.reference);
}

/// What the axis of errors says: of which reference, where it is not the exact motion.
std::string error_label(const ConvergenceTable& table) {
  const std::string label = "error in configuration at T [m, rad]";
  switch (table.reference) {
    case OrderReference::Exact:
      return label;
    case OrderReference::Limit:
      return "distance from each method's own limit at T [m, rad]";
    case OrderReference::None:
      return "no reference: distance from own limits at T [m, rad]";
    default:
      return label + ", from " + std::string(name_of(table.reference));
  }
}

/// The floor under all points of a computed reference.
void add_bar(const ConvergenceTable& table, Chart& chart) {
  if (table.bar_q > 0) chart.floors.push_back({table.bar_q, 6, "reference's bar"});
}

/// What the key says of a line without points.
std::string why_empty(const ConvergenceTable& table, const std::string& method,
                      const std::string& parameter) {
  bool failed = true, barred = false;
  for (const StudyRun& run : table.runs) {
    if (run.method != method || run.parameter != parameter) continue;
    failed = failed && run.failed;
    barred = barred || run.error_q <= table.bar_q;
  }
  return failed                                     ? ": all runs failed"
         : barred && table.bar_q > 0                ? ": within the bar"
         : barred                                   ? ": no error"
         : table.reference == OrderReference::Exact ? ": no error known"
                                                    : ": no reference";
}

}  // namespace

void write_study_csv(const std::filesystem::path& path, const std::vector<ConvergenceTable>& tables) {
  CsvFile csv(path, {"scene", "method", "parameter", "h", "rtol", "error_q", "error_v", "seconds", "steps",
                     "iterations", "failed", "error_limit", "message", "reference", "bar_q", "bar_v",
                     "error_path", "error_p"});
  for (const ConvergenceTable& table : tables)
    for (const StudyRun& run : table.runs) {
      csv.cell(table.scene).cell(run.method).cell(run.parameter).cell(run.h).cell(run.rtol);
      csv.cell(above_bar(run.error_q, table.bar_q)).cell(above_bar(run.error_v, table.bar_v));
      csv.cell(run.seconds).cell(run.steps).cell(run.iterations);
      csv.cell(run.failed).cell(run.error_limit).cell(run.message);
      csv.cell(reference_of(table)).cell(table.bar_q).cell(table.bar_v);
      csv.cell(above_bar(run.error_path, table.bar_q)).cell(run.error_p).end_row();
    }
  csv.finish();
}

void write_orders_csv(const std::filesystem::path& path, const std::vector<ConvergenceTable>& tables) {
  CsvFile csv(path, {"scene", "method", "parameter", "reference", "order", "order_v", "points", "expected",
                     "failed", "note", "bar", "h_least", "h_most", "slopes", "why", "order_path", "order_p"});
  for (const ConvergenceTable& table : tables)
    for (const OrderRow& row : table.orders) {
      csv.cell(table.scene).cell(row.method).cell(row.parameter).cell(name_of(row.reference));
      csv.cell(row.q.order).cell(row.v.order).cell(row.q.points).cell(row.expected);
      csv.cell(row.failed).cell(note_of(row));
      csv.cell(row.reference == OrderReference::Limit ? not_set : table.bar_q);
      csv.cell(row.q.h_least).cell(row.q.h_most).cell(local_slopes(row.q)).cell(row.why);
      csv.cell(row.path.order).cell(row.p.order).end_row();
    }
  csv.finish();
}

std::string local_slopes(const ObservedOrder& order) {
  std::string text;
  for (const double slope : order.local) {
    char number[32];
    std::snprintf(number, sizeof number, "%.2f", slope);
    text += (text.empty() ? "" : " ") + std::string(number);
  }
  return text;
}

std::string note_of(const OrderRow& row) {
  if (row.v.note.empty()) return row.q.note;
  return row.q.note + (row.q.note.empty() ? "" : "; ") + "velocity: " + row.v.note;
}

void ConvergenceTable::write_csv(const std::filesystem::path& path) const { write_study_csv(path, {*this}); }

Chart convergence_chart(const ConvergenceTable& table) {
  Chart chart{.title = table.scene + ": error against step",
              .x_label = "step h [s]",
              .y_label = error_label(table),
              .lines = {}};
  struct Level {
    double h = 0, q = 0, limit = 0;
    bool failed = false;
  };
  std::vector<double> drawn;  // orders that have a triangle
  int colour = -1;
  std::string last;
  for (const OrderRow& row : table.orders) {
    std::map<int, Level> levels;
    for (const StudyRun& run : table.runs) {
      if (run.method != row.method || run.parameter != row.parameter || std::isnan(run.h)) continue;
      Level& level = levels[run.level];
      level.h = std::max(level.h, run.h);
      level.failed = level.failed || run.failed;
      level.q = std::max(level.q, run.error_q);  // a bar is taken off below: of the largest
      level.limit = std::max(level.limit, run.error_limit);
    }
    const std::string label = row.method + (row.parameter.empty() ? "" : ", " + row.parameter);
    const bool beside = label == last;  // the second row of a method
    if (!beside) ++colour;
    last = label;
    if (levels.empty()) continue;  // a method that chooses its steps
    const bool limit = row.reference == OrderReference::Limit;
    ChartLine line{.label = beside ? "" : label, .x = {}, .y = {}, .dashed = beside, .colour = colour};
    for (const auto& [number, level] : levels) {
      if (level.failed && !beside) line.missing.push_back(level.h);
      line.x.push_back(level.h);
      line.y.push_back(level.failed ? not_set : limit ? level.limit : above_bar(level.q, table.bar_q));
    }
    const bool floors = !limit && std::isnan(row.expected);
    if (floors && row.q.floor == row.q.floor) chart.floors.push_back({row.q.floor, colour});
    chart.lines.push_back(line);
    if (row.q.known() && !std::isnan(row.expected) &&
        std::find(drawn.begin(), drawn.end(), row.expected) == drawn.end()) {
      drawn.push_back(row.expected);
      chart.slopes.push_back({chart.lines.size() - 1, row.expected});
    }
  }
  add_bar(table, chart);
  if (std::any_of(chart.lines.begin(), chart.lines.end(), [](const ChartLine& l) { return l.dashed; }))
    chart.lines.push_back({.label = "against own limit", .x = {}, .y = {}, .dashed = true, .colour = 6});
  return chart;
}

Chart work_chart(const ConvergenceTable& table) {
  Chart chart{.title = table.scene + ": error against CPU time",
              .x_label = "CPU time of a run [s]",
              .y_label = error_label(table),
              .lines = {}};
  for (const WorkLine& line : work_lines(table)) {
    const bool any = std::any_of(line.error.begin(), line.error.end(), [](double e) { return e > 0; });
    chart.lines.push_back({.label = line.label() + (any ? "" : why_empty(table, line.method, line.parameter)),
                           .x = line.seconds,
                           .y = line.error,
                           .colour = static_cast<int>(chart.lines.size())});
  }
  add_bar(table, chart);
  return chart;
}

}  // namespace perp
