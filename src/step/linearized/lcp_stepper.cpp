#include "perp/step/lcp_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/friction_polygon.hpp"
#include "step/certificate/step_gain.hpp"
#include "step/implicit/implicit_step.hpp"
#include "step/implicit/least_reactions.hpp"
#include "step/linearized/lcp_workspace.hpp"
#include "step/parts/free_rotation.hpp"
#include "step/parts/moment_laws.hpp"
#include "step/parts/stable_step.hpp"

namespace perp {
namespace {

/// Whether the linearised gap closes within h at the velocity without reactions. What touches to rounding of the step's `speed` counts:
/// joints of a stack at rest do not come and go.
bool closes(const ContactInstant& c, const Vector& nu_free, double h, double speed) {
  constexpr double rounding = 1e-9;  // of the way that a step at `speed` goes
  return c.psi_n + h * c.velocity(nu_free).x() <= rounding * h * speed;
}

}  // namespace

LcpStepper::LcpStepper(LcpStepperOptions options) : options_(options), work_(std::make_unique<Workspace>()) {
  work_->polygon = work_->step.polygon = friction_polygon(options.edges);
  work_->polytope = friction_polytope(options.edges);
  if (!(options.tolerance > 0)) refuse("LcpStepper", "tolerance", options.tolerance, "needs to be positive");
}
LcpStepper::~LcpStepper() = default;
const StepAnswer* LcpStepper::answer() const { return &work_->step; }
std::unique_ptr<Stepper> LcpStepper::anew() const { return std::make_unique<LcpStepper>(options_); }
LcpStepper::LcpStepper(LcpStepper&&) noexcept = default;
LcpStepper& LcpStepper::operator=(LcpStepper&&) noexcept = default;

/// nu_free, the seed's psi/h terms, and the contacts that these let close within the step.
void LcpStepper::begin(const Model& model, const State& x, const StepRequest& request, const Instant& s) {
  Workspace& w = *work_;
  w.load = s.k;
  implicit_gyroscopic(model, x, request.h, w.load);
  solve_mass(model, s, w.load, w.nu_free);
  w.nu_free = x.nu + request.h * w.nu_free;

  w.joint_bias.resize(static_cast<Eigen::Index>(s.joint_rows.size()));
  for (std::size_t i = 0; i < s.joint_rows.size(); ++i)
    w.joint_bias[static_cast<int>(i)] = s.joint_rows[i].psi_b / request.h + s.joint_rows[i].psi_b_t;

  const double speed = std::max(x.nu.lpNorm<Eigen::Infinity>(), w.nu_free.lpNorm<Eigen::Infinity>());
  w.active.clear();
  w.gap_term.resize(static_cast<Eigen::Index>(s.contacts.size()));
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    if (closes(s.contacts[i], w.nu_free, request.h, speed)) w.active.push_back(static_cast<int>(i));
    const double rate = std::max(s.contacts[i].psi_n / request.h, -request.max_correction_speed);
    w.gap_term[static_cast<int>(i)] = options_.anitescu_potra ? 0 : rate;
  }
}

/// Adds the contacts that the answer would let overlap; true if there were any.
bool LcpStepper::add_overlapping(const Instant& s, double h, const Answer& answer) {
  Workspace& w = *work_;
  const std::size_t before = w.active.size();
  auto next = w.active.begin();
  w.added.clear();
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const bool taken = next != w.active.end() && *next == static_cast<int>(i);
    if (taken) ++next;
    if (taken || s.contacts[i].psi_n / h + s.contacts[i].velocity(answer.nu).x() < 0)
      w.added.push_back(static_cast<int>(i));
  }
  std::swap(w.active, w.added);
  return w.active.size() > before;
}

