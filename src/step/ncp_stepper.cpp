#include "perp/step/ncp_stepper.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "step/certificate.hpp"
#include "step/closeness.hpp"
#include "step/impact_in_step.hpp"
#include "step/implicit_step.hpp"
#include "step/joint_projection.hpp"
#include "step/least_reactions.hpp"
#include "step/moment_laws.hpp"
#include "step/step_gain.hpp"
#include "step/step_record.hpp"

namespace perp {
namespace {

/// (25)-(38) at the end of the step, in nu+ and p.
class EndOfStep final : public StepProblem {
 public:
  EndOfStep(const Model& model, const Instant& start, const std::vector<int>* near, const State& x,
            const StepRequest& request, Directions directions, Instant& end, ContactDerivatives& geometry)
      : model_(model),
        start_(start),
        near_(near),
        x_(x),
        request_(request),
        directions_(directions),
        end_(end),
        geometry_(geometry) {}

  bool evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) override {
    if (!move_to_end(model_, x_, request_, nu, start_, near_, moved_, end_)) return false;
    multiply_mass(model_, end_, nu - x_.nu, R);
    R -= request_.h * end_.k;
    for (Reaction& r : reactions) place(nu, r);
    return true;
  }

  void differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) override {
    const Vector& nu = moved_.nu;
    const double h = request_.h;
    const Motion motion(model_, nu, h);
    K.clear();
    add_mass(model_, end_, K);
    differentiate_loads(model_, moved_, end_, loads_);
    add_loads(loads_, h, h, motion, K);
    if (!end_.masses.empty()) {
      differentiate_mass(model_, moved_, nu - x_.nu, loads_);
      add_loads(loads_, 0, -1, motion, K);
    }
    active_.clear();
    for (const Reaction& r : reactions)
      if (const ContactInstant* c = contact_of(r, end_))
        active_.push_back(static_cast<int>(c - end_.contacts.data()));
    geometry_.evaluate(model_, end_, active_);
    for (Reaction& r : reactions) {
      if (r.of == Reaction::Of::Contact)
        contact_slopes(motion, r, K);
      else if (r.of == Reaction::Of::Moments)
        moment_slopes(motion, r, K);
      else
        joint_slopes(motion, r, K);
    }
  }

  const State& moved() const { return moved_; }

 private:
  bool ends() const { return directions_ == Directions::End; }

  void place(const Vector& nu, Reaction& r) const {
    const double h = request_.h;
    if (r.of == Reaction::Of::JointRow) {
      const JointRowInstant& row = end_.joint_rows[at(r.source)];
      if (ends()) r.W = three_columns(row.W, 0);
      r.u.x() = row.psi_b / h;
    } else if (r.of == Reaction::Of::JointFriction) {
      const JointRowInstant& row = (ends() ? end_ : start_).joint_frictions[at(r.source)];
      if (ends()) r.W = three_columns(row.W, 1);
      r.u.y() = row.velocity(nu);
    } else if (r.of == Reaction::Of::Moments) {
      const MomentInstant *now = moments_of(r, end_), *before = moments_of(r, start_);
      const MomentInstant* m = ends() || before == nullptr ? now : before;
      r.u.setZero();
      if (now == nullptr) return;  // nor has its contact a load there
      place_moments(*m, r);
      r.u = r.lever * m->velocity(nu);
    } else if (const ContactInstant* c = contact_of(r, end_)) {
      const ContactInstant* before = contact_of(r, start_);
      const ContactInstant& directions = ends() || before == nullptr ? *c : *before;
      r.W = directions.W;
      r.u = directions.velocity(nu);
      // an overlap at the start may go at the capped speed
      const double cap = h * request_.max_correction_speed;
      const double allowed = before == nullptr ? 0 : std::min(0.0, before->psi_n + cap);
      r.u.x() = (c->psi_n - (allowed < 0 ? allowed : 0)) / h;
    } else {
      r.u = {Reaction::no_point, 0, 0};  // no such point there
    }
  }

