#include "perp/study/convergence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "instant/scales.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

/// n of each level: that of the step, or `envelope` of them spread over [n, 1.25 n].
std::vector<std::vector<int>> run_numbers(double length, const std::vector<double>& steps, int envelope) {
  std::vector<std::vector<int>> levels;
  for (const double h : steps) {
    if (!(h > 0) || !std::isfinite(h)) refuse("ConvergenceStudy", "steps", h, "needs to be positive [s]");
    const double n = std::max(1.0, std::round(length / h));
    if (n > 1e9) refuse("ConvergenceStudy", "steps", h, "needs more than 1e9 steps to t_end");
    std::set<int> counts;
    for (int i = 0; i < envelope; ++i)
      counts.insert(static_cast<int>(envelope == 1 ? n : n + std::floor(n * i / (4.0 * (envelope - 1)))));
    levels.emplace_back(counts.begin(), counts.end());
  }
  return levels;
}

/// What n steps of rounding may add up to: one unit in the last place of the largest coordinate (or velocity) each.
double round_off(int n, const Vector& start, const Vector& end) {
  double scale = 0;
  for (const Vector* x : {&start, &end})
    if (x->size() > 0) scale = std::max(scale, x->lpNorm<Eigen::Infinity>());
  return n * std::numeric_limits<double>::epsilon() * scale;
}

/// The errors of a level are the largest of its runs; one that failed leaves none.
double largest_or_nan(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? not_set : std::max(a, b);
}

/// How often contacts and joints are in another mode than in the step before.
int switches_of(const Trajectory& run) {
  int switches = 0;
  StepReport before;
  for (std::size_t i = 0; i < run.steps(); ++i) {
    StepReport now = run.report(i);
    const auto changed = [](const auto& a, const auto& b) { return a.mode != b.mode; };
    if (i > 0 && now.contacts.size() == before.contacts.size())
      for (std::size_t k = 0; k < now.contacts.size(); ++k)
        switches += changed(now.contacts[k], before.contacts[k]);
    else if (i > 0)
      ++switches;  // contacts came into reach, or left it
    for (std::size_t k = 0; i > 0 && k < std::min(now.joints.size(), before.joints.size()); ++k)
      switches += changed(now.joints[k], before.joints[k]);
    before = std::move(now);
  }
  return switches;
}

struct LevelErrors {
  int n = 0;  // the least of the level
  double h = 0, q = 0, v = 0;
  double q_limit = 0, v_limit = 0;
  double path = 0, p = 0;
};

}  // namespace

std::string parameter_of(const Stepper& stepper) {
  if (stepper.edges() > 0) return "edges=" + std::to_string(stepper.edges());
  const bool of_order = stepper.name() == "extrapolated" && stepper.order() > 0;
  return of_order ? "order=" + std::to_string(stepper.order()) : "";
}

double expected_order(std::string_view scene, const Stepper& method) {
  struct Exception {
    std::string_view scene, method;
    double order;
  };
  static constexpr std::array exceptions{
      // a straight step ends outside the circle by h^2 v^2/(2R), and the next is turned inwards by as much
      Exception{"bead-in-ring", "lcp", 2},
      Exception{"bead-in-ring", "ncp-start", 2},
      // gap rows of the step's start put the velocity half a step ahead, which the flight makes up for
      Exception{"shaker", "lcp", 2},
      Exception{"shaker", "ncp", 2},
      Exception{"shaker", "ncp-start", 2},
      // after the step of an impact that throws back, time is off by a part of that step
      Exception{"bouncing-ball", "ncp2", 1},
      Exception{"rocking-block", "ncp2", 1},
  };
  for (const Exception& e : exceptions)
    if (e.scene == scene && e.method == method.name()) return e.order;
  return method.order();
}

double ConvergenceTable::order(std::string_view method, std::string_view wanted) const {
  const OrderRow* found = nullptr;
  for (const OrderRow& row : orders)
    if (row.method == method && (wanted.empty() || row.parameter == wanted) &&
        (found == nullptr || found->parameter == row.parameter))
      found = &row;  // limit comes after exact
  if (found == nullptr) refuse("ConvergenceTable::order", "method", method, "needs to be one of the study");
  return found->q.order;
}

int ConvergenceTable::failed() const {
  return static_cast<int>(
      std::count_if(runs.begin(), runs.end(), [](const StudyRun& r) { return r.failed; }));
}