/// Which contacts an impact changes, and into w.struck which bodies: those of the islands, over contacts that closed or touch, in which
/// one strikes or rebounds. Contacts of struck bodies that did not close have no part in it. False if there is no impact.
bool LcpStepper::find_impact(const Model& model, const State& x, const Instant& s, double h) {
  Workspace& w = *work_;
  const bool whole = whole_impacts();
  const auto closed = [&](int i) { return closeness::loaded(w.answer.p(0, i)); };
  const auto meets = [&](int i) {
    const ContactInstant& c = s.contacts[at(i)];
    return closed(i) &&
           (c.e * c.velocity(x.nu).x() < 0 || (whole && strikes(c, x, w.gained, h, w.answer.speed_scale)));
  };
  w.struck.clear();
  if (std::ranges::none_of(w.active, meets)) return false;

  // what touches takes part, though the position's problem may have opened it
  w.added.clear();
  for (int i = 0; i < static_cast<int>(s.contacts.size()); ++i)
    if (whole ? closed(i) || (touches(s.contacts[at(i)], h, w.answer.speed_scale) &&
                              !separates(s.contacts[at(i)], x, w.gained, w.answer.speed_scale))
              : std::ranges::binary_search(w.active, i))
      w.added.push_back(i);
  w.islands.find(model, s, w.added);
  w.struck.assign(model.bodies().size(), 0);
  for (const Island& island : w.islands.get())
    if (std::ranges::any_of(island.contacts, meets)) w.strike(s, island);

  // of the bodies that it does not reach, contacts stay as they are
  std::erase_if(w.added, [&](int i) { return !w.reaches(s.contacts[at(i)].W); });
  for (const int i : w.active)
    if (!w.reaches(s.contacts[at(i)].W)) w.added.push_back(i);
  std::ranges::sort(w.added);
  std::swap(w.active, w.added);
  return true;
}

/// Restitution, e = 0 too, in place of the gap terms of an impact's contacts.
void LcpStepper::set_rebound(const State& x, const Instant& s, Rebound law) {
  Workspace& w = *work_;
  for (const int i : w.active) {
    const ContactInstant& c = s.contacts[at(i)];
    if (!w.reaches(c.W)) continue;
    if (closeness::loaded(w.answer.p(0, i))) {
      w.gap_term[i] = restitution_term(law, c.e, c.velocity(x.nu).x());
    } else if (whole_impacts()) {
      w.gap_term[i] = 0;
    }
  }
}

/// The step's answer and where it leads, from the start with the contacts that came into being. Joints on their positions: (28) with what psi_b(q ⊕ h nu+, t+) was left over added to its
/// psi_b/h, again and again, is a Newton method for psi_b(q+, t+) = 0 with W_b kept; each round gains a factor of about h |nu|.
/// Where it gains less (a linkage passes its change point), what it adds is no motion: the first answer stands, and its position is
/// moved onto the joints afterwards.
bool LcpStepper::solve_positions(const Model& model, const State& x, const Instant& start,
                                 const StepRequest& request, StepReport& report) {
  constexpr int most_rounds = 8, most_appearances = 6;
  constexpr double least_gain = 0.3;  // of the error in a round that counts
  Workspace& w = *work_;
  const auto fail = [&](StepStatus status, const std::string& why) {
    report.status = status;
    report.message = why;
    return false;
  };
  const Instant*& s = w.solved_from = &start;
  int appearances = 0;
  double error = infinity;
  bool first_again = false;
  for (int round = 0;; ++round) {
    do {
      if (!solve(model, *s, request, w.answer, report))
        return fail(StepStatus::NotSolved,
                    report.message + joints_at_odds(model, x, request.t_end, request.h));
    } while (add_overlapping(*s, request.h, w.answer));
    w.moved.t = request.t_end;
    w.moved.q = x.q;
    w.moved.winding = x.winding;
    move(model, w.answer.nu, request.h, w.moved.q);
    w.moved.nu = w.answer.nu;
    if (!w.moved.q.allFinite()) return fail(StepStatus::NotFinite, "the step's velocities are not finite");
    evaluate(model, w.moved, w.end, nullptr, w.start.near());
    if (!w.end.fault.empty()) return fail(StepStatus::NotFinite, w.end.fault);

    if (const Instant* more = w.add_appeared(*s, request.h); more != nullptr) {
      if (++appearances > most_appearances)
        return fail(StepStatus::Inexact,
                    "contact points that come into being within the step overlap at its end by " +
                        shortest(-w.end.gap_min()) + " m, again after " + std::to_string(most_appearances) +
                        " rounds");
      s = more;
      begin(model, x, request, *s);
      error = infinity;
      first_again = false;
      round = -1;
      continue;
    }
    const double before = error;
    error = closeness::joint_misfit(model, w.end);
    if (!options_.close_joints || error <= 1 || first_again || round == most_rounds) return true;
    if (round == 0) w.first_bias = w.joint_bias;
    if (round > 0 && !(error < least_gain * before)) {
      if (before < 1e3) return true;  // as near as rounding lets it
      w.joint_bias = w.first_bias;
      first_again = true;
      continue;
    }
    for (std::size_t i = 0; i < w.end.joint_rows.size(); ++i)
      w.joint_bias[static_cast<int>(i)] += w.end.joint_rows[i].psi_b / request.h;
  }
}

