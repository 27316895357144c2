#include "perp/solve/friction_solver.hpp"

#include <cmath>
#include <optional>

#include "perp/core/errors.hpp"
#include "solve/friction/certificate.hpp"
#include "solve/friction/friction_chain.hpp"
#include "solve/friction/friction_islands.hpp"
#include "solve/friction/global_form.hpp"
#include "solve/friction/minimum_norm.hpp"

namespace perp {
namespace {

double pass_error(const FrictionResidual& residuals) {
  return std::max(residuals.relative, 0.01 * (residuals.absolute + residuals.round_off));
}

// whether a solution exists is judged at a mark of its own: what passes a loose tolerance need not lie near one
constexpr double exists = 1e-10;

/// The interior-point method from several starts.
template <int R>
void interior_point_rounds(Chain<R>& chain) {
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

/// The chain from top to bottom, each stage where those before it missed the tolerance; a problem that falls apart goes on island by island,
/// each through a chain of its own.
template <int R>
void run_chain(Chain<R>& chain, const ContactSystem<R>& system, const FrictionProblem& problem,
               const FrictionOptions& options, Budget& budget, Vector& certificate) {
  chain.sweeps_first();
  if (options.start.size() > 0) chain.sweep_start();
  if (!chain.done()) chain.newton_stage(25);
  chain.sweeps_again();
  if (!chain.done()) {
    const auto islands = friction_islands(problem);
    if (!islands.empty()) {
      FrictionSolution apart = solve_apart(islands, options, problem.rows(), budget);
      chain.offer(apart.stage, system.scaled_reaction(apart.r, problem.offsets()));
      certificate = std::move(apart.certificate);
      return;
    }
    interior_point_rounds(chain);
  }
  if (!(chain.best.error <= std::min(options.tolerance, exists)))
    certificate = infeasibility_certificate(problem, system);
  if (certificate.size() > 0) return;
  constexpr int few = 60;  // contacts up to which Ipopt's dense W and thousands of sweeps are affordable
  proximal_rounds(chain, system.n);
  if (!chain.done()) chain.gauss_seidel_stage(system.n <= few ? 2000 : 300);
  if (!chain.done() && system.n <= few && options.use_ipopt && has_ipopt()) chain.ipopt_stage();
}

/// One method alone.
template <int R>
void run_method(Chain<R>& chain, FrictionMethod method) {
  switch (method) {
    case FrictionMethod::Newton:
      return chain.newton_stage(200);
    case FrictionMethod::InteriorPoint:
      return chain.interior_point_stage(FrictionStage::InteriorPoint, {});
    case FrictionMethod::Proximal:
      return chain.proximal_stage({.most = 300});
    case FrictionMethod::GaussSeidel:
      return chain.gauss_seidel_stage(2000);
    case FrictionMethod::Ipopt:
      return chain.ipopt_stage();
    case FrictionMethod::Chain:
      return;
  }
}

/// Velocities and residuals of s.r.
template <int R>
void finish(const FrictionProblem& problem, const ContactSystem<R>& system,
            const std::optional<MassResponse>& response, FrictionSolution& s) {
  if (response) {
    response->velocity(problem.H.times(s.r) + problem.f, s.v, s.lambda);
    s.u = problem.H.to_sparse().transpose() * s.v + problem.w;
  } else {
    s.u = problem.W.times(s.r) + problem.q;
  }
  s.residuals = friction_residual(problem, system, s.r, s.u);
}

/// What the residual says of the answer, and the certificate of existence.
template <int R>
void judge(const FrictionProblem& problem, ContactSystem<R>& system, double tolerance, FrictionSolution& s) {
  s.residual = s.residuals.relative;
  const double error = pass_error(s.residuals);
  if (error <= tolerance) s.status = FrictionStatus::Solved;
  if (error <= std::min(tolerance, exists)) {
    s.existence = FrictionExistence::Exists;
    s.certificate.resize(0);
  } else if (s.certificate.size() > 0) {
    s.status = FrictionStatus::NoSolution;
    s.existence = FrictionExistence::None;
  } else {
    s.certificate = existence_certificate(problem, system);
    if (s.certificate.size() > 0) s.existence = FrictionExistence::Exists;
  }
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
  if (options.method == FrictionMethod::Chain) {
    run_chain(chain, system, problem, options, budget, solution.certificate);
  } else {
    run_method(chain, options.method);
    if (!(chain.best.error <= std::min(options.tolerance, exists)))
      solution.certificate = infeasibility_certificate(problem, system);
  }

  solution.r = system.reaction(chain.best.r, offsets);
  solution.stage = chain.stage;
  solution.iterations = budget.iterations;
  finish(problem, system, response, solution);
  if (options.reactions == Reactions::MinimumNorm && chain.solved() && problem.blocks() > 0) {
    const Matrix W = to_local(problem).W.to_dense();
    if (const auto shortest = minimum_norm_reactions(problem, W, solution.r, solution.u)) {
      FrictionSolution other = solution;
      other.r = *shortest;
      finish(problem, system, response, other);
      if (pass_error(other.residuals) <= options.tolerance) solution = std::move(other);
    }
  }
  judge(problem, system, options.tolerance, solution);
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