ScenePlan::ScenePlan(const ConvergenceStudy& study) : study_(study) {
  const Scene& s = study_.scene;
  t_end_ = std::isnan(study.t_end) ? s.t_end : study.t_end;
  if (!(t_end_ > s.start.t) || !std::isfinite(t_end_))
    refuse("ConvergenceStudy", "t_end", t_end_, "needs to be past the start at " + shortest(s.start.t));
  if (study.envelope < 1)
    refuse("ConvergenceStudy", "envelope", static_cast<double>(study.envelope), "needs to be at least 1");
  if (study_.steps.empty()) study_.steps = ladder(t_end_ - s.start.t);
  counts_ = run_numbers(t_end_ - s.start.t, study_.steps, study.envelope);

  if (study.reference == ReferenceChoice::Exact || study.reference == ReferenceChoice::Automatic)
    reference_ = exact_reference(s, t_end_, study.velocity);
  if (study.reference == ReferenceChoice::Exact && !reference_)
    refuse("ConvergenceStudy", "reference", "exact",
           "needs a scene whose exact motion is known up to t_end: " + s.name + " is none");
  to_find_ = !reference_ && study.reference != ReferenceChoice::OwnLimit;
  if (study.reference == ReferenceChoice::OwnLimit)
    reference_ = {.kind = OrderReference::Limit,
                  .words = "no reference: each method against its own limit, which may be a wrong one"};
}

void ScenePlan::find_reference() {
  find_motion();
  if (!study_.over_run || !reference_.motion || reference_.impulses) return;
  const Scene& s = study_.scene;
  int finest = 1;
  for (const std::vector<int>& level : counts_) finest = std::max(finest, level.front());
  reference_.impulses = reference_impulses(s, t_end_, (t_end_ - s.start.t) / finest);
  Instant start;
  evaluate(s.model, s.start, start);
  reference_.length = scales_of(s.model, s.start, start).length;
}

void ScenePlan::find_motion() {
  if (!to_find_) return;
  ReferenceOptions options{.velocity = study_.velocity};
  if (study_.reference == ReferenceChoice::Extrapolated) options.by = ReferenceChoice::Extrapolated;
  for (const std::vector<int>& level : counts_) options.steps = std::max(options.steps, level.front());
  reference_ = confirmed_reference(study_.scene, t_end_, options);
  to_find_ = false;
}

bool ScenePlan::polygon_fits(const Stepper& method) const {
  return method.edges() == 0 || polygon_is_exact(study_.scene, reference_.motion, method.edges(), t_end_);
}

StudyRun ScenePlan::run(Stepper& stepper, int level, int n) const {
  const Scene& s = study_.scene;
  const double length = t_end_ - s.start.t;
  StudyRun result{.method = std::string(stepper.name()), .parameter = parameter_of(stepper), .level = level};
  result.n = n;
  if (chooses_steps(stepper))
    result.rtol = dynamic_cast<const AdaptiveStepper&>(stepper).tolerance();
  else
    result.h = length / n;
  Trajectory run;
  const auto compute = [&] {
    try {
      run = simulate(s.model, stepper, s.start, {.t_end = t_end_, .h = result.h});
    } catch (const StepFailure& failure) {
      run = failure.trajectory;
      result.failed = 1;
      result.message = failure.what();
    }
  };
  result.seconds = best_cpu_seconds(compute, study_.timing);
  result.steps = static_cast<int>(run.steps());
  for (std::size_t i = 0; i < run.steps(); ++i) result.iterations += run.figures(i).iterations;
  result.switches = switches_of(run);
  if (result.failed) return result;

  result.end = run.back();
  if (!reference_.motion) return result;
  if (study_.over_run) {
    result.error_path = 0;
    for (std::size_t i = 0; i < run.size(); ++i)
      result.error_path = std::max(result.error_path,
                                   configuration_error(s.model, run.state(i), reference_.motion(run.t(i))));
    if (reference_.impulses)
      result.error_p = impulse_error(impulse_path(s.model, run), *reference_.impulses, reference_.length);
  }
  result.error_q = configuration_error(s.model, result.end, reference_.end);
  if (study_.velocity == VelocityMeasure::AtEnd) {
    result.error_v = velocity_error(s.model, result.end, reference_.end);
    return result;
  }
  const VelocityPath path = velocity_path(s.model, run);
  result.error_v =
      study_.velocity == VelocityMeasure::L1
          ? l1_distance(path, *reference_.velocity)
          : graph_distance(path, *reference_.velocity, reference_.velocity->v.cwiseAbs().maxCoeff() / length);
  return result;
}

ConvergenceTable ScenePlan::tabulate(std::vector<StudyRun> runs, const std::vector<Stepper*>& methods) const {
  ConvergenceTable table{.scene = study_.scene.name,
                         .runs = std::move(runs),
                         .orders = {},
                         .reference = reference_.kind,
                         .bar_q = reference_.bar_q,
                         .bar_v = reference_.bar_v,
                         .words = reference_.words};
  for (const Stepper* method : methods) {
    std::vector<StudyRun*> own;
    for (StudyRun& run : table.runs)
      if (run.method == method->name() && run.parameter == parameter_of(*method)) own.push_back(&run);
    add_orders(*method, own, table);
  }
  return table;
}

