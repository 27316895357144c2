#include "step/certificate/pass_mark.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/certificate/closeness.hpp"
#include "step/implicit/implicit_step.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
namespace {

/// Whether loads, gaps or joints may change while nothing moves.
bool varies_with_time(const Model& model) {
  const auto driven = [](const JointGeometry& j) {
    return std::any_of(j.motions.begin(), j.motions.end(), [](const auto& m) { return m.has_value(); });
  };
  return !model.forces().empty() || !model.motors().empty() ||
         std::any_of(model.bodies().begin(), model.bodies().end(),
                     [](const Body& b) {
                       return b.kind == BodyKind::Prescribed || b.kind == BodyKind::Generalized;
                     }) ||
         std::any_of(model.joints().begin(), model.joints().end(), driven);
}

}  // namespace

double metres_per_unit(const Model& model, const Instant& s, const Reaction& r) {
  const auto [first, rows] = rows_of(r.law);
  if (rows > 1 || !closeness::is_angular(model, r.W, first)) return 1;
  double mass = infinity;
  for (const auto& [body, n] : {std::pair(r.W.a, r.W.na), std::pair(r.W.b, r.W.nb)})
    if (n > 0) mass = std::min(mass, model.bodies()[at(body)].mass);
  return 1 / std::sqrt(inverse_mass(model, s, r.W, r.law) * mass);
}

double speed_of(const Body& b, const Vector& f, const Vector& y) {
  const auto part = y.segment(b.v0, b.nv);
  if (b.kind == BodyKind::Generalized) return part.lpNorm<Eigen::Infinity>();
  return std::sqrt(std::abs(f.segment(b.v0, b.nv).dot(part)) / b.mass);
}

double reach_of(const Body& b, const State& x) {
  const int linear = b.kind == BodyKind::Generalized ? b.nq : b.kind == BodyKind::Planar ? 2 : 3;
  const double radius = b.mass > 0 ? std::sqrt(b.J.trace() / b.mass) : 0;
  return std::max(x.q.segment(b.q0, linear).lpNorm<Eigen::Infinity>(), radius);
}

void StepSpeeds::begin(const Model& model, const Instant& s, const State& x, const Vector& gained, double h,
                       double t_end, double max_correction_speed, const std::vector<int>* near) {
  model_ = &model;
  start_ = &s;
  x_ = &x;
  h_ = h;
  cap_ = max_correction_speed;
  gained_ = gained;
  body_.assign(model.bodies().size(), 0);
  const auto add = [&](const Vector& nu) {
    multiply_mass(model, s, nu, scratch_);
    for (std::size_t i = 0; i < body_.size(); ++i)
      if (const Body& b = model.bodies()[i]; b.nv > 0)
        body_[i] = std::max(body_[i], speed_of(b, scratch_, nu));
  };
  for (std::size_t i = 0; i < body_.size(); ++i)  // less moves nothing by its last digit
    if (const Body& b = model.bodies()[i]; b.nv > 0) body_[i] = closeness::eps * reach_of(b, x) / h;
  add(x.nu);
  add(gained);
  varies_ = varies_with_time(model);
  if (!varies_) return;
  State then = x;
  then.t = t_end;
  evaluate(model, then, later_, &s, near);
  varies_ = later_.fault.empty();
  if (!varies_) return;
  Vector more;
  solve_mass(model, s, later_.k, more);
  add(h * more);
}

double StepSpeeds::of(const ContactInstant& c) const {
  return std::max({c.velocity(x_->nu).lpNorm<Eigen::Infinity>(),
                   c.W.velocity(gained_).lpNorm<Eigen::Infinity>(), c.bias.lpNorm<Eigen::Infinity>()});
}

double StepSpeeds::of(const JointRowInstant& row, double length) const {
  const double open = row.friction > 0 ? 0 : std::abs(row.psi_b) / h_;  // friction's psi is a coordinate
  return length * std::max({std::abs(row.velocity(x_->nu)), std::abs(row.W.velocity(gained_)[0]),
                            std::abs(row.psi_b_t), open});
}

StepSpeeds::Mark StepSpeeds::of(const Instant& s, const Island& island, std::vector<double>* lengths) const {
  Mark mark;
  if (lengths != nullptr) lengths->clear();
  const auto add = [&](Reaction r, const ContactInstant* c) {
    measure(r, c);
    if (lengths != nullptr) lengths->push_back(r.length);
    mark.speed = std::max(mark.speed, r.speed);
    mark.rounding = std::max(mark.rounding, r.length * r.rounding);
    for (const auto& [body, n] : {std::pair(r.W.a, r.W.na), std::pair(r.W.b, r.W.nb)})
      if (n > 0) mark.speed = std::max(mark.speed, of_body(at(body)));
  };
  for (const int i : island.contacts) {
    const ContactInstant& c = s.contacts[at(i)];
    add({.law = law_of(c), .of = Reaction::Of::Contact, .source = c.point, .W = c.W}, &c);
  }
  for (const int i : island.joint_rows)
    add({.law = Law::Equality,
         .of = Reaction::Of::JointRow,
         .source = i,
         .W = three_columns(s.joint_rows[at(i)].W, 0)},
        nullptr);
  for (const int i : island.joint_frictions)
    add({.law = Law::Interval,
         .of = Reaction::Of::JointFriction,
         .source = i,
         .W = three_columns(s.joint_frictions[at(i)].W, 1)},
        nullptr);
  return mark;
}

double StepSpeeds::lever_of(const ContactInstant& c, const MomentInstant& m) const {
  return perp::lever_of(*model_, *start_, c, m);
}

void StepSpeeds::measure_moments(Reaction& r, const MomentInstant& found) const {
  const auto of = [&](const MomentInstant& m) {
    return r.lever *
           std::max({m.velocity(x_->nu).lpNorm<Eigen::Infinity>(),
                     m.W.velocity(gained_).lpNorm<Eigen::Infinity>(), m.bias.lpNorm<Eigen::Infinity>()});
  };
  r.speed = of(found);
  if (!varies_) return;
  if (const MomentInstant* later = moments_of(r, later_)) r.speed = std::max(r.speed, of(*later));
}

void StepSpeeds::measure(Reaction& r, const ContactInstant* found) const {
  const Model& model = *model_;
  r.length = metres_per_unit(model, *start_, r);
  r.speed = r.rounding = 0;
  const auto take = [&](double speed, double rounding) {
    r.speed = std::max(r.speed, speed);
    r.rounding = std::max(r.rounding, rounding);
  };
  if (found != nullptr)
    take(r.length * of(*found), closeness::gap_rounding(model, *start_, *x_, *found) / h_);
  for (const Instant* s : {start_, varies_ ? &later_ : start_}) {
    if (r.of == Reaction::Of::Contact) {
      const ContactInstant* c = contact_of(r, *s);
      if (c == nullptr) continue;
      const double overlap = std::clamp(-c->psi_n / h_, 0.0, cap_);
      take(r.length * std::max(of(*c), overlap), closeness::gap_rounding(model, *s, *x_, *c) / h_);
    } else if (r.of == Reaction::Of::JointRow) {
      const JointRowInstant& row = s->joint_rows[at(r.source)];
      take(of(row, r.length), closeness::joint_rounding(model, *s, row) / h_);
    } else {
      take(of(s->joint_frictions[at(r.source)], r.length), 0);
    }
  }
}

}  // namespace perp
