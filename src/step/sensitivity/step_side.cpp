#include "step/sensitivity/step_side.hpp"

#include "core/index.hpp"
#include "step/certificate/certificate.hpp"
#include "step/implicit/end_of_step.hpp"
#include "step/implicit/ncp2_first_stage.hpp"

namespace perp {

bool StepModes::strikes(const WrenchMap<3>& W) const {
  if (answer.struck.empty()) return false;
  return (W.na > 0 && answer.struck[at(W.a)] != 0) || (W.nb > 0 && answer.struck[at(W.b)] != 0);
}

bool StepSide::begin_like(const Model& model, const State& x, const StepModes& modes, const Instant& like) {
  perp::evaluate(model, x, own_start_, &like);
  return begin(model, x, modes, own_start_);
}

bool StepSide::go_on(const Model& model, const State& x, const StepModes& modes) {
  std::swap(own_start_, end);
  evaluate_loads(model, x, own_start_);
  return begin(model, x, modes, own_start_);
}

bool StepSide::begin(const Model& model, const State& x, const StepModes& modes, const Instant& start) {
  start_ = &start;
  model_ = &model;
  x_ = &x;
  modes_ = &modes;
  if (!start.fault.empty()) return false;
  for (Reaction& r : first)
    if (!place(r)) return false;
  const Scheme scheme = modes.answer.scheme;
  if (scheme == Scheme::Halves)
    problem_ =
        std::make_unique<FirstStage>(model, start, nullptr, x, modes.request, end, scratch_, geometry_);
  else
    problem_ = std::make_unique<EndOfStep>(model, start, nullptr, x, modes.request,
                                           scheme == Scheme::End ? Directions::End : Directions::Start, end,
                                           geometry_);
  return true;
}

/// The first stage's reaction as the start has it.
bool StepSide::place(Reaction& r) const {
  const double h = modes_->request.h, h_p = modes_->answer.scheme == Scheme::Halves ? 0.5 * h : h;
  if (r.of == Reaction::Of::JointRow) {
    r.W = three_columns(start_->joint_rows[at(r.source)].W, 0);
  } else if (r.of == Reaction::Of::JointFriction) {
    const JointRowInstant& row = start_->joint_frictions[at(r.source)];
    r.W = three_columns(row.W, 1);
    r.mu = row.friction * h_p;
  } else {
    const ContactInstant* c = contact_at(*start_, r.source);
    if (c == nullptr) return false;
    r.law = law_of(*c);
    r.W = c->W;
    r.mu = c->mu;
  }
  return true;
}

const State& StepSide::moved() const {
  const bool halves = modes_->answer.scheme == Scheme::Halves;
  return halves ? static_cast<const FirstStage&>(*problem_).moved()
                : static_cast<const EndOfStep&>(*problem_).moved();
}

bool StepSide::evaluate_first(const Vector& nu_q) {
  nu_q_ = nu_q;
  if (!problem_->evaluate(nu_q, first, R)) return false;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (first[i].of == Reaction::Of::Contact && contact_at(end, first[i].source) == nullptr) return false;
  return true;
}

/// A reaction of the second stage with its law's u at nu+.
bool StepSide::place_second(std::size_t i, const Vector& nu_end) {
  Reaction& r = second[i];
  const StepModes& m = *modes_;
  const Reaction& before = first[at(m.source[i])];
  const bool halves = m.answer.scheme == Scheme::Halves;
  const double h = m.request.h;
  r.u.setZero();
  if (r.of == Reaction::Of::JointRow) {
    const JointRowInstant& row = end.joint_rows[at(r.source)];
    r.W = halves ? three_columns(row.W, 0) : before.W;
    r.u.x() = row.psi_b_t;
  } else if (r.of == Reaction::Of::JointFriction) {
    const JointRowInstant& row = end.joint_frictions[at(r.source)];
    r.W = halves ? three_columns(row.W, 1) : before.W;
    r.u.y() = row.psi_b_t;
    r.mu = row.friction * (halves && m.whole[at(m.source[i])] == 0 ? 0.5 * h : h);
  } else {
    const ContactInstant *then = contact_at(*start_, r.source), *now = contact_at(end, r.source);
    if (then == nullptr || now == nullptr) return false;
    const ContactInstant& directions = m.answer.scheme == Scheme::StartDirections ? *then : *now;
    r.law = law_of(*now);
    r.W = directions.W;
    r.mu = now->mu;
    r.u = directions.bias;
    r.u.x() += restitution_term(m.rebound, now->e, then->velocity(x_->nu).x());
  }
  r.u += r.W.velocity(nu_end);
  r.G = slopes_of(r.W);
  return true;
}

/// What the second stage's velocities come of, but for its impulses.
void StepSide::momentum(Vector& out) {
  const Model& model = *model_;
  const double h = modes_->request.h;
  Vector load;
  if (modes_->answer.scheme != Scheme::Halves) {
    Vector before = nu_q_;
    load.setZero(before.size());
    for (std::size_t i = 0; i < model.bodies().size(); ++i) {
      const Body& b = model.bodies()[i];
      if (modes_->answer.struck[i] == 0) continue;
      before.segment(b.v0, b.nv) = x_->nu.segment(b.v0, b.nv);
      load.segment(b.v0, b.nv) = h * end.k.segment(b.v0, b.nv);
    }
    multiply_mass(model, end, before, out);
    out += load;
    return;
  }
  static_cast<const FirstStage&>(*problem_).kick({}, out);
  for (std::size_t i = 0; i < first.size(); ++i)  // p_1 of what an impact changes gives no momentum
    if (modes_->whole[i] == 0 && modes_->first[i].held != Held::Open) first[i].W.add_impulse(first[i].p, out);
  carry(model, nu_q_, 2 * h, out);
  for (std::size_t i = 0; i < start_->masses.size(); ++i) {
    const Body& b = model.bodies()[at(start_->masses[i].body)];
    out.segment(b.v0, b.nv) = end.masses[i].M * (start_->masses[i].inverse * out.segment(b.v0, b.nv));
  }
  State there = moved();
  loads_at(model, end, there, scratch_, load);
  out += 0.5 * h * load;
}

bool StepSide::evaluate_second(const Vector& nu_end) {
  for (std::size_t i = 0; i < second.size(); ++i)
    if (!place_second(i, nu_end)) return false;
  Vector from;
  momentum(from);
  multiply_mass(*model_, end, nu_end, R);
  R -= from;
  return true;
}

}  // namespace perp
