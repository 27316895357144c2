#include "step/implicit/nonsmooth_newton.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/solve/friction_solver.hpp"

namespace perp {
namespace {

constexpr int patience = 6;  // iterations without half the residual before the map changes

}  // namespace

BlockKind kind_of(Law law) {
  switch (law) {
    case Law::Planar:
      return BlockKind::Planar;
    case Law::Cone:
      return BlockKind::Cone;
    case Law::Interval:
      return BlockKind::Interval;
    default:
      return BlockKind::HalfLine;
  }
}

std::pair<int, int> rows_of(Law law) {
  switch (law) {
    case Law::Planar:
      return {0, 2};
    case Law::Cone:
      return {0, 3};
    case Law::Interval:
      return {1, 1};
    case Law::Moments:
      return {0, 3};
    default:
      return {0, 1};
  }
}

WrenchMap<3> three_columns(const WrenchMap<1>& W, int column) {
  WrenchMap<3> out;
  out.a = W.a, out.b = W.b;
  out.va = W.va, out.na = W.na;
  out.vb = W.vb, out.nb = W.nb;
  out.A.col(column) = W.A;
  out.B.col(column) = W.B;
  return out;
}

double inverse_mass(const Model& model, const Instant& instant, const WrenchMap<3>& W, Law law) {
  const auto [first, rows] = rows_of(law);
  double trace = 0;
  Eigen::Matrix<double, 6, 1> y;
  for (int j = first; j < first + rows; ++j) {
    if (W.na > 0) {
      solve_mass(model, instant, W.a, W.A.col(j).data(), y.data());
      trace += W.A.col(j).head(W.na).dot(y.head(W.na));
    }
    if (W.nb > 0) {
      solve_mass(model, instant, W.b, W.B.col(j).data(), y.data());
      trace += W.B.col(j).head(W.nb).dot(y.head(W.nb));
    }
  }
  return trace > 0 ? trace / rows : 1;
}

std::size_t NonsmoothNewton::island_number(const Reaction& r) const {
  return at(island_[at(r.W.nb > 0 ? r.W.b : r.W.a)]);
}

int NonsmoothNewton::root(int body) {
  while (parent_[at(body)] != body) body = parent_[at(body)] = parent_[at(parent_[at(body)])];
  return body;
}

void NonsmoothNewton::find_islands(const Model& model, const Options& options,
                                   const std::vector<Reaction>& reactions) {
  const int n = static_cast<int>(model.bodies().size());
  parent_.resize(at(n));
  for (int i = 0; i < n; ++i) parent_[at(i)] = i;
  const auto tie = [&](int a, int b) {
    if (model.bodies()[at(a)].nv > 0 && model.bodies()[at(b)].nv > 0) parent_[at(root(a))] = root(b);
  };
  for (const Reaction& r : reactions) tie(r.W.a, r.W.b);
  for (const Coupling& c : K_) tie(c.row, c.column);
  island_.assign(at(n), -1);
  int count = 0;
  for (int i = 0; i < n; ++i) {
    if (model.bodies()[at(i)].nv == 0) continue;
    int& of_root = island_[at(root(i))];
    if (of_root < 0) of_root = count++;
    island_[at(i)] = of_root;
  }
  islands_.assign(at(count), {});
  radius_.resize(at(n));
  for (int i = 0; i < n; ++i) {
    if (model.bodies()[at(i)].nv == 0) continue;
    const Body& b = model.bodies()[at(i)];
    Island& island = islands_[at(island_[at(i)])];
    island.speed = std::max(island.speed, options.speeds.of_body(at(i)));
    radius_[at(i)] = b.mass > 0 && b.kind != BodyKind::Generalized ? std::sqrt(b.J.trace() / b.mass) : 1;
  }
  for (const Reaction& r : reactions) {
    Island& island = islands_[island_number(r)];
    island.speed = std::max(island.speed, r.speed);
    island.rounding = std::max(island.rounding, r.rounding);
  }
}

bool NonsmoothNewton::evaluate(const Model& model, StepProblem& problem, const Options& options,
                               const Vector& nu, std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  if (!problem.evaluate(nu, reactions, R_)) return outcome.converged = false;
  for (const Reaction& r : reactions) r.W.add_impulse(-r.p, R_);
  return judge(model, options, nu, reactions, outcome);
}

/// eps of each reaction: it falls with its island's residual, relative to the speeds there, to rounding.
void NonsmoothNewton::regularise(const std::vector<Reaction>& reactions) {
  constexpr double least = 1e-14, most = 1e-2, part = 1e-3;
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Island& island = islands_[island_number(reactions[i])];
    const double eps = part * island.residuals.largest() / std::max(island.size, 1e-300);
    rows_[i].even = false;
    if (even_ && island.loops && !island.polished())
      give_evenly(i, reactions, std::min(eps, most));
    else
      rows_[i].eps = std::clamp(eps, least, most);
  }
}