  void contact_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K) {
    const ContactInstant* c = contact_of(r, end_);
    if (c == nullptr) {
      r.G.setZero();
      return;
    }
    PairDerivative<3> d;
    differentiate_pair(*c, r.p, d);
    Reaction::Slope along = slopes_of(c->W);  // u_n = psi(q+)/h
    motion.turn(r.W, along);
    r.G = slopes_of(r.W);
    if (ends()) {
      motion.turn(r.W, d.velocity);
      r.G += motion.h() * d.velocity;
      add_turning(r.W, d.force, motion, K);
    }
    r.G.row(0) = along.row(0);
  }

  void moment_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K) {
    r.G.setZero();
    if (moments_of(r, end_) == nullptr) return;
    r.G = slopes_of(r.W);
    if (!ends()) return;
    const ContactInstant& c = *contact_at(end_, r.source);
    PairDerivative<3> d;
    differentiate_moments(model_, moved_, end_, c,
                          geometry_[static_cast<std::size_t>(&c - end_.contacts.data())], r.lever * r.p, d);
    motion.turn(r.W, d.velocity);
    r.G += motion.h() * r.lever * d.velocity;
    add_turning(r.W, d.force, motion, K);
  }

  void joint_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K) const {
    const bool row = r.of == Reaction::Of::JointRow;
    const JointRowInstant& now = row ? end_.joint_rows[at(r.source)] : end_.joint_frictions[at(r.source)];
    PairDerivative<1> d;
    perp::differentiate(model_, end_, now, row ? r.p.x() : r.p.y(), d);
    if (ends()) add_turning(r.W, d.force, motion, K);
    r.G.setZero();
    if (row) {
      r.G = slopes_of(three_columns(now.W, 0));
      motion.turn(r.W, r.G);
    } else {
      r.G = slopes_of(r.W);
      if (!ends()) return;
      motion.turn(r.W, d.velocity);
      r.G.row(1) += motion.h() * d.velocity;
    }
  }

  void differentiate_pair(const ContactInstant& c, const Vector3& p, PairDerivative<3>& d) const {
    perp::differentiate(model_, moved_, end_, c,
                        geometry_[static_cast<std::size_t>(&c - end_.contacts.data())], p, d);
  }

  const Model& model_;
  const Instant& start_;
  const std::vector<int>* near_;  // contacts to look at
  const State& x_;
  const StepRequest& request_;
  Directions directions_;
  Instant& end_;
  ContactDerivatives& geometry_;
  State moved_;
  std::vector<LoadDerivative> loads_;
  std::vector<int> active_;
};

}  // namespace

struct NcpStepper::Workspace {
  StartInstant start;
  Instant end;
  ContactDerivatives geometry;
  LastImpulses last;
  NonsmoothNewton newton;
  NewtonOutcome outcome, rebound;
  NewtonHistory history;
  StepReactions step;
  StepSpeeds speeds;
  StruckBodies struck;
  std::vector<Reaction> closed;     // what an impact finds
  std::vector<std::size_t> source;  // of each, in step.all
  std::vector<RelativeVelocity> velocities, rebounding;
  std::vector<std::pair<double, double>> restitution;  // of each: e and u_n before
  EnergyBefore energy;
  Vector nu, gained, before, load, momentum;
  StepAnswer answer;
  Certificate certificate;
};

NcpStepper::NcpStepper(NcpStepperOptions options) : options_(options), work_(std::make_unique<Workspace>()) {
  if (!(options.tolerance > 0)) refuse("NcpStepper", "tolerance", options.tolerance, "needs to be positive");
}
NcpStepper::~NcpStepper() = default;
const StepAnswer* NcpStepper::answer() const { return &work_->answer; }
std::unique_ptr<Stepper> NcpStepper::anew() const { return std::make_unique<NcpStepper>(options_); }
NcpStepper::NcpStepper(NcpStepper&&) noexcept = default;
NcpStepper& NcpStepper::operator=(NcpStepper&&) noexcept = default;
const NewtonHistory& NcpStepper::history() const { return work_->history; }

