#include "step/implicit/end_rebound.hpp"

#include "core/index.hpp"
#include "step/certificate/closeness.hpp"
#include "step/parts/moment_laws.hpp"
#include "step/run/step_record.hpp"

namespace perp {

void EndRebound::find(const MovedStep& step, const std::vector<Reaction>& all) {
  struck_.clear(step.model);
  for (const Reaction& r : all) {
    const ContactInstant *c = contact_of(r, step.end), *before = contact_of(r, step.start);
    if (c == nullptr || !closeness::loaded(r.p.x())) continue;
    if (before == nullptr || c->e * before->velocity(step.x.nu).x() < 0 ||
        strikes(*before, step.x, step.gained, step.h,
                step.speed))  // a point that came into being was open before
      struck_.add(r);
  }
  struck_.spread(all);
}

/// The reactions that the impact finds: contacts that closed or touched, and joints, of the bodies that are struck.
void EndRebound::pose(const MovedStep& step, Directions directions, const std::vector<Reaction>& all) {
  closed_.clear();
  source_.clear();
  velocities_.clear();
  restitution_.clear();
  const bool ends = directions == Directions::End;
  bool closes = false;  // the contact whose moments come next
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Reaction& r = all[i];
    const ContactInstant *c = contact_of(r, step.end), *before = contact_of(r, step.start);
    if (r.of == Reaction::Of::Moments ? !closes : !struck_.touches(r)) continue;
    closes = false;
    const bool touched = before != nullptr && touches(*before, step.h, step.speed) &&
                         !separates(*before, step.x, step.gained, step.speed);
    if (r.of == Reaction::Of::Contact && (c == nullptr || !(r.p.x() > 0 || touched))) continue;
    Vector3 bias = Vector3::Zero();
    Restitution restitution;
    closes = r.has_moments;
    if (r.of == Reaction::Of::Moments) {
      const MomentInstant *now = moments_of(r, step.end), *then = moments_of(r, step.start);
      bias = r.lever * (ends || then == nullptr ? now->bias : then->bias);
    } else if (c != nullptr) {
      bias = ends || before == nullptr ? c->bias : before->bias;
      restitution = {c->e, (before == nullptr ? *c : *before).velocity(step.x.nu).x()};
    } else if (r.of == Reaction::Of::JointRow) {
      bias.x() = step.end.joint_rows[at(r.source)].psi_b_t;
    } else {
      bias.y() = step.end.joint_frictions[at(r.source)].psi_b_t;
    }
    closed_.push_back(r);
    closed_.back().rounding = 0;
    source_.push_back(i);
    velocities_.push_back({r.W, bias});
    restitution_.push_back(restitution);
  }
}

/// M nu + h k of what is struck, M nu+ of the others.
void EndRebound::set_momentum(const MovedStep& step, const Vector& nu) {
  before_ = nu;
  load_.setZero(nu.size());
  for (std::size_t i = 0; i < step.model.bodies().size(); ++i) {
    const Body& b = step.model.bodies()[i];
    if (!struck_[i]) continue;
    before_.segment(b.v0, b.nv) = step.x.nu.segment(b.v0, b.nv);
    load_.segment(b.v0, b.nv) = step.h * step.end.k.segment(b.v0, b.nv);
  }
  multiply_mass(step.model, step.end, before_, momentum_);
  momentum_ += load_;
  Vector free;
  solve_mass(step.model, step.end, momentum_, free);
  energy_.set(step.model, step.end, before_, free, [&](std::size_t body) { return struck_[body]; });
}

bool EndRebound::solve(const MovedStep& step, Directions directions, const NonsmoothNewton::Options& how,
                       NonsmoothNewton& newton, Vector& nu, std::vector<Reaction>& all, int& iterations) {
  pose(step, directions, all);
  set_momentum(step, nu);
  const Vector guess = nu;
  const std::vector<Reaction> posed = closed_;
  for (const Rebound law : rebounds) {
    nu = guess;
    closed_ = posed;
    rebounding_ = velocities_;
    for (std::size_t k = 0; k < posed.size(); ++k)
      rebounding_[k].bias.x() += restitution_term(law, restitution_[k].e, restitution_[k].u_n_before);
    VelocityLevel level(step.model, step.end, momentum_, rebounding_);
    newton.solve(step.model, step.end, level, how, nu, closed_, outcome_);
    iterations += outcome_.iterations;
    if (!outcome_.converged) return false;
    if (!energy_.exceeded(step.model, step.end, nu)) break;
  }
  for (std::size_t k = 0; k < closed_.size(); ++k) all[source_[k]] = closed_[k];
  return true;
}

}  // namespace perp
