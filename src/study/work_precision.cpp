#include "perp/study/work_precision.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace perp {

double WorkLine::error_within(double budget) const {
  double least = infinity;
  for (std::size_t i = 0; i < seconds.size(); ++i)
    if (seconds[i] <= budget) least = std::min(least, error[i]);
  return least;
}

std::vector<WorkLine> work_lines(const ConvergenceTable& table) {
  struct Level {
    double seconds = 0, error = 0;
    int runs = 0;
    bool whole = true;
  };
  std::vector<WorkLine> lines;
  std::vector<std::map<int, Level>> levels;
  for (const StudyRun& run : table.runs) {
    const auto own = std::find_if(lines.begin(), lines.end(), [&](const WorkLine& line) {
      return line.method == run.method && line.parameter == run.parameter;
    });
    const auto index = static_cast<std::size_t>(own - lines.begin());
    if (own == lines.end()) {
      lines.push_back({.method = run.method, .parameter = run.parameter, .seconds = {}, .error = {}});
      levels.emplace_back();
    }
    Level& level = levels[index][run.level];
    level.seconds += run.seconds;
    const double error = table.bar_q > 0 ? above_bar(run.error_q, table.bar_q) : run.error_q;
    level.error = std::max(level.error, error);
    level.whole = level.whole && !run.failed && std::isfinite(error);
    ++level.runs;
  }
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (const auto& [number, level] : levels[i]) {
      if (!level.whole) continue;
      lines[i].seconds.push_back(level.seconds / level.runs);
      lines[i].error.push_back(level.error);
    }
  return lines;
}

std::vector<WorkLine> WorkPrecision::run(const std::vector<Stepper*>& methods) const {
  ConvergenceStudy timed = study;
  timed.timing = timing;
  return work_lines(timed.run(methods));
}

}  // namespace perp
