#include "perp/solve/friction_solver.hpp"

#include <cmath>
#include <optional>

#include "perp/core/errors.hpp"
#include "solve/friction/certificate.hpp"
#include "solve/friction/friction_islands.hpp"
#include "solve/friction/friction_stages.hpp"
#include "solve/friction/global_form.hpp"
#include "solve/friction/ipopt_stage.hpp"
#include "solve/friction/minimum_norm.hpp"

namespace perp {
namespace {

double pass_error(const FrictionResidual& residuals) {
  return std::max(residuals.relative, 0.01 * (residuals.absolute + residuals.round_off));
}

/// The chain over one scaled problem. `best` only ever improves.
template <int R>
class Chain {
 public:
  Chain(const ContactSystem<R>& system, const FrictionOptions& options, Budget& budget)
      : system_(system), options_(options), budget_(budget) {}

  FrictionStage stage = FrictionStage::None;
  Iterate<R> best;

  bool solved() const { return best.error <= options_.tolerance; }
  bool done() const { return solved() || budget_.spent(); }

  void start(Columns<R> r) {
    best.r = std::move(r);
    evaluate(system_, best);
  }

  /// Newton from the best point.
  void newton_stage(int most) {
    attempt(
        FrictionStage::Newton,
        [&](Iterate<R>& point) {
          newton_from(point, {.most = most});
          sharpen(point);
        },
        best);
  }

  /// A few sweeps set the contacts' modes right where the start is another problem's answer; not counted.
  void sweep_start() {
    if (done()) return;
    constexpr int sweeps = 3;
    Budget own;
    Iterate<R> point = best;
    point.error = infinity;  // take the sweeps' end, better or not: Newton is what it is for
    gauss_seidel(system_, sweeps, options_.tolerance, own, point);
    if (!std::isfinite(point.error)) return;
    attempt(
        FrictionStage::Newton,
        [&](Iterate<R>& x) {
          newton_from(x, {.most = 12});
          if (x.error > options_.tolerance) newton_from(x, {.most = 25, .least_regularisation = 1e-6});
        },
        point);
  }

  /// Sweeps first, as long as they pay. Newton's method takes more than three iterations, but a multiplication in its blocks costs less
  /// than one in a sweep.
  void sweeps_first() {
    constexpr int few = 30;          // contacts: of fewer, iterations cost no more than sweeps
    constexpr double by_newton = 3;  // iterations
    if (done() || system_.n < few) return;
    attempt(
        FrictionStage::GaussSeidel,
        [&](Iterate<R>& point) {
          sweeps_while_they_pay(system_, by_newton, options_.tolerance, budget_, point);
        },
        best);
  }

  /// Where Newton stalled: sweeps as long as they pay beside a homotopy, then Newton once more.
  void sweeps_again() {
    constexpr int few = 30;             // contacts
    constexpr double by_homotopy = 40;  // iterations
    if (done() || system_.n < few) return;
    attempt(
        FrictionStage::GaussSeidel,
        [&](Iterate<R>& point) {
          const double before = point.error;
          sweeps_while_they_pay(system_, by_homotopy, options_.tolerance, budget_, point);
          if (point.error < before && point.error > options_.tolerance) newton_from(point, {.most = 25});
          sharpen(point);
        },
        best);
  }

  /// One interior-point run, then the polish from its best point.
  void interior_point_stage(FrictionStage name, const InteriorPointOptions& interior) {
    Iterate<R> point;
    point.r = Columns<R>::Zero(R, system_.n);
    evaluate(system_, point);
    attempt(
        name,
        [&](Iterate<R>& x) {
          interior_point(system_, interior, options_.tolerance, budget_, x);
          polish(x);
        },
        point);
  }

  void proximal_stage(const ProximalOptions& proximal) {
    Iterate<R> point;
    point.r = Columns<R>::Zero(R, system_.n);
    evaluate(system_, point);
    attempt(
        FrictionStage::Proximal,
        [&](Iterate<R>& x) {
          proximal_point(system_, proximal, options_.tolerance, budget_, x);
          polish(x);
        },
        point);
  }

  /// Takes an answer found elsewhere if it is better.
  void offer(FrictionStage name, Columns<R> r) {
    Iterate<R> point;
    point.r = std::move(r);
    evaluate(system_, point);
    attempt(
        name, [&](Iterate<R>& x) { sharpen(x); }, point);
  }

  void gauss_seidel_stage(int sweeps) {
    attempt(
        FrictionStage::GaussSeidel,
        [&](Iterate<R>& point) {
          gauss_seidel(system_, sweeps, options_.tolerance, budget_, point);
          polish(point);
        },
        best);
  }

  void ipopt_stage() {
    for (const double start : {0.1, 1.0, 0.01}) {
      if (done()) return;
      Iterate<R> point;
      point.r = Columns<R>::Zero(R, system_.n);
      evaluate(system_, point);
      attempt(
          FrictionStage::Ipopt,
          [&](Iterate<R>& x) {
            solve_by_ipopt(system_, start, budget_, x);
            polish(x);
          },
          point);
    }
  }