/// The answer's impulses become those of least norm. Friction that slides keeps its direction and size relative to p_n: on a
/// polygon these are not quite those of the circular cone.
void LcpStepper::take_least(const Model& model, const Instant& s, double h, Answer& answer) {
  Workspace& w = *work_;
  std::vector<Reaction>& all = w.reactions;
  all.clear();
  for (const int i : w.active) {
    const ContactInstant& c = s.contacts[at(i)];
    Reaction r{.law = law_of(c), .mu = c.mu, .of = Reaction::Of::Contact, .source = i, .W = c.W};
    r.p = answer.p.col(i);
    r.u = c.velocity(answer.nu);
    r.u.x() += w.gap_term[i];
    const double p_f = r.p.tail<2>().norm();
    const bool loaded = r.p.x() > 0;
    if (loaded && answer.slips[at(i)] == 0) {
      r.u.tail<2>().setZero();
    } else if (loaded && p_f > 0) {
      r.mu = p_f / r.p.x();
      r.u.tail<2>() = -r.p.tail<2>() / p_f * r.u.tail<2>().norm();
    }
    all.push_back(r);
  }
  for (int i = 0; i < static_cast<int>(s.joint_rows.size()); ++i) {
    Reaction r{.law = Law::Equality,
               .of = Reaction::Of::JointRow,
               .source = i,
               .W = three_columns(s.joint_rows[at(i)].W, 0)};
    r.p.x() = answer.reactions[i];
    all.push_back(r);
  }
  for (int i = 0; i < static_cast<int>(s.joint_frictions.size()); ++i) {
    const JointRowInstant& row = s.joint_frictions[at(i)];
    Reaction r{.law = Law::Interval,
               .mu = h * row.friction,
               .of = Reaction::Of::JointFriction,
               .source = i,
               .W = three_columns(row.W, 1)};
    r.p.y() = answer.joint_friction[i];
    r.u.y() = row.velocity(answer.nu);
    all.push_back(r);
  }
  perp::take_least(model, s, answer.speed_scale, all);
  for (const Reaction& r : all) {
    if (r.of == Reaction::Of::Contact) {
      if (!(answer.p(0, r.source) > 0))
        answer.slips[at(r.source)] = static_cast<char>(slips(r, answer.speed_scale));
      answer.p.col(r.source) = r.p;
    }
    if (r.of == Reaction::Of::JointRow) answer.reactions[r.source] = r.p.x();
    if (r.of == Reaction::Of::JointFriction) answer.joint_friction[r.source] = r.p.y();
  }
}