/// nu_ + t dnu, p_ + t dp with t halved in each island until its merit is low enough.
bool NonsmoothNewton::search(const Model& model, StepProblem& problem, const Options& options,
                             std::size_t iteration, Vector& nu, std::vector<Reaction>& reactions,
                             NewtonOutcome& outcome) {
  constexpr double sufficient = 1e-4;  // Armijo's part of the predicted decrease
  constexpr int most_halvings = 10;
  nu_ = nu;
  p_.resize(reactions.size());
  for (std::size_t i = 0; i < reactions.size(); ++i) p_[i] = reactions[i].p;
  for (Island& island : islands_) {
    island.merits[iteration % memory] = island.merit;
    if (iteration == 0) island.merits.fill(island.merit);
    island.t = island.done() ? 0 : 1;
  }
  for (int halvings = 0;; ++halvings) {
    for (std::size_t i = 0; i < model.bodies().size(); ++i) {
      const Body& b = model.bodies()[i];
      if (b.nv > 0)
        nu.segment(b.v0, b.nv) =
            nu_.segment(b.v0, b.nv) + islands_[at(island_[i])].t * linearized_.dnu.segment(b.v0, b.nv);
    }
    for (std::size_t i = 0; i < reactions.size(); ++i) {
      Reaction& r = reactions[i];
      r.p = p_[i] + islands_[island_number(r)].t * linearized_.dp[i];
    }
    const bool finite = evaluate(model, problem, options, nu, reactions, outcome);
    bool enough = true;
    for (Island& island : islands_) {
      const double reference = *std::max_element(island.merits.begin(), island.merits.end());
      if (finite && (island.near || island.merit <= (1 - 2 * sufficient * island.t) * reference)) continue;
      enough = false;
      island.t /= 2;
    }
    if (enough || (finite && halvings == most_halvings)) return true;
    if (halvings == most_halvings) return false;
  }
}

/// Keeps the guesses of islands that have never been better.
void NonsmoothNewton::keep_best(const Model& model, const Vector& nu,
                                const std::vector<Reaction>& reactions) {
  improved_.assign(islands_.size(), 0);
  for (std::size_t i = 0; i < islands_.size(); ++i) {
    Island& island = islands_[i];
    const double now = island.residuals.largest();
    const bool evened = island.near && island.uneven > 0 && island.limit && island.t == 1;
    island.stalled = now < 0.5 * island.best ? 0 : island.stalled + 1;
    island.at_best = evened || (island.good != island.best_good ? island.good : now <= island.best);
    improved_[i] = static_cast<char>(island.at_best);
    if (island.at_best) island.best = now, island.best_good = island.good;
    if (island.near && island.uneven > 0) island.uneven = evened ? 0 : island.uneven - 1;
  }
  nu_best_.resize(nu.size());
  p_best_.resize(reactions.size());
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv > 0 && improved_[at(island_[i])] != 0) nu_best_.segment(b.v0, b.nv) = nu.segment(b.v0, b.nv);
  }
  for (std::size_t i = 0; i < reactions.size(); ++i)
    if (improved_[island_number(reactions[i])] != 0) p_best_[i] = reactions[i].p;
}

/// Takes islands that stall back to their best guess, with the next map; true if there were any.
bool NonsmoothNewton::change_maps(const Model& model, Vector& nu, std::vector<Reaction>& reactions) {
  improved_.assign(islands_.size(), 0);
  bool any = false;
  for (std::size_t i = 0; i < islands_.size(); ++i) {
    Island& island = islands_[i];
    if (island.near || island.stalled < patience) continue;
    island.map = (island.map + 1) % maps;
    island.stalled = 0;
    island.merits.fill(infinity);
    improved_[i] = 1;
    any = true;
  }
  if (!any) return false;
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv > 0 && improved_[at(island_[i])] != 0) nu.segment(b.v0, b.nv) = nu_best_.segment(b.v0, b.nv);
  }
  for (std::size_t i = 0; i < reactions.size(); ++i)
    if (improved_[island_number(reactions[i])] != 0) reactions[i].p = p_best_[i];
  return true;
}

