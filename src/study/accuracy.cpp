#include "perp/study/accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/error_measure.hpp"

namespace perp {
namespace {

constexpr double margin =
    0.5;  // of the accuracy: what a trial's error may be, since the estimate is off by a few per cent
constexpr double aim = 0.25;  // of the accuracy: what the next trial is to have

/// One trial after another: each gives the choice its error and its reference.
class Trials {
 public:
  Trials(const Model& model, const State& start, const AccuracyRequest& request)
      : model_(model), start_(start), request_(request), method_(method(request.method)) {
    choice_.options = request.options;
  }

  AccuracyChoice by_tolerance();
  AccuracyChoice by_steps();

 private:
  bool close_enough() const { return choice_.error <= margin * request_.accuracy; }
  AccuracyChoice end(const std::string& why);
  Trajectory run(std::string_view name, const MethodOptions& options, double h) const;
  bool attempt(double h, std::string_view reference, const MethodOptions& finer, double finer_h);

  const Model& model_;
  const State& start_;
  const AccuracyRequest& request_;
  const Method& method_;
  AccuracyChoice choice_;
};

AccuracyChoice Trials::end(const std::string& why) {
  choice_.reached = choice_.error <= request_.accuracy;
  if (!choice_.reached) choice_.why = why;
  return std::move(choice_);
}

Trajectory Trials::run(std::string_view name, const MethodOptions& options, double h) const {
  const std::unique_ptr<Stepper> stepper = make_stepper(name, options);
  return simulate(model_, *stepper, start_, {.t_end = request_.t_end, .h = h});
}

/// False, and choice_.why says so, where a run ended early.
bool Trials::attempt(double h, std::string_view reference, const MethodOptions& finer, double finer_h) {
  choice_.error = infinity;
  try {
    const Trajectory rows = run(request_.method, choice_.options, h);
    choice_.reference = run(reference, finer, finer_h);
    choice_.error = 0;
    for (std::size_t i = 0; i < rows.size(); ++i)
      choice_.error = std::max(choice_.error, choice_.estimate(model_, rows.state(i)));
    return true;
  } catch (const StepFailure& failure) {
    choice_.why = failure.what();
    return false;
  }
}

AccuracyChoice Trials::by_tolerance() {
  constexpr double tightest = 1e-14, loosest = 1e-3, finer = 1e-2, least = 1e-15;
  double& tolerance = choice_.options.tolerance;
  tolerance = std::clamp(0.1 * request_.accuracy, tightest, loosest);
  for (;;) {
    MethodOptions reference = choice_.options;
    reference.tolerance = std::max(finer * tolerance, least);
    if (attempt(not_set, request_.method, reference, not_set) && close_enough()) return end("");
    if (tolerance <= tightest)
      return end(choice_.why.empty()
                     ? "errors have come down to rounding at a tolerance of " + shortest(tightest)
                     : choice_.why);
    const double next = std::isfinite(choice_.error) ? aim * request_.accuracy / choice_.error : 0.1;
    tolerance = std::max(tightest, tolerance * std::clamp(next, 1e-4, 0.2));
  }
}

AccuracyChoice Trials::by_steps() {
  constexpr int finer = 4, most_edges = 256;
  const double length = request_.t_end - start_.t;
  const std::string_view reference = method_.polygonal ? "ncp" : request_.method;
  double n = 20, last = infinity;
  for (;;) {
    choice_.h = length / n;
    const bool ran = attempt(choice_.h, reference, choice_.options, choice_.h / finer);
    if (ran && close_enough()) return end("");
    constexpr double stalls = 0.7;  // of the error before: the step is not what it comes from
    const double most_growth = method_.polygonal ? 4 : 32;
    const double ratio = choice_.error / (aim * request_.accuracy);
    const double growth = std::isfinite(ratio) ? std::pow(ratio, 1.0 / method_.order) : 4;
    const double next = std::ceil(n * std::clamp(growth, 1.5, most_growth));
    const double of_edges = method_.polygonal ? std::max(1.0, choice_.options.edges / 8.0) : 1;
    const bool too_many = next * finer * of_edges > request_.most_steps;
    if (method_.polygonal && ran && choice_.options.edges < most_edges &&
        (too_many || choice_.error > stalls * last)) {
      choice_.options.edges *= 2;
      last = infinity;
      continue;
    }
    if (too_many)
      return end(ran ? shortest(n) + " steps have an error of " + shortest(choice_.error) + ", and " +
                           shortest(next) + " would be tried next"
                     : choice_.why);
    last = choice_.error;
    n = next;
  }
}

}  // namespace

double AccuracyChoice::estimate(const Model& model, const State& x) const {
  return configuration_error(model, x, reference.at(std::clamp(x.t, reference.t(0), reference.back().t)));
}

AccuracyChoice choose_for_accuracy(const Model& model, const State& start, const AccuracyRequest& request) {
  if (!(request.accuracy > 0) || !std::isfinite(request.accuracy))
    refuse("choose_for_accuracy", "accuracy", request.accuracy, "needs to be positive [m, rad]");
  Trials trials(model, start, request);
  return method(request.method).adaptive ? trials.by_tolerance() : trials.by_steps();
}

}  // namespace perp