void ScenePlan::add_orders(const Stepper& method, std::vector<StudyRun*> runs,
                           ConvergenceTable& table) const {
  if (chooses_steps(method)) {  // its errors follow a tolerance
    OrderRow row{.method = std::string(method.name()), .parameter = parameter_of(method)};
    row.reference = reference_.motion ? reference_.kind : OrderReference::None;
    row.q.note = "chooses its steps";
    row.q.points = static_cast<int>(runs.size());
    for (const StudyRun* run : runs) row.failed += run->failed;
    table.orders.push_back(row);
    return;
  }
  const Model& model = study_.scene.model;
  const double length = t_end_ - study_.scene.start.t;
  const bool known = reference_.motion != nullptr, own = reference_.kind == OrderReference::Limit;
  const bool tends_to_it = known && polygon_fits(method);

  // the two levels of the smallest steps that have an answer, and what they tend to
  const StudyRun *fine = nullptr, *coarse = nullptr;
  const auto by_n = [](const StudyRun* a, const StudyRun* b) { return a->n < b->n; };
  std::vector<StudyRun*> answered;
  for (std::size_t level = 0; level < counts_.size() && !tends_to_it; ++level)
    for (StudyRun* run : runs)
      if (run->level == static_cast<int>(level) && run->n == counts_[level].front() && !run->failed)
        answered.push_back(run);
  std::sort(answered.begin(), answered.end(), by_n);
  for (auto run = answered.rbegin(); run != answered.rend() && coarse == nullptr; ++run)
    if (fine == nullptr)
      fine = *run;
    else if ((*run)->n < fine->n)
      coarse = *run;
  std::optional<State> limit;
  if (coarse != nullptr)
    limit = extrapolated(model, coarse->end, fine->end, double(fine->n) / coarse->n, method.order());
  for (StudyRun* run : runs) {
    if (!limit || run->failed) continue;
    run->error_limit = configuration_error(model, run->end, *limit);
    if (!own) continue;
    run->error_q = run->error_limit;
    run->error_v = velocity_error(model, run->end, *limit);
  }

  std::vector<LevelErrors> levels;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    LevelErrors level{.n = counts_[i].front(), .h = length / counts_[i].front()};
    bool any = false;
    for (const StudyRun* run : runs) {
      if (run->level != static_cast<int>(i)) continue;
      any = true;
      level.q = largest_or_nan(level.q, run->error_q);
      level.v = largest_or_nan(level.v, run->error_v);
      level.path = largest_or_nan(level.path, run->error_path);
      level.p = largest_or_nan(level.p, run->error_p);
      level.q_limit = largest_or_nan(level.q_limit, run->error_limit);
      const bool there = limit && !run->failed;
      level.v_limit =
          largest_or_nan(level.v_limit, there ? velocity_error(model, run->end, *limit) : not_set);
    }
    if (any) levels.push_back(level);
  }

  const State& start = study_.scene.start;
  const State& end = known ? reference_.end : limit ? *limit : start;
  const auto row = [&](OrderReference reference) {
    OrderRow result{.method = std::string(method.name()), .parameter = parameter_of(method)};
    result.reference = reference;
    const bool to_limit = reference == OrderReference::Limit;
    if (to_limit || tends_to_it) result.expected = expected_order(study_.scene.name, method);
    std::vector<double> h, q, v, path, p, q_rounding, v_rounding, none;
    for (const LevelErrors& level : levels) {
      if (to_limit && limit && level.n >= coarse->n) continue;  // the limit was made of them
      h.push_back(level.h);
      q.push_back(to_limit ? level.q_limit : level.q);
      v.push_back(to_limit ? level.v_limit : level.v);
      path.push_back(level.path);
      p.push_back(level.p);
      none.push_back(0);
      q_rounding.push_back(round_off(level.n, start.q, end.q));
      v_rounding.push_back(round_off(level.n, start.nu, end.nu));
    }
    result.q = observed_order(h, q, q_rounding, {.bar = to_limit ? 0 : reference_.bar_q});
    result.v = observed_order(h, v, v_rounding, {.bar = to_limit ? 0 : reference_.bar_v});
    if (!to_limit && study_.over_run) {
      result.path = observed_order(h, path, q_rounding, {.bar = reference_.bar_q});
      result.p = observed_order(h, p, none);
    }
    for (const StudyRun* run : runs) result.failed += run->failed;
    result.why = why_not_expected(result, {runs.begin(), runs.end()});
    return result;
  };
  if (known) table.orders.push_back(row(reference_.kind));
  if (!tends_to_it) table.orders.push_back(row(OrderReference::Limit));
}

ConvergenceTable ConvergenceStudy::run(const std::vector<Stepper*>& methods) const {
  ScenePlan plan(*this);
  plan.find_reference();
  std::vector<StudyRun> runs;
  for (Stepper* method : methods) {
    if (method == nullptr) refuse("ConvergenceStudy::run", "methods", "null", "needs steppers");
    if (chooses_steps(*method)) runs.push_back(plan.run(*method, 0, 1));
    for (std::size_t level = 0; level < plan.counts().size() && !chooses_steps(*method); ++level)
      for (const int n : plan.counts()[level]) runs.push_back(plan.run(*method, static_cast<int>(level), n));
  }
  return plan.tabulate(std::move(runs), methods);
}

}  // namespace perp