 private:
  template <class Method>
  void attempt(FrictionStage name, Method&& method, Iterate<R> point) {
    const double before = best.error;
    const int most = budget_.most;
    if (options_.stage_iterations > 0 && name != FrictionStage::Ipopt) {
      const int own = budget_.iterations + options_.stage_iterations;
      budget_.most = most > 0 ? std::min(most, own) : own;
    }
    method(point);
    budget_.most = most;
    if (!(point.error < before)) return;
    best = std::move(point);
    stage = name;
  }

  void newton_from(Iterate<R>& point, const NewtonOptions& newton_options) {
    newton(system_, newton_options, options_.tolerance, budget_, point);
  }

  /// A few steps towards round-off where redundant contacts made Newton stall below the tolerance.
  void sharpen(Iterate<R>& point) {
    constexpr double round_off = 1e-13;
    if (point.error <= options_.tolerance && point.error > round_off) newton_from(point, {.most = 5});
  }

  /// Four Newton methods in turn, until one reaches the tolerance.
  void polish(Iterate<R>& point) {
    const auto passed = [&] { return point.error <= options_.tolerance; };
    newton_from(point, {.most = 30});
    if (!passed()) newton_from(point, {.most = 30, .fischer_burmeister = true});
    if (!passed()) newton_from(point, {.most = 30, .rho = 0.1});
    if (!passed()) newton_from(point, {.most = 30, .rho = 10});
    sharpen(point);
  }

