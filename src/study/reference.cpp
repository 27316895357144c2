#include "perp/study/reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <vector>

#include "perp/core/errors.hpp"
#include "perp/step/extrapolated.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

constexpr int confirming_runs = 5;
constexpr int refinements = 2;           // fourfold each
constexpr double scatters = 3;           // a limit is known no better than by so many of its runs' scatter
constexpr double share = 1e-3;           // of the motion's extent: a bar above it confirms nothing
constexpr double fits_better = 0.1;      // of the residual without it: then b h^4 is there
constexpr double looser = 100;           // the tolerance of the second run of `event`
constexpr double looks = 65536;          // a run, at loads that change with time
constexpr long evaluations = 4'000'000;  // of a right-hand side, in one run

std::string in_short(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return text;
}

/// Quaternions to unit length, as a sum of states needs.
void normalise(const Model& model, State& x) {
  for (const Body& body : model.bodies())
    if (body.kind == BodyKind::Spatial) x.q.segment<4>(body.q0 + 3).normalize();
}

/// What answers at steps h tend to by x(h) = L + sum over p of a_p h^p, least squares; and the largest residual of q.
struct Fit {
  State limit;
  double residual = 0;
};

Fit fitted(const Model& model, const std::vector<double>& h, const std::vector<State>& x,
           const std::vector<double>& powers) {
  const auto rows = static_cast<Eigen::Index>(h.size()), unknowns = static_cast<Eigen::Index>(powers.size());
  Matrix A(rows, unknowns + 1), Q(rows, x[0].q.size()), V(rows, x[0].nu.size());
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto k = static_cast<std::size_t>(i);
    A(i, 0) = 1;
    for (Eigen::Index j = 0; j < unknowns; ++j)
      A(i, j + 1) = std::pow(h[k] / h[0], powers[static_cast<std::size_t>(j)]);
    Q.row(i) = x[k].q.transpose();
    V.row(i) = x[k].nu.transpose();
  }
  const auto solver = A.colPivHouseholderQr();
  const Matrix q = solver.solve(Q), v = solver.solve(V);
  Fit fit{.limit = x.back()};
  fit.limit.q = q.row(0).transpose();
  fit.limit.nu = v.row(0).transpose();
  fit.residual = Q.size() == 0 ? 0 : (A * q - Q).lpNorm<Eigen::Infinity>();
  fit.residual /= std::sqrt(double(rows - unknowns - 1));
  normalise(model, fit.limit);
  return fit;
}

/// What ncp2 tends to, with the scatter of its runs about it; `fault` says why there is none.
struct FixedStepLimit {
  State limit = {};
  double scatter_q = 0;
  int n = 0;  // of the finest run
  std::optional<VelocityPath> velocity = {};
  std::string fault = {};
};

FixedStepLimit fixed_step_limit(const Scene& scene, double t_end, int least, VelocityMeasure velocity) {
  FixedStepLimit result;
  std::vector<double> h;
  std::vector<State> ends;
  for (int i = 0; i < confirming_runs; ++i) {
    const int n = static_cast<int>(least * std::exp2(double(i) / (confirming_runs - 1))) + i;
    h.push_back((t_end - scene.start.t) / n);
    Ncp2Stepper ncp2;
    try {
      const Trajectory run = simulate(scene.model, ncp2, scene.start, {.t_end = t_end, .h = h.back()});
      ends.push_back(run.back());
      result.n = n;
      if (i == confirming_runs - 1 && velocity != VelocityMeasure::AtEnd)
        result.velocity = velocity_path(scene.model, run);
    } catch (const StepFailure& failure) {
      result.fault = "ncp2 with " + std::to_string(n) + " steps ended: " + failure.what();
      return result;
    }
  }
  const Fit plain = fitted(scene.model, h, ends, {2}), longer = fitted(scene.model, h, ends, {2, 4});
  result.limit = longer.residual < fits_better * plain.residual ? longer.limit : plain.limit;
  for (const State& end : ends)
    result.scatter_q = std::max(result.scatter_q, configuration_error(scene.model, end, result.limit));
  return result;
}

/// A run of `event` or `extrapolated`; `fault` says why there is none.
struct EventRun {
  std::shared_ptr<Trajectory> run;
  std::shared_ptr<Stepper> method;  // what Trajectory::at asks
  std::string fault = {};
};

EventRun event_run(const Scene& scene, double t_end, double rtol, bool extrapolated) {
  EventRun result;
  const auto attempt = [&](double look) {
    if (extrapolated)
      result.method = std::make_shared<Extrapolated>(
          ExtrapolatedOptions{.rtol = rtol, .look = look, .max_evaluations = evaluations});
    else
      result.method = std::make_shared<EventDriven>(
          EventDrivenOptions{.rtol = rtol, .look = look, .max_evaluations = evaluations});
    result.run =
        std::make_shared<Trajectory>(simulate(scene.model, *result.method, scene.start, {.t_end = t_end}));
  };
  try {
    attempt(not_set);
    if (result.run->unseen > 0) attempt((t_end - scene.start.t) / looks);
  } catch (const StepFailure& failure) {
    result.fault = std::string(result.method->name()) + " ended: " + failure.what();
  }
  return result;
}

/// How far the motion goes: the largest change of configuration from the start, of its rows.
double extent(const Model& model, const Trajectory& run) {
  double largest = 0;
  const State start = run.front();
  for (std::size_t i = 1; i < run.size(); ++i)
    largest = std::max(largest, configuration_error(model, run.state(i), start));
  return largest;
}

