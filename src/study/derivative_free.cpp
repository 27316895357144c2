#include "study/derivative_free.hpp"

#include <algorithm>
#include <cmath>
#include <exception>

#ifdef PERP_HAS_NLOPT
#include <nlopt.h>
#endif

namespace perp {

std::string sentence_of_nlopt(int code) {
  switch (code) {
    case 1:
      return "ended at a minimum";
    case 2:
      return "ended below the value asked for";
    case 3:
      return "ended where the value changes no more";
    case 4:
      return "ended where the point changes no more";
    case 5:
      return "ended after the evaluations that it was given";
    case 6:
      return "ended after the time that it was given";
    case -1:
      return "failed for a reason that NLopt does not name";
    case -2:
      return "was refused: NLopt cannot take these arguments";
    case -3:
      return "ended for lack of memory";
    case -4:
      return "ended where rounding errors hide any gain; its best point is kept";
    case -5:
      return "was stopped from outside; its best point is kept";
    default:
      return "ended with NLopt's code " + std::to_string(code) + ", which this perp does not know";
  }
}

#ifdef PERP_HAS_NLOPT
namespace {

struct Objective {
  const std::function<double(const Vector&)>& f;
  nlopt_opt opt = nullptr;
  SearchEnd best = {};
  std::exception_ptr error = {};
};

double value(unsigned n, const double* x, double* /*gradient*/, void* data) {
  auto& objective = *static_cast<Objective*>(data);
  try {
    const Vector at = Eigen::Map<const Vector>(x, static_cast<Eigen::Index>(n));
    const double f = objective.f(at);
    ++objective.best.evaluations;
    if (f < objective.best.value) objective.best.x = at, objective.best.value = f;
    return f;
  } catch (...) {  // must not pass through NLopt, which is C
    objective.error = std::current_exception();
    nlopt_force_stop(objective.opt);
    return HUGE_VAL;
  }
}

std::string run(nlopt_algorithm algorithm, Objective& objective, const Vector& low, const Vector& high,
                Vector x, long evaluations, const Vector& step) {
  const auto n = static_cast<unsigned>(x.size());
  const nlopt_opt opt = nlopt_create(algorithm, n);
  if (opt == nullptr) return sentence_of_nlopt(NLOPT_OUT_OF_MEMORY);
  objective.opt = opt;
  constexpr double close = 1e-3;  // of the box: Levenberg-Marquardt goes on from there
  const Vector tolerance = close * (high - low);
  double f = 0;
  int code = nlopt_set_lower_bounds(opt, low.data());
  for (const int each :
       {int(nlopt_set_upper_bounds(opt, high.data())), int(nlopt_set_min_objective(opt, value, &objective)),
        int(nlopt_set_maxeval(opt, static_cast<int>(std::min(evaluations, 1'000'000'000L)))),
        int(nlopt_set_xtol_abs(opt, tolerance.data())), int(nlopt_set_initial_step(opt, step.data()))})
    code = std::min(code, each);
  if (code > 0) code = nlopt_optimize(opt, x.data(), &f);
  nlopt_destroy(opt);
  return std::string(nlopt_algorithm_name(algorithm)).substr(0, 60) + " " + sentence_of_nlopt(code);
}

}  // namespace

SearchEnd search(const std::function<double(const Vector&)>& f, const Vector& low, const Vector& high,
                 const Vector& x, long evaluations, unsigned seed) {
  Objective objective{.f = f};
  objective.best.x = x;
  const Vector range = high - low;
  nlopt_srand(seed);  // NLopt keeps one generator a thread
  std::string ends;
  const long local = x.size() > 1 ? evaluations / 3 : 0;  // BOBYQA needs two variables or more
  const auto stopped = [&] { return objective.error != nullptr; };
  if (evaluations - local > 0)
    ends = run(NLOPT_GN_CRS2_LM, objective, low, high, x, evaluations - local, 0.25 * range);
  if (local > 0 && !stopped())
    ends += "; " + run(NLOPT_LN_BOBYQA, objective, low, high, Vector(objective.best.x), local, 0.1 * range);
  if (stopped()) std::rethrow_exception(objective.error);
  objective.best.sentence = ends;
  return objective.best;
}
#else
SearchEnd search(const std::function<double(const Vector&)>& f, const Vector& /*low*/, const Vector& /*high*/,
                 const Vector& x, long /*evaluations*/, unsigned /*seed*/) {
  return {.x = x, .value = f(x), .evaluations = 1, .sentence = "perp was built without NLopt: no search"};
}
#endif

}  // namespace perp
