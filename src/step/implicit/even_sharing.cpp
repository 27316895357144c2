// Redundant reactions in Newton's method: of all that make up a step, those of contacts and joints that give a little, all alike, as that
// goes to nothing (doc/methods/redundant.md). With
//   u_i + eps c_i p_i  in the place of u_i
// eps falls with the residual; when it is slight, linear steps lead to the limit itself, in the modes of the guess.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "instant/compliance.hpp"
#include "step/certificate/closeness.hpp"
#include "step/implicit/nonsmooth_newton.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
namespace {

double compliance(const Model& model, const Instant& instant, const Reaction& r) {
  switch (r.of) {
    case Reaction::Of::Contact: {
      const int i = instant.contact_of_point[at(r.source)];
      return i < 0 ? 1 : compliance_of(model, instant.contacts[at(i)]);
    }
    case Reaction::Of::Moments: {
      const int i = instant.contact_of_point[at(r.source)];
      return i < 0 ? 1 : moments_compliance_of(model, instant.contacts[at(i)]) * r.lever * r.lever;
    }
    case Reaction::Of::JointRow:
      return compliance_of(model, instant.joint_rows[at(r.source)]);
    case Reaction::Of::JointFriction:
      return compliance_of(model, instant.joint_frictions[at(r.source)]);
  }
  return 1;
}

constexpr int most_more = 4;  // iterations of an island that passes, to even it out

}  // namespace

/// Islands whose bodies and reactions close loops, with their reactions' compliances.
void NonsmoothNewton::find_loops(const Model& model, const std::vector<Reaction>& reactions) {
  loops_.begin(model);
  left_open_.assign(reactions.size(), 0);
  bool any = false;
  int last = -1;  // joint: its rows stand together
  for (const Reaction& r : reactions) {
    if (r.of == Reaction::Of::JointFriction || r.of == Reaction::Of::Moments)
      continue;  // beside its joint's rows, its contact's
    if (r.of == Reaction::Of::JointRow) {
      const int joint = instant_->joint_rows[at(r.source)].joint;
      if (joint == last) continue;
      last = joint;
    }
    if (!loops_.close(model, r.W.a, r.W.b)) continue;
    islands_[island_number(r)].loops = any = true;
  }
  if (!any) return;
  compliance_.resize(reactions.size());
  std::vector<int> count(islands_.size(), 0);
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    Island& island = islands_[island_number(r)];
    if (!island.loops) continue;
    compliance_[i] = compliance(model, *instant_, r);
    island.give += std::log(r.w / compliance_[i]);
    ++count[island_number(r)];
  }
  for (std::size_t i = 0; i < islands_.size(); ++i) {
    if (!islands_[i].loops) continue;
    islands_[i].give = std::exp(islands_[i].give / count[i]);
    islands_[i].uneven = most_more;
  }
}

/// The linear step's equation of reaction i, whose row gives; `eps` is what its island's residual asks for [-].
void NonsmoothNewton::give_evenly(std::size_t i, const std::vector<Reaction>& reactions, double eps) {
  const Reaction& r = reactions[i];
  constexpr double slight =
      1e-7;  // of what impulses do to their own rows: as far from 1 as from rounding, by digits
  constexpr double most = 1e-2;  // of that, of one row: a step with more leads nowhere
  Island& island = islands_[island_number(r)];
  LinearizedReaction& row = rows_[i];
  // one that rows which give leave open touches, in the limit, as one that is to close does
  left_open_[i] = static_cast<char>(r.of == Reaction::Of::Contact && row.P.isZero(0));
  island.limit = row.even = eps <= slight;
  row.eps = row.rho * std::max(eps, slight) * island.give * compliance_[i] / r.w;
  if (row.even) return;
  row.eps = std::min(row.eps, most);
  if (row.whole != nullptr) return;  // with its moments
  if (r.of != Reaction::Of::Moments) {
    row.F += row.eps * (row.P * r.p);
    return;
  }
  LinearizedReaction& contact = rows_[i - 1];
  const Vector6 given = *contact.whole * whole(contact.eps * reactions[i - 1].p, row.eps * r.p);
  contact.F += given.head<3>();
  row.F += given.tail<3>();
}

bool NonsmoothNewton::has_loops() const {
  return std::any_of(islands_.begin(), islands_.end(), [](const Island& i) { return i.loops; });
}

/// Islands as they are before the first iteration, with linear steps to the limit or without.
void NonsmoothNewton::start_again(bool even) {
  even_ = even;
  for (Island& island : islands_) {
    island.map = island.stalled = 0;
    island.best = infinity;
    island.best_good = false;
    island.limit = false;
    island.uneven = even && island.loops ? most_more : 0;
  }
}

/// From a guess, without the rule.
bool NonsmoothNewton::newton_without_give(const Model& model, StepProblem& problem, const Options& options,
                                          const Vector& guess, const std::vector<Vector3>& p, Vector& nu,
                                          std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  start_again(false);
  return take(model, problem, options, guess, p, nu, reactions, outcome) &&
         newton(model, problem, options, nu, reactions, outcome);
}

bool NonsmoothNewton::take(const Model& model, StepProblem& problem, const Options& options,
                           const Vector& guess, const std::vector<Vector3>& p, Vector& nu,
                           std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  nu = guess;
  for (std::size_t i = 0; i < reactions.size(); ++i) reactions[i].p = p[i];
  return evaluate(model, problem, options, nu, reactions, outcome);
}

/// Newton's method with linear steps to the limit; where these let go of a contact that the guess (p) loads, without them, and what that finds
/// stands if it keeps the load: what is jammed stays so, though rows that give would have lost theirs.
bool NonsmoothNewton::newton_in_loops(const Model& model, StepProblem& problem, const Options& options,
                                      const std::vector<Vector3>& p, Vector& nu,
                                      std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  constexpr double rest = 1e-2;  // of a load that is lost; jammed ones fall by more, others in a step by less
  const auto lets_go = [&] {
    for (std::size_t i = 0; i < reactions.size(); ++i) {
      const Reaction& r = reactions[i];
      if (r.of == Reaction::Of::Contact && p[i].x() > 0 && r.p.x() < rest * p[i].x() &&
          closeness::approaches(-std::max(r.u.x(), r.u.tail<2>().norm()), outcome.residuals.speed))
        return true;
    }
    return false;
  };
  nu_guess_ = nu;
  start_again(true);
  const bool found = newton(model, problem, options, nu, reactions, outcome);
  if (!found || !has_loops() || !lets_go()) return found;
  nu_limit_ = nu;
  limit_.resize(reactions.size());
  for (std::size_t i = 0; i < reactions.size(); ++i) limit_[i] = reactions[i].p;
  if (newton_without_give(model, problem, options, nu_guess_, p, nu, reactions, outcome) && !lets_go())
    return true;
  start_again(true);
  return take(model, problem, options, nu_limit_, limit_, nu, reactions, outcome) && outcome.converged;
}

/// At an answer that was not found by Newton's method.
void NonsmoothNewton::take_even(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
                                std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  if (!has_loops()) return;
  const Vector answer = nu;
  const NewtonOutcome found = outcome;
  std::vector<Vector3> p;
  for (const Reaction& r : reactions) p.push_back(r.p);
  start_again(true);
  Options short_run = options;
  short_run.most = most_more;
  const bool still = newton(model, problem, short_run, nu, reactions, outcome);
  const int iterations = outcome.iterations;
  if (!still) {
    (void)take(model, problem, options, answer, p, nu, reactions, outcome);  // as it was found
    outcome = found;
  }
  outcome.iterations = iterations;
  outcome.history = found.history;
}

}  // namespace perp