double round_off(const State& x, int n) {
  return x.q.size() == 0 ? 0 : n * std::numeric_limits<double>::epsilon() * x.q.lpNorm<Eigen::Infinity>();
}

double distance(const Model& model, VelocityMeasure measure, const VelocityPath& a, const VelocityPath& b,
                const State& at_a, const State& at_b, double length) {
  if (measure == VelocityMeasure::AtEnd) return velocity_error(model, at_a, at_b);
  if (measure == VelocityMeasure::L1) return l1_distance(a, b);
  return graph_distance(a, b, std::max(b.v.cwiseAbs().maxCoeff(), 1e-300) / length);
}

}  // namespace

std::string_view name_of(ReferenceChoice choice) {
  constexpr std::array<std::string_view, 5> names{"automatic", "exact", "event", "extrapolated", "own-limit"};
  return names[static_cast<std::size_t>(choice)];
}

ReferenceChoice reference_named(std::string_view name) {
  for (const ReferenceChoice choice : {ReferenceChoice::Exact, ReferenceChoice::Event,
                                       ReferenceChoice::Extrapolated, ReferenceChoice::OwnLimit})
    if (name_of(choice) == name) return choice;
  refuse("perp study", "--reference", name, "needs to be exact, event, extrapolated or own-limit");
}

std::string_view name_of(OrderReference reference) {
  constexpr std::array<std::string_view, 5> names{"exact", "event", "extrapolated", "limit", "none"};
  return names[static_cast<std::size_t>(reference)];
}

Reference exact_reference(const Scene& scene, double t_end, VelocityMeasure velocity) {
  Reference result{.words = "no exact motion is known"};
  if (!scene.exact) return result;
  State end = scene.exact(t_end);
  if (!end.q.allFinite() || !end.nu.allFinite()) return result;  // not known so far
  result = {.kind = OrderReference::Exact,
            .end = std::move(end),
            .motion = scene.exact,
            .words = "exact motion known"};
  if (velocity != VelocityMeasure::AtEnd)
    result.velocity = velocity_path(scene.model, scene.exact, scene.start.t, t_end);
  return result;
}

std::optional<ImpulsePath> reference_impulses(const Scene& scene, double t_end, double h) {
  constexpr double finer = 4;
  Ncp2Stepper ncp2;
  try {
    return impulse_path(scene.model,
                        simulate(scene.model, ncp2, scene.start, {.t_end = t_end, .h = h / finer}));
  } catch (const StepFailure&) {
    return std::nullopt;
  }
}

Reference confirmed_reference(const Scene& scene, double t_end, const ReferenceOptions& options) {
  const Model& model = scene.model;
  const auto none = [](const std::string& why) { return Reference{.words = "no reference: " + why}; };
  const bool extrapolated = options.by == ReferenceChoice::Extrapolated;
  const std::string name = extrapolated ? "extrapolated" : "event";
  const EventRun tight = event_run(scene, t_end, options.tolerance, extrapolated);
  if (!tight.fault.empty()) return none(tight.fault);
  const EventRun loose = event_run(scene, t_end, looser * options.tolerance, extrapolated);
  if (!loose.fault.empty()) return none(loose.fault);
  const State end = tight.run->back(), other = loose.run->back();
  const double size = extent(model, *tight.run);

  for (int i = 0, n = options.steps;; ++i, n *= 4) {
    const FixedStepLimit ncp2 = fixed_step_limit(scene, t_end, n, options.velocity);
    if (!ncp2.fault.empty()) return none(ncp2.fault);
    const double rounding = round_off(end, ncp2.n);
    const double apart = configuration_error(model, end, ncp2.limit);
    const double bar = std::max(apart, configuration_error(model, end, other));
    if (apart <= scatters * ncp2.scatter_q + rounding && bar <= share * size + rounding) {
      Reference result{.kind = extrapolated ? OrderReference::Extrapolated : OrderReference::Event,
                       .end = end,
                       .bar_q = bar};
      VelocityPath of_event, of_ncp2;
      if (options.velocity != VelocityMeasure::AtEnd) {
        result.velocity = velocity_path(model, *tight.run);
        of_event = *result.velocity;
        of_ncp2 = *ncp2.velocity;
      }
      result.bar_v = std::max(
          velocity_error(model, end, other) * (options.velocity == VelocityMeasure::AtEnd),
          distance(model, options.velocity, of_ncp2, of_event, ncp2.limit, end, t_end - scene.start.t));
      result.motion = [tight, one_at_a_time = std::make_shared<std::mutex>()](double t) {
        const std::lock_guard lock(*one_at_a_time);
        return tight.run->at(t);
      };
      result.words = "reference: " + name + " at rtol " + in_short(options.tolerance) +
                     "; the limit of ncp2 with " + std::to_string(n) + " to " + std::to_string(ncp2.n) +
                     " steps is " + in_short(bar) + " m or rad from it, its error bar";
      return result;
    }
    if (i < refinements) continue;
    return none(name + " and the limit of ncp2 with " + std::to_string(ncp2.n) + " steps are " +
                in_short(apart) + " m or rad apart, where ncp2 scatters by " + in_short(ncp2.scatter_q) +
                " and the motion goes " + in_short(size) + " far");
  }
}

}  // namespace perp