  const ContactSystem<R>& system_;
  const FrictionOptions& options_;
  Budget& budget_;
};

template <int R>
void start_chain(Chain<R>& chain, const FrictionOptions& options) {
  chain.sweeps_first();
  if (options.start.size() > 0) chain.sweep_start();
  if (!chain.done()) chain.newton_stage(25);
  chain.sweeps_again();
}

template <int R>
void run_chain(Chain<R>& chain) {
  chain.interior_point_stage(FrictionStage::InteriorPoint, {});
  constexpr InteriorPointOptions starts[] = {{.start = 1, .damping = 0.9},
                                             {.start = 0.1, .damping = 0.9},
                                             {.start = 10, .damping = 0.5},
                                             {.start = 100, .damping = 0.9},
                                             {.start = 1},
                                             {.start = 1e3},
                                             {.start = 1, .damping = 0.5},
                                             {.start = 1e5},
                                             {.most = 150, .start = 100, .damping = 0.5},
                                             {.most = 150, .start = 1, .damping = 0.7}};
  for (const InteriorPointOptions& start : starts) {
    if (chain.done()) return;
    chain.interior_point_stage(FrictionStage::Restart, start);
  }
}

/// Proximal point from zero in several manners: what one does not come to, the next mostly does.
template <int R>
void proximal_rounds(Chain<R>& chain, int n) {
  const int most = std::min(200, 4 * n);  // a small problem is soon at its end
  const ProximalOptions rounds[] = {{.most = most},
                                    {.most = 2 * most, .alpha = 1, .sweeps = 0},
                                    {.most = most, .alpha = 0.1, .newton = 25, .sweeps = 30},
                                    {.most = 2 * most, .alpha = 1e-3, .newton = 25, .sweeps = 300}};
  for (const ProximalOptions& round : rounds)
    if (!chain.done()) chain.proximal_stage(round);
}

/// Solves each island by itself.
FrictionSolution solve_apart(const std::vector<FrictionIsland>& islands, const FrictionOptions& options,
                             Eigen::Index rows, Budget& budget) {
  FrictionSolution whole;
  whole.r.setZero(rows);
  for (const FrictionIsland& island : islands) {
    FrictionOptions own = options;
    own.tolerance = 0.5 * options.tolerance;  // the parts' misses add up
    own.reactions = Reactions::Any;
    own.time_limit = budget.seconds_left();
    if (budget.most > 0) own.max_iterations = std::max(1, budget.most - budget.iterations);
    if (options.start.size() > 0) own.start = options.start(island.rows);
    const FrictionSolution part = solve_friction(island.problem, own);
    budget.iterations += part.iterations;
    whole.stage = std::max(whole.stage, part.stage);
    whole.r(island.rows) = part.r;
    if (part.status != FrictionStatus::NoSolution || whole.certificate.size() > 0) continue;
    whole.certificate.setZero(rows);
    whole.certificate(island.rows) = part.certificate;
  }
  return whole;
}

template <int R>
FrictionSolution solve_in_columns(const FrictionProblem& problem, const FrictionOptions& options) {
  std::optional<MassResponse> response;
  if (problem.is_global()) response.emplace(problem);
  ContactSystem<R> system = response ? contact_system<R>(problem, *response) : contact_system<R>(problem);
  const std::vector<Eigen::Index> offsets = problem.offsets();

  Budget budget;
  budget.most = options.max_iterations;
  budget.time_limit = options.time_limit;

  Chain<R> chain(system, options, budget);
  chain.start(options.start.size() > 0 ? system.scaled_reaction(options.start, offsets)
                                       : Columns<R>(Columns<R>::Zero(R, system.n)));
  FrictionSolution solution;
  std::vector<FrictionIsland> islands;
  switch (options.method) {
    case FrictionMethod::Newton:
      chain.newton_stage(200);
      break;
    case FrictionMethod::InteriorPoint:
      chain.interior_point_stage(FrictionStage::InteriorPoint, {});
      break;
    case FrictionMethod::Proximal:
      chain.proximal_stage({.most = 300});
      break;
    case FrictionMethod::GaussSeidel:
      chain.gauss_seidel_stage(2000);
      break;
    case FrictionMethod::Ipopt:
      chain.ipopt_stage();
      break;
    case FrictionMethod::Chain:
      start_chain(chain, options);
      if (chain.done()) break;
      islands = friction_islands(problem);
      if (islands.empty()) {
        run_chain(chain);
      } else {
        FrictionSolution apart = solve_apart(islands, options, problem.rows(), budget);
        chain.offer(apart.stage, system.scaled_reaction(apart.r, offsets));
        solution.certificate = std::move(apart.certificate);
      }
      break;
  }
  // whether a solution exists is judged at a mark of its own: what passes a loose tolerance need not lie near one
  constexpr double exists = 1e-10;
  if (!(chain.best.error <= std::min(options.tolerance, exists)) && islands.empty())
    solution.certificate = infeasibility_certificate(problem, system);
  if (options.method == FrictionMethod::Chain && islands.empty() && solution.certificate.size() == 0) {
    constexpr int few = 60;  // contacts up to which Ipopt's dense W and thousands of sweeps are affordable
    proximal_rounds(chain, system.n);
    if (!chain.done()) chain.gauss_seidel_stage(system.n <= few ? 2000 : 300);
    if (!chain.done() && system.n <= few && options.use_ipopt && has_ipopt()) chain.ipopt_stage();
  }

  solution.r = system.reaction(chain.best.r, offsets);
  solution.stage = chain.stage;
  solution.iterations = budget.iterations;
  const auto finish = [&](FrictionSolution& s) {
    if (response) {
      response->velocity(problem.H.times(s.r) + problem.f, s.v, s.lambda);
      s.u = problem.H.to_sparse().transpose() * s.v + problem.w;
    } else {
      s.u = problem.W.times(s.r) + problem.q;
    }
    s.residuals = friction_residual(problem, system, s.r, s.u);
  };
  finish(solution);
  if (options.reactions == Reactions::MinimumNorm && chain.solved() && problem.blocks() > 0) {
    const Matrix W = to_local(problem).W.to_dense();
    if (const auto shortest = minimum_norm_reactions(problem, W, solution.r, solution.u)) {
      FrictionSolution other = solution;
      other.r = *shortest;
      finish(other);
      if (pass_error(other.residuals) <= options.tolerance) solution = std::move(other);
    }
  }
  solution.residual = solution.residuals.relative;
  const double error = pass_error(solution.residuals);
  if (error <= options.tolerance) solution.status = FrictionStatus::Solved;
  if (error <= std::min(options.tolerance, exists)) {
    solution.existence = FrictionExistence::Exists;
    solution.certificate.resize(0);
  } else if (solution.certificate.size() > 0) {
    solution.status = FrictionStatus::NoSolution;
    solution.existence = FrictionExistence::None;
  } else {
    solution.certificate = existence_certificate(problem, system);
    if (solution.certificate.size() > 0) solution.existence = FrictionExistence::Exists;
  }
  return solution;
}

}  // namespace

FrictionSolution solve_friction(const FrictionProblem& problem, const FrictionOptions& options) {
  check(problem);
  if (!(options.tolerance > 0))
    refuse("solve_friction", "tolerance", options.tolerance, "a number > 0 is needed");
  if (options.start.size() > 0 && (options.start.size() != problem.rows() || !options.start.allFinite()))
    refuse("solve_friction", "start", "not finite or of another size", "one finite number a row is needed");
  return column_rows(problem) == 3 ? solve_in_columns<3>(problem, options)
                                   : solve_in_columns<6>(problem, options);
}

std::string_view to_string(FrictionStatus status) {
  switch (status) {
    case FrictionStatus::Solved:
      return "solved";
    case FrictionStatus::NoSolution:
      return "no-solution";
    case FrictionStatus::BestFound:
      return "best-found";
  }
  return "";
}

std::string_view to_string(FrictionExistence existence) {
  switch (existence) {
    case FrictionExistence::Exists:
      return "exists";
    case FrictionExistence::None:
      return "none";
    case FrictionExistence::Unknown:
      return "unknown";
  }
  return "";
}

std::string_view to_string(FrictionStage stage) {
  switch (stage) {
    case FrictionStage::None:
      return "none";
    case FrictionStage::Newton:
      return "newton";
    case FrictionStage::InteriorPoint:
      return "interior-point";
    case FrictionStage::Restart:
      return "restart";
    case FrictionStage::Proximal:
      return "proximal";
    case FrictionStage::GaussSeidel:
      return "gauss-seidel";
    case FrictionStage::Ipopt:
      return "ipopt";
  }
  return "";
}

}  // namespace perp