bool NonsmoothNewton::newton(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
                             std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  outcome.history.clear();
  outcome.history.push_back(outcome.residuals.largest());
  keep_best(model, nu, reactions);
  for (int k = 0; k < options.most; ++k) {
    // an island at rounding is done, and one that is good but no longer gets better
    if (std::all_of(islands_.begin(), islands_.end(), [](const Island& i) { return i.done(); })) break;
    if (k > 0 || outcome.iterations > 0) problem.differentiate(reactions, K_);
    regularise(reactions);
    const bool creeps = std::any_of(islands_.begin(), islands_.end(), [](const Island& i) {
      return i.polished() || (!i.near && i.stalled > 1);
    });
    if (!linearized_.solve(model, *instant_, K_, reactions, rows_, R_, creeps) ||
        !search(model, problem, options, static_cast<std::size_t>(k), nu, reactions, outcome))
      break;
    ++outcome.iterations;
    outcome.history.push_back(outcome.residuals.largest());
    keep_best(model, nu, reactions);
    if (change_maps(model, nu, reactions) && !evaluate(model, problem, options, nu, reactions, outcome))
      return false;
  }
  if (std::any_of(islands_.begin(), islands_.end(), [](const Island& i) { return !i.at_best; })) {
    nu = nu_best_;
    for (std::size_t i = 0; i < reactions.size(); ++i) reactions[i].p = p_best_[i];
    if (!evaluate(model, problem, options, nu, reactions, outcome)) return false;
  }
  return outcome.converged;
}

/// Evaluates the first guess. Where its merit is above the energy that leads there from the start's velocities, as with springs much stiffer
/// than the step, those are tried.
bool NonsmoothNewton::begin(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
                            std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  const bool finite = evaluate(model, problem, options, nu, reactions, outcome);
  if (!options.stiff) return finite;
  const auto merit = [&] {
    double sum = 0;
    for (const Island& island : islands_) sum += island.merit;
    return sum;
  };
  nu_ = nu - options.start->nu;
  multiply_mass(model, *instant_, nu_, terms_);
  const double guessed = merit();
  if (finite && !(guessed > nu_.dot(terms_))) return true;
  nu_ = nu;
  nu = options.start->nu;
  if (evaluate(model, problem, options, nu, reactions, outcome) && !(finite && merit() > guessed))
    return true;
  nu = nu_;
  return evaluate(model, problem, options, nu, reactions, outcome);
}

void NonsmoothNewton::solve(const Model& model, const Instant& instant, StepProblem& problem,
                            const Options& options, Vector& nu, std::vector<Reaction>& reactions,
                            NewtonOutcome& outcome) {
  instant_ = &instant;
  std::vector<double> history = std::move(outcome.history);
  outcome = {};
  outcome.history = std::move(history);
  for (Reaction& r : reactions) r.w = inverse_mass(model, instant, r.W, r.law);
  with_moments_.clear();
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    if (!reactions[i].has_moments) continue;
    reactions[i + 1].w = reactions[i].w;
    with_moments_.resize(reactions.size());
  }
  K_.clear();
  R_.resize(nu.size());
  left_open_.clear();
  find_islands(model, options, reactions);
  if (!begin(model, problem, options, nu, reactions, outcome)) return;
  const Vector start = nu;
  std::vector<Vector3> start_p(reactions.size());
  for (std::size_t i = 0; i < reactions.size(); ++i) start_p[i] = reactions[i].p;
  // a first guess at rounding needs no slopes
  if (!reactions.empty()) outcome.solver = "newton";
  if (std::all_of(islands_.begin(), islands_.end(), [](const Island& i) { return i.at_rounding(); })) {
    outcome.history.assign(1, outcome.residuals.largest());
    return;
  }
  // the couplings tie islands too: they are those of the first guess
  problem.differentiate(reactions, K_);
  find_islands(model, options, reactions);
  find_loops(model, reactions);
  if (!judge(model, options, nu, reactions, outcome)) return;
  if (newton_in_loops(model, problem, options, start_p, nu, reactions, outcome)) return;

  for (const bool ipopt : {false, true}) {
    if (ipopt && !has_ipopt()) break;
    if (!take(model, problem, options, start, start_p, nu, reactions, outcome)) return;
    if (josephy_newton(model, problem, options, ipopt, nu, reactions, outcome))
      return take_even(model, problem, options, nu, reactions, outcome);
  }
  if (has_loops())
    (void)newton_without_give(model, problem, options, start, start_p, nu, reactions,
                              outcome);  // or no answer
}

}  // namespace perp