void LcpStepper::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Workspace& w = *work_;
  const Instant& start = w.start.at(model, x, request.h);
  const auto fail = [&](StepStatus status, const std::string& why) {
    report.status = status;
    report.message = why;
  };
  if (!start.fault.empty()) return fail(StepStatus::NotFinite, start.fault);
  need_any_reactions(name(), model, options_.reactions);
  if (options_.form == LcpForm::Mixed) need_no_moments("lcp in the mixed form", model);

  w.struck.clear();
  begin(model, x, request, start);
  if (!solve_positions(model, x, start, request, report)) return;
  const Instant& s = *w.solved_from;
  if (w.start.widen(model, w.end)) return advance(model, x, request, report);
  w.gained = w.nu_free - x.nu;
  w.speeds.begin(model, s, x, w.gained, request.h, request.t_end, request.max_correction_speed,
                 w.start.near());
  w.fastest = 0;
  for (std::size_t i = 0; i < model.bodies().size(); ++i)
    w.fastest = std::max(w.fastest, w.speeds.of_body(i));
  const bool passed = w.islands_pass(options_, w.answer, report);

  StepAnswer& step = w.step;
  list_impulses(model, s, w.answer, w.active, w.gap_term, step.first);
  step.second.clear();
  step.struck.clear();
  Answer* final = &w.answer;
  if (find_impact(model, x, s, request.h)) {
    final = &w.rebound;
    // what closes joints on their curved positions adds some energy of its own
    const bool free_bodies = s.joint_rows.empty();
    if (free_bodies) w.energy.set(model, s, x.nu, w.nu_free, [&](std::size_t i) { return w.struck[i] != 0; });
    for (const Rebound law : rebounds) {
      set_rebound(x, s, law);
      if (!solve(model, s, request, w.rebound, report)) return fail(StepStatus::NotSolved, report.message);
      if (!free_bodies || !w.energy.exceeded(model, s, w.rebound.nu)) break;
    }
    w.rebound.iterations += w.answer.iterations;
    step.struck = w.struck;
  }

  w.moved.nu = final->nu;
  if (!w.moved.nu.allFinite()) return fail(StepStatus::NotFinite, "the step's velocities are not finite");
  if (final == &w.rebound) evaluate(model, w.moved, w.end, nullptr, w.start.near());
  step.q_moved = w.moved.q;
  const bool loop = options_.close_joints && !s.joint_rows.empty();
  if (loop) report.projection = w.projection.move_onto(model, w.moved, w.end);
  if (options_.reactions == Reactions::MinimumNorm) take_least(model, s, request.h, *final);
  if (final == &w.rebound)
    list_impulses(model, s, w.rebound, w.active, w.gap_term, step.second);
  else if (options_.reactions == Reactions::MinimumNorm)
    list_impulses(model, s, w.answer, w.active, w.gap_term, step.first);
  record(model, s, *final, w.active, w.end, report);
  step.h = request.h;
  step.max_correction_speed = request.max_correction_speed;
  step.nu_q = w.answer.nu;
  step.jumped = step.struck;
  step.joint_bias = w.joint_bias;
  step.joints_closed = loop;
  const double struck =
      w.certificate.certify(model, s, x, w.start.energy(model), w.end, w.moved, step, report);

  if (!passed || (final == &w.rebound && !w.islands_pass(options_, w.rebound, report)) ||
      !w.joints_pass(model, request.h, options_, *final, report))
    return fail(StepStatus::Inexact, report.message);
  if (const std::string spring =
          unstable_spring(model, s, final->nu, request.h, Damping::Explicit, w.fastest);
      !spring.empty())
    return fail(StepStatus::NotSolved, spring);
  if (!keeps_energy(model, x, request, gain_of(model, s, x, w.moved, step, struck, request, report), report))
    return;
  report.status = StepStatus::Solved;
  x = w.moved;
  w.start.go_on_from(model, x, report.energy, w.end);
}

std::vector<Lcp> LcpStepper::problems(const Model& model, const State& x, double h) {
  model.check("LcpStepper::problems", x);
  Workspace& w = *work_;
  const Instant& s = w.start.at(model, x, h);
  begin(model, x, {.h = h}, s);
  w.islands.find(model, s, w.active);
  const std::size_t islands = w.islands.get().size();
  if (w.problems.size() < islands) w.problems.resize(islands);
  std::vector<Lcp> problems;
  for (std::size_t i = 0; i < islands; ++i) {
    w.assemble(model, s, i, h, false);
    problems.push_back(w.problems[i].polygonal.lcp());
  }
  return problems;
}

}  // namespace perp
