#include "perp/io/study_files.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "perp/io/csv_file.hpp"
#include "perp/study/work_precision.hpp"

namespace perp {

void write_study_csv(const std::filesystem::path& path, const std::vector<ConvergenceTable>& tables) {
  CsvFile csv(path, {"scene", "method", "parameter", "h", "rtol", "error_q", "error_v", "seconds", "steps",
                     "iterations", "failed", "error_limit", "message"});
  for (const ConvergenceTable& table : tables)
    for (const StudyRun& run : table.runs) {
      csv.cell(table.scene).cell(run.method).cell(run.parameter).cell(run.h).cell(run.rtol);
      csv.cell(run.error_q).cell(run.error_v).cell(run.seconds).cell(run.steps).cell(run.iterations);
      csv.cell(run.failed).cell(run.error_limit).cell(run.message).end_row();
    }
  csv.finish();
}

void write_orders_csv(const std::filesystem::path& path, const std::vector<ConvergenceTable>& tables) {
  CsvFile csv(path, {"scene", "method", "parameter", "reference", "order", "order_v", "points", "expected",
                     "failed", "note"});
  for (const ConvergenceTable& table : tables)
    for (const OrderRow& row : table.orders) {
      csv.cell(table.scene).cell(row.method).cell(row.parameter).cell(name_of(row.reference));
      csv.cell(row.q.order).cell(row.v.order).cell(row.q.points).cell(row.expected);
      csv.cell(row.failed).cell(note_of(row)).end_row();
    }
  csv.finish();
}

std::string note_of(const OrderRow& row) {
  if (row.v.note.empty()) return row.q.note;
  return row.q.note + (row.q.note.empty() ? "" : "; ") + "velocity: " + row.v.note;
}

void ConvergenceTable::write_csv(const std::filesystem::path& path) const { write_study_csv(path, {*this}); }

Chart convergence_chart(const ConvergenceTable& table) {
  Chart chart{.title = table.scene + ": error against step",
              .x_label = "step h [s]",
              .y_label = "error in configuration at T [m, rad]",
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
      level.q = std::max(level.q, run.error_q);
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
      line.y.push_back(level.failed ? not_set : limit ? level.limit : level.q);
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
  if (std::any_of(chart.lines.begin(), chart.lines.end(), [](const ChartLine& l) { return l.dashed; }))
    chart.lines.push_back({.label = "against own limit", .x = {}, .y = {}, .dashed = true, .colour = 6});
  return chart;
}

Chart work_chart(const ConvergenceTable& table) {
  Chart chart{.title = table.scene + ": error against CPU time",
              .x_label = "CPU time of a run [s]",
              .y_label = "error in configuration at T [m, rad]",
              .lines = {}};
  for (const WorkLine& line : work_lines(table))
    chart.lines.push_back({.label = line.label(),
                           .x = line.seconds,
                           .y = line.error,
                           .colour = static_cast<int>(chart.lines.size())});
  return chart;
}

}  // namespace perp
