#include "step/implicit/end_of_step.hpp"

#include <algorithm>

#include "core/index.hpp"
#include "step/certificate/certificate.hpp"
#include "step/parts/moment_laws.hpp"
#include "step/run/step_record.hpp"

namespace perp {

EndOfStep::EndOfStep(const Model& model, const Instant& start, const std::vector<int>* near, const State& x,
                     const StepRequest& request, Directions directions, Instant& end,
                     ContactDerivatives& geometry)
    : model_(model),
      start_(start),
      near_(near),
      x_(x),
      request_(request),
      directions_(directions),
      end_(end),
      geometry_(geometry) {}

bool EndOfStep::evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) {
  if (!move_to_end(model_, x_, request_, nu, start_, near_, moved_, end_)) return false;
  multiply_mass(model_, end_, nu - x_.nu, R);
  R -= request_.h * end_.k;
  for (Reaction& r : reactions) place(nu, r);
  return true;
}

void EndOfStep::differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) {
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

void EndOfStep::place(const Vector& nu, Reaction& r) const {
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

void EndOfStep::contact_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K) {
  const ContactInstant* c = contact_of(r, end_);
  if (c == nullptr) {
    r.G.setZero();
    return;
  }
  PairDerivative<3> d;
  perp::differentiate(model_, moved_, end_, *c, geometry_[static_cast<std::size_t>(c - end_.contacts.data())],
                      r.p, d);
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

void EndOfStep::moment_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K) {
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

void EndOfStep::joint_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K) const {
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

}  // namespace perp
