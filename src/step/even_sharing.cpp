// Redundant reactions of a step: those of contacts and joints that give a little, all alike, as that goes to nothing. At the answer
//   u_i + eps c_i p_i  in the place of u_i
// is solved to first order in eps, then once more with p_i - (the p_i found) in the place of p_i: its modes are those of rows that
// give, and nothing of the give is left (doc/methods/redundant.md).
#include <algorithm>
#include <cmath>

#include "instant/compliance.hpp"
#include "step/nonsmooth_newton.hpp"

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Of what an impulse does to its own row: far above rounding, so that shares have digits, and far below any margin of friction.
constexpr double slight = 1e-8;

enum class Mode { Open, Stick, Slip };

/// What a contact or a joint's friction does, by Alart and Curnier's z = p - u/w.
Mode mode_of(const Reaction& r, const Vector3& z) {
  if (r.law == Law::Equality) return Mode::Stick;
  if (r.law == Law::Interval) return std::abs(z.y()) <= r.mu ? Mode::Stick : Mode::Slip;
  if (!(z.x() > 0)) return Mode::Open;
  return r.law == Law::HalfLine || z.tail<2>().norm() <= r.mu * z.x() ? Mode::Stick : Mode::Slip;
}

double compliance(const Model& model, const Instant& instant, const Reaction& r) {
  switch (r.of) {
    case Reaction::Of::Contact: {
      const int i = instant.contact_of_point[at(r.source)];
      return i < 0 ? 1 : compliance_of(model, instant.contacts[at(i)]);
    }
    case Reaction::Of::JointRow:
      return compliance_of(model, instant.joint_rows[at(r.source)]);
    case Reaction::Of::JointFriction:
      return compliance_of(model, instant.joint_frictions[at(r.source)]);
  }
  return 1;
}

}  // namespace

/// Whether what acts, a joint or a loaded contact point an edge, closes a loop of bodies (what does not move by forces counts as
/// one): a tree of them is never redundant.
bool NonsmoothNewton::may_be_redundant(const Model& model, const std::vector<Reaction>& reactions) {
  for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = static_cast<int>(i);
  const auto node = [&](int body) { return root(model.bodies()[at(body)].nv > 0 ? body : 0); };
  int last_joint = -1;
  for (const Reaction& r : reactions) {
    if (r.of == Reaction::Of::JointFriction) continue;  // beside its joint's equations
    if (r.of == Reaction::Of::Contact && !(r.w * r.p.x() > r.u.x())) continue;
    if (r.of == Reaction::Of::JointRow) {
      const int joint = instant_->joint_rows[at(r.source)].joint;
      if (joint == last_joint) continue;
      last_joint = joint;
    }
    const int a = node(r.W.a), b = node(r.W.b);
    if (a == b) return true;
    parent_[at(a)] = b;
  }
  return false;
}

Vector3 NonsmoothNewton::give(const Reaction& r, std::size_t i) const {
  return gives_ ? Vector3(give_[i] * (r.p - reference_[i])) : Vector3(Vector3::Zero());
}

/// eps c of each reaction; eps is one number in an island.
void NonsmoothNewton::set_give(const Model& model, const std::vector<Reaction>& reactions) {
  std::vector<double> sum(islands_.size(), 0);
  std::vector<int> count(islands_.size(), 0);
  give_.resize(reactions.size());
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    give_[i] = compliance(model, *instant_, r);
    sum[island_number(r)] += std::log(r.w / give_[i]);
    ++count[island_number(r)];
  }
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const std::size_t island = island_number(reactions[i]);
    give_[i] *= slight * std::exp(sum[island] / count[island]);
  }
}

