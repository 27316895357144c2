#include "perp/study/fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "perp/core/errors.hpp"
#include "study/fit_adjust.hpp"
#include "study/fit_report.hpp"
#include "study/fit_start.hpp"

namespace perp {
namespace {

void check(const FitProblem& problem) {
  if (!problem.scene) refuse("fit", "scene", "nothing", "needs a function that makes the scene");
  if (problem.measured.empty()) refuse("fit", "measured", "nothing", "needs one motion or more");
  if (!(problem.hold_back >= 0 && problem.hold_back < 1))
    refuse("fit", "hold_back", problem.hold_back, "needs to be in [0, 1)");
  if (problem.jobs < 1) refuse("fit", "jobs", static_cast<double>(problem.jobs), "needs to be 1 or more");
  if (!std::isnan(problem.h) && !(problem.h > 0)) refuse("fit", "h", problem.h, "needs to be positive [s]");
  (void)make_stepper(problem.method, problem.options);
  for (const auto* motions : {&problem.measured, &problem.held_back})
    for (const MeasuredMotion& motion : *motions) {
      if (motion.t.empty()) refuse("fit", "measured " + motion.name, "empty", "needs a row or more");
      if (motion.values.rows() != static_cast<Eigen::Index>(motion.t.size()) ||
          motion.values.cols() != static_cast<Eigen::Index>(motion.columns.size()))
        refuse("fit", "measured " + motion.name, "values of another size", "needs (rows, columns)");
      for (std::size_t i = 1; i < motion.t.size(); ++i)
        if (!(motion.t[i] > motion.t[i - 1]))
          refuse("fit", "t of " + motion.name, motion.t[i], "needs to rise");
    }
}

/// Moves a share of the motions to those held back, which ones by the seed. A motion alone gives its last rows: how many.
int hold_back(const FitProblem& problem, std::vector<MeasuredMotion>& measured,
              std::vector<MeasuredMotion>& held) {
  const auto n = static_cast<int>(measured.size());
  if (problem.hold_back == 0) return 0;
  if (n == 1) {
    const auto rows = static_cast<int>(measured[0].t.size());
    return std::clamp(static_cast<int>(std::lround(problem.hold_back * rows)), 1, rows - 1);
  }
  const int share = std::clamp(static_cast<int>(std::lround(problem.hold_back * n)), 1, n - 1);
  std::vector<std::size_t> order(measured.size());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(problem.seed);
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
  std::sort(order.begin(), order.begin() + share);
  std::vector<MeasuredMotion> kept;
  for (std::size_t i = 0; i < measured.size(); ++i)
    (std::binary_search(order.begin(), order.begin() + share, i) ? held : kept)
        .push_back(std::move(measured[i]));
  measured = std::move(kept);
  return 0;
}

}  // namespace

FitResult fit(const FitProblem& problem) {
  check(problem);
  std::vector<MeasuredMotion> measured = problem.measured, held = problem.held_back;
  const int last_rows = hold_back(problem, measured, held);
  const Scene scene = problem.scene(problem.set);
  FitRuns runs(problem, measured, scene);
  Unknowns unknowns(problem, scene, measured);
  guess_from_data(runs, scene, unknowns);
  FitResult result;

  FitAdjuster adjuster(problem, runs, unknowns, last_rows);
  adjuster.find_bounds();
  adjuster.settle_starts();
  result.search = adjuster.search_parameters();
  const bool converged = adjuster.adjust();
  result.status = !adjuster.runs_at_all() ? FitStatus::NoRun
                  : converged             ? FitStatus::Converged
                                          : FitStatus::BudgetSpent;
  result.message = result.status == FitStatus::NoRun ? "no start was found from which the scene runs"
                   : converged                       ? "ended at a minimum"
                                                     : "ended before a minimum: iterations ran out";
  if (result.fitted()) {
    report_values(adjuster, result);
    report_residuals(adjuster, result);
    if (!held.empty())
      predict(problem, held, unknowns, adjuster.theta(), adjuster.sigmas(), runs.columns(), result);
  }
  result.runs += runs.runs();
  result.failed += runs.failed();
  return result;
}

}  // namespace perp
