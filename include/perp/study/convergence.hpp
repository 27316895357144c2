// Convergence studies: one scene, some methods, a ladder of steps; errors, costs, observed orders.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "perp/study/cpu_time.hpp"
#include "perp/study/error_measure.hpp"
#include "perp/study/observed_order.hpp"
#include "perp/study/reference.hpp"
#include "perp/study/scene.hpp"

namespace perp {

/// One run of a study: n equal steps of a method from the start to T. A row of study.csv.
struct StudyRun {
  std::string method;          ///< Stepper::name
  std::string parameter = {};  ///< "edges=8", or empty
  int level = 0;               ///< in the study's steps
  int n = 0;                   ///< steps from the start to T
  double h = not_set;          ///< [s] (T - start)/n
  double rtol = not_set;       ///< of methods that choose their steps
  double error_q = not_set;    ///< configuration_error at T; NaN of a run that failed or without a reference
  double error_v = not_set;    ///< by the study's measure
  double error_path =
      not_set;  ///< the largest configuration_error of its rows over the run, of a study over_run
  double error_p = not_set;      ///< impulse_error over the run, likewise [N s]
  double error_limit = not_set;  ///< configuration_error against the method's own limit, where one is formed
  double seconds = not_set;      ///< CPU time, best of repeats
  int steps = 0;                 ///< that advanced: n unless a step failed
  int switches = 0;              ///< changes of mode of contacts and joints from one step to the next
  double iterations = 0;         ///< of the solvers, all steps
  int failed = 0;                ///< steps that did not reach their tolerance: the run ends at the first
  std::string message = {};      ///< of that step
  State end = {};                ///< where it came to at T; empty if it failed
};

/// An error as a point: NaN where it is within the reference's bar, which is then all that is known of it.
[[nodiscard]] inline double above_bar(double error, double bar) {
  return bar == 0 || error > bar ? error : not_set;
}

/// A row of orders.csv.
struct OrderRow {
  std::string method, parameter;
  OrderReference reference = OrderReference::Exact;
  ObservedOrder q = {}, v = {};     ///< of error_q (or error_limit), of error_v
  ObservedOrder path = {}, p = {};  ///< of error_path and error_p, in rows against the reference
  double expected = not_set;        ///< what theory says of q; NaN where errors do not go to zero
  int failed = 0;                   ///< runs that failed
  std::string why = {};             ///< where the order of q is not `expected`: the reason, in words
};

/// All runs of one scene, with the orders that they show.
struct ConvergenceTable {
  std::string scene;
  std::vector<StudyRun> runs;    ///< in the order of methods, levels, step counts
  std::vector<OrderRow> orders;  ///< in the order of methods; exact, event or extrapolated before limit
  OrderReference reference = OrderReference::Exact;  ///< of error_q and error_v
  double bar_q = 0, bar_v = 0;  ///< errors at most that are not known (Reference); 0 of an exact motion
  std::string words = {};       ///< how the reference came about, or why there is none

  /// The order of `method` in configuration that is to be compared with `expected`; NaN if it shows none. With `parameter`
  /// ("edges=8") where the method is there more than once. Throws std::invalid_argument for one that is not.
  double order(std::string_view method, std::string_view parameter = {}) const;
  int failed() const;  ///< runs that failed

  /// study.csv. Defined on the floor `io`.
  void write_csv(const std::filesystem::path& path) const;
};

/// Runs every method over every step. The reference is the scene's exact motion where it is known, else a computed one that a second
/// method confirms (confirmed_reference). A method with a friction polygon whose vertices miss a direction of the
/// reference's friction does not tend to it: it is also held against its own limit.
/// An AdaptiveStepper makes one run, at its own tolerance, and shows no order.
struct ConvergenceStudy {
  Scene scene;
  double t_end = not_set;  ///< [s]; the scene's own if not set
  std::vector<double> steps =
      {};  ///< [s], in any order; a run takes n = max(1, round((T - start)/h)) of them; empty: ladder()
  int envelope = 1;  ///< runs a level: their n spread over [n, 1.25 n]; its error is the largest
  VelocityMeasure velocity = VelocityMeasure::AtEnd;
  TimingOptions timing = {.spend = 0};  ///< of each run; by default once
  ReferenceChoice reference = ReferenceChoice::Automatic;
  bool over_run = false;  ///< error_path and error_p too

  /// Runs in the order of the table. Throws std::invalid_argument for a null stepper or options it cannot take; a step that
  /// fails is a row of the table.
  [[nodiscard]] ConvergenceTable run(const std::vector<Stepper*>& methods) const;
};

/// The parts of a study, for those who run it in an order of their own.
class ScenePlan {
 public:
  /// Knows the exact motion, where that is the reference; computed ones come with find_reference().
  explicit ScenePlan(const ConvergenceStudy& study);

  /// Computes the reference, unless it is there. It is the same whenever it is computed anew.
  void find_reference();
  const Reference& reference() const { return reference_; }

  double t_end() const { return t_end_; }
  const Scene& scene() const { return study_.scene; }
  /// The run numbers of each level.
  const std::vector<std::vector<int>>& counts() const { return counts_; }

  /// One run with its errors against the reference; of an AdaptiveStepper without regard to n. Threads may call it at once, each with a stepper of its own.
  [[nodiscard]] StudyRun run(Stepper& stepper, int level, int n) const;

  /// Limits, errors against them, and orders. `runs` has the runs of each method together; some may be missing.
  [[nodiscard]] ConvergenceTable tabulate(std::vector<StudyRun> runs,
                                          const std::vector<Stepper*>& methods) const;

 private:
  void add_orders(const Stepper& method, std::vector<StudyRun*> runs, ConvergenceTable& table) const;
  bool polygon_fits(const Stepper& method) const;
  void find_motion();

  ConvergenceStudy study_;
  double t_end_ = 0;
  std::vector<std::vector<int>> counts_;
  Reference reference_;
  bool to_find_ = false;
};

/// "edges=8" of a polygonal method, else empty.
[[nodiscard]] std::string parameter_of(const Stepper& stepper);

/// The order that theory gives `method` in configuration on the scene of that name: the method's own, but for motions on
/// which its leading error term vanishes.
[[nodiscard]] double expected_order(std::string_view scene, const Stepper& method);

/// Whether friction of the scene's exact motion up to t_end is always along a vertex of the polygon with `edges` edges, which then
/// is exact. True for planar contacts.
[[nodiscard]] bool polygon_is_exact(const Scene& scene, int edges, double t_end);
/// The same of another motion of the scene's model.
[[nodiscard]] bool polygon_is_exact(const Scene& scene, const std::function<State(double t)>& motion,
                                    int edges, double t_end);

/// Why a row's order of q is not the expected one: runs that failed, a floor, the friction polygon, round-off, the reference's bar,
/// changes of mode within a step, steps that are not small enough yet; empty where it is, or nothing is expected.
[[nodiscard]] std::string why_not_expected(const OrderRow& row, const std::vector<const StudyRun*>& runs);

}  // namespace perp