/// The linear step dnu_, dp_ to even shares in the modes of the answer evaluated last, `largest` its largest velocity w |dp|; false
/// if rows that give have other modes, or the system is singular.
bool NonsmoothNewton::even_step(const Model& model, std::vector<Reaction>& reactions, double& largest) {
  const std::size_t n = reactions.size();
  const Vector none = Vector::Zero(R_.size());
  for (std::size_t i = 0; i < n; ++i) {
    LinearizedReaction& row = rows_[i];
    row.rho = 1;
    row.eps = give_[i] / reactions[i].w;
    row.F = row.eps * (row.P * reactions[i].p);
  }
  if (!linearized_.solve(model, *instant_, K_, reactions, rows_, none)) return false;
  dnu_ = linearized_.dnu;
  dp_ = linearized_.dp;
  largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Reaction& r = reactions[i];
    const Vector3 p = r.p + dp_[i];
    Vector3 du = Vector3::Zero();
    for (int k = 0; k < r.W.na; ++k) du += r.G.col(k) * dnu_[r.W.va + k];
    for (int k = 0; k < r.W.nb; ++k) du += r.G.col(6 + k) * dnu_[r.W.vb + k];
    const Vector3 z = r.p - r.u / r.w, soft = p - (r.u + du + give_[i] * p) / r.w;
    if (mode_of(r, soft) != mode_of(r, z)) return false;
    largest = std::max(largest, r.w * dp_[i].cwiseAbs().maxCoeff());
    rows_[i].F = -rows_[i].eps * (rows_[i].P * p);
  }
  if (!linearized_.solve_again(model, *instant_, K_, reactions, rows_, none)) return false;
  dnu_ += linearized_.dnu;
  for (std::size_t i = 0; i < n; ++i) dp_[i] += linearized_.dp[i];
  return true;
}

/// Newton's method from a guess that is not the last one of a search.
bool NonsmoothNewton::solve_afresh(const Model& model, StepProblem& problem, const Options& options,
                                   Vector& nu, std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  for (Island& island : islands_) {
    island.map = island.stalled = 0;
    island.best = infinity;
  }
  ++outcome.iterations;  // with slopes of its own
  return evaluate(model, problem, options, nu, reactions, outcome) &&
         newton(model, problem, options, nu, reactions, outcome);
}

/// The equations with rows that give, then with what they give taken back.
bool NonsmoothNewton::soften(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
                             std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  constexpr int rounds = 3;
  reference_.assign(reactions.size(), Vector3::Zero());
  gives_ = true;
  bool found = true;
  for (int round = 0; found && round < rounds; ++round) {
    found = solve_afresh(model, problem, options, nu, reactions, outcome);
    for (std::size_t i = 0; i < reactions.size(); ++i) reference_[i] = reactions[i].p;
  }
  gives_ = false;
  return found && solve_afresh(model, problem, options, nu, reactions, outcome);
}

void NonsmoothNewton::take_even_share(const Model& model, StepProblem& problem, const Options& options,
                                      Vector& nu, std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  constexpr int most_rounds = 6;
  constexpr double enough = 1e-13;  // of the speeds: shares are those of the rule to rounding
  if (!may_be_redundant(model, reactions)) return;
  set_give(model, reactions);
  const std::vector<double> history = outcome.history;
  bool softened = false;
  for (int round = 0; round < most_rounds; ++round) {
    problem.differentiate(reactions, K_);
    double largest = 0;
    const bool same_modes = even_step(model, reactions, largest);
    if (same_modes && largest <= enough * outcome.residuals.speed) break;
    const Vector answer = nu;
    const NewtonOutcome good = outcome;
    std::vector<Vector3> p;
    for (const Reaction& r : reactions) p.push_back(r.p);
    bool found = same_modes || !softened;
    if (same_modes) {
      for (std::size_t i = 0; i < reactions.size(); ++i) reactions[i].p += dp_[i];
      nu += dnu_;
      found = solve_afresh(model, problem, options, nu, reactions, outcome);
    } else if (found) {
      found = soften(model, problem, options, nu, reactions, outcome);
      softened = true;
    }
    if (found) continue;
    nu = answer;  // without a limit that fits, the answer stands
    for (std::size_t i = 0; i < reactions.size(); ++i) reactions[i].p = p[i];
    (void)evaluate(model, problem, options, nu, reactions, outcome);
    outcome = good;
    break;
  }
  outcome.history = history;
}

}  // namespace perp