void NcpStepper::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Workspace& w = *work_;
  const Instant& s = w.start.at(model, x, request.h);
  const double h = request.h;
  const auto fail = [&](StepStatus status, const std::string& why) {
    report.status = status;
    report.message = why;
  };
  if (!s.fault.empty()) return fail(StepStatus::NotFinite, s.fault);
  need_any_reactions(name(), model, options_.reactions);

  w.last.prepare(model, s, x);
  solve_mass(model, s, s.k, w.gained);
  w.gained *= h;
  w.nu = x.nu + w.gained;
  w.speeds.begin(model, s, x, w.gained, h, request.t_end, request.max_correction_speed, w.start.near());
  w.step.begin(model, s, x, h, h, w.last, w.speeds, w.nu);

  EndOfStep problem(model, s, w.start.near(), x, request, options_.directions, w.end, w.geometry);
  const NonsmoothNewton::Options how{.speeds = w.speeds, .tolerance = options_.tolerance};
  const NonsmoothNewton::Options at_first = moving_from(model, x, h, how);
  do {
    w.newton.solve(model, s, problem, at_first, w.nu, w.step.all, w.outcome);
    report.iterations += w.outcome.iterations;
    if (!w.end.fault.empty()) return fail(StepStatus::NotFinite, w.end.fault);
  } while (w.outcome.converged && w.step.add_overlapping(s, w.speeds, w.end));
  if (w.start.widen(model, w.end)) return advance(model, x, request, report);
  w.history.residuals = w.outcome.history;
  report.solver = w.outcome.solver;
  const State& moved = problem.moved();
  Vector nu = moved.nu;
  const StepResiduals& e = w.outcome.residuals;
  if (!w.outcome.converged)
    return fail(std::isfinite(e.largest()) ? StepStatus::Inexact : StepStatus::NotFinite,
                "residual " + shortest(e.largest()) + " m/s is above " + shortest(options_.tolerance) +
                    " of the speed " + shortest(e.speed) + " m/s" +
                    joints_at_odds(model, x, request.t_end, h));

  list_impulses(w.step.all, w.answer.first);

  // impacts, and restitution, at velocity level, over the contacts that closed, for the bodies that they reach
  w.struck.clear(model);
  for (const Reaction& r : w.step.all) {
    const ContactInstant *c = contact_of(r, w.end), *before = contact_of(r, s);
    if (c == nullptr || !closeness::loaded(r.p.x())) continue;
    if (before == nullptr || c->e * before->velocity(x.nu).x() < 0 ||
        strikes(*before, x, w.gained, h, e.speed))  // a point that came into being was open before
      w.struck.add(r);
  }
  w.struck.spread(w.step.all);
  if (w.struck.any()) {
    w.closed.clear();
    w.source.clear();
    w.velocities.clear();
    w.restitution.clear();
    bool closes = false;  // the contact whose moments come next
    for (std::size_t i = 0; i < w.step.all.size(); ++i) {
      const Reaction& r = w.step.all[i];
      const ContactInstant *c = contact_of(r, w.end), *before = contact_of(r, s);
      if (r.of == Reaction::Of::Moments ? !closes : !w.struck.touches(r)) continue;
      closes = false;
      const bool touched =
          before != nullptr && touches(*before, h, e.speed) && !separates(*before, x, w.gained, e.speed);
      if (r.of == Reaction::Of::Contact && (c == nullptr || !(r.p.x() > 0 || touched))) continue;
      Vector3 bias = Vector3::Zero();
      std::pair<double, double> restitution;
      closes = r.has_moments;
      if (r.of == Reaction::Of::Moments) {
        const MomentInstant *now = moments_of(r, w.end), *then = moments_of(r, s);
        bias = r.lever * (options_.directions == Directions::End || then == nullptr ? now->bias : then->bias);
      } else if (c != nullptr) {
        bias = options_.directions == Directions::End || before == nullptr ? c->bias : before->bias;
        restitution = {c->e, (before == nullptr ? *c : *before).velocity(x.nu).x()};
      } else if (r.of == Reaction::Of::JointRow) {
        bias.x() = w.end.joint_rows[at(r.source)].psi_b_t;
      } else {
        bias.y() = w.end.joint_frictions[at(r.source)].psi_b_t;
      }
      w.closed.push_back(r);
      w.closed.back().rounding = 0;
      w.source.push_back(i);
      w.velocities.push_back({r.W, bias});
      w.restitution.push_back(restitution);
    }
    // the others keep the velocities that they have
    w.before = nu;
    w.load.setZero(nu.size());
    for (std::size_t i = 0; i < model.bodies().size(); ++i) {
      const Body& b = model.bodies()[i];
      if (!w.struck[i]) continue;
      w.before.segment(b.v0, b.nv) = x.nu.segment(b.v0, b.nv);
      w.load.segment(b.v0, b.nv) = h * w.end.k.segment(b.v0, b.nv);
    }
    multiply_mass(model, w.end, w.before, w.momentum);
    w.momentum += w.load;
    Vector free;
    solve_mass(model, w.end, w.momentum, free);
    w.energy.set(model, w.end, w.before, free, [&](std::size_t body) { return w.struck[body]; });
    const Vector guess = nu;
    const std::vector<Reaction> closed = w.closed;
    for (const Rebound law : rebounds) {
      nu = guess;
      w.closed = closed;
      w.rebounding = w.velocities;
      for (std::size_t k = 0; k < closed.size(); ++k)
        w.rebounding[k].bias.x() += restitution_term(law, w.restitution[k].first, w.restitution[k].second);
      VelocityLevel level(model, w.end, w.momentum, w.rebounding);
      w.newton.solve(model, w.end, level, how, nu, w.closed, w.rebound);
      report.iterations += w.rebound.iterations;
      if (!w.rebound.converged)
        return fail(StepStatus::Inexact,
                    "the rebound's residual is " + shortest(w.rebound.residuals.largest()) + " m/s");
      if (!w.energy.exceeded(model, w.end, nu)) break;
    }
    for (std::size_t k = 0; k < w.closed.size(); ++k) w.step.all[w.source[k]] = w.closed[k];
  }

  State next = moved;
  next.nu = nu;
  if (w.struck.any()) evaluate(model, next, w.end, &s, w.start.near());
  const Instant& of_impulses = options_.directions == Directions::End ? w.end : s;
  const auto rows = [&](const std::vector<Reaction>& reactions) {
    begin_reactions(model, report);
    report_reactions(model, of_impulses, reactions, e.speed, report);
    report_end(w.end, next, report);
  };
  rows(w.step.all);
  keep_impulses(model, w.step.all, report, next, w.last);
  const std::vector<Reaction>* impulses = &w.step.all;
  if (options_.reactions == Reactions::MinimumNorm) {
    w.closed = w.step.all;
    take_least(model, w.end, e.speed, w.closed);
    impulses = &w.closed;
    rows(w.closed);
  }
  StepAnswer& answer = w.answer;
  answer.scheme = options_.directions == Directions::End ? Scheme::End : Scheme::StartDirections;
  answer.h = h;
  answer.max_correction_speed = request.max_correction_speed;
  answer.nu_q = moved.nu;
  answer.q_moved = next.q;
  answer.second.clear();
  answer.struck.clear();
  list_impulses(*impulses, w.struck.any() ? answer.second : answer.first);
  if (w.struck.any()) answer.struck = w.struck.bodies();
  answer.jumped = answer.struck;
  const double struck =
      w.certificate.certify(model, s, x, w.start.energy(model), w.end, next, answer, report);
  if (!keeps_energy(model, x, request, gain_of(model, s, x, next, answer, struck, request, report), report))
    return;
  report.status = StepStatus::Solved;
  x = next;
  w.start.go_on_from(model, x, report.energy, w.end);
}

}  // namespace perp
