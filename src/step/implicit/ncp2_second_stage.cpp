#include "step/implicit/ncp2_second_stage.hpp"

#include "core/index.hpp"
#include "solve/blocks/ellipsoid.hpp"
#include "step/certificate/certificate.hpp"
#include "step/parts/moment_laws.hpp"
#include "step/run/step_record.hpp"

namespace perp {

void Slid::tie(const Reaction& contact, const Reaction& moments, double speed) {
  const SemiAxes axes = semi_axes_of(contact, moments);
  if (!axes.sliding.isZero(0) && slides(contact, moments, speed))
    sliding = ellipsoid_support_gradient(axes.sliding, {contact.u.y(), contact.u.z(), moments.u.x()});
  if (rolls(contact, moments, speed)) rolling = rolling_friction(axes.rolling, moments.u.tail<2>());
}

namespace {

/// A contact with moments as the second stage poses it: what slid or rolled is in the column of p_n. Whether its moments are left
/// with a law of their own.
bool pose_with_moments(const Slid& slid, Reaction& contact, Reaction& moments) {
  const auto tie = [&](const Reaction& r, int column, double share) {
    contact.W.A.col(0) -= share * r.W.A.col(column);
    contact.W.B.col(0) -= share * r.W.B.col(column);
  };
  const bool slides = !slid.sliding.isZero(0), rolls = !slid.rolling.isZero(0);
  if (slides) {
    const Reaction own = contact;
    tie(own, 1, slid.sliding.x());
    tie(own, 2, slid.sliding.y());
    tie(moments, 0, slid.sliding.z());
    contact.mu = moments.mu_o = moments.torsion = 0;
    contact.p.tail<2>().setZero();
    moments.p.x() = 0;
  }
  if (rolls) {
    tie(moments, 1, slid.rolling.x());
    tie(moments, 2, slid.rolling.y());
    moments.rolling = 0;
    moments.p.tail<2>().setZero();
  }
  contact.has_moments = !(slides && rolls) && (moments.torsion > 0 || moments.rolling > 0 || !slides);
  if (!contact.has_moments) contact.law = Law::HalfLine;
  return contact.has_moments;
}

/// The impulses of what was tied, as p_n is.
void give_tied(const Slid& slid, Reaction& contact, Reaction& moments) {
  if (!slid.sliding.isZero(0)) {
    contact.p.tail<2>() = -contact.p.x() * slid.sliding.head<2>();
    moments.p.x() = -contact.p.x() * slid.sliding.z();
  }
  if (!slid.rolling.isZero(0)) moments.p.tail<2>() = -contact.p.x() * slid.rolling;
}

/// Unties what the answer turns round; whether anything.
bool untie_turned_moments(Slid& slid, const Reaction& contact, const Reaction& moments) {
  bool turned = false;
  if (Vector3(contact.u.y(), contact.u.z(), moments.u.x()).dot(slid.sliding) < 0) {
    slid.sliding.setZero();
    turned = true;
  }
  if (moments.u.tail<2>().dot(slid.rolling) < 0) {
    slid.rolling.setZero();
    turned = true;
  }
  return turned;
}

/// 0 <= p_n ⟂ u_n+ >= 0 with the column W_n - mu W_f d.
void tie_friction(const Vector3& d, Reaction& r) {
  r.law = Law::HalfLine;
  r.W.A.col(0) -= r.mu * (r.W.A * d);
  r.W.B.col(0) -= r.mu * (r.W.B * d);
  r.p.tail<2>().setZero();
}

bool closes_first(const Reaction& r) { return r.w * r.p.x() > r.u.x(); }

}  // namespace

void SecondStage::close(const HalfStep& step, std::vector<Reaction>& first) {
  struck_.clear(step.model);
  for (const Reaction& r : first) {
    if (r.of != Reaction::Of::Contact || !closes_first(r)) continue;
    const ContactInstant* c = contact_of(r, step.start);  // null: it came into being, and was open before
    if (c == nullptr || strikes(*c, step.x, step.gained, step.h, step.speed)) struck_.add(r);
  }
  struck_.spread(first);

  closed_.clear();
  velocities_.clear();
  slid_.clear();
  for (std::size_t i = 0; i < first.size(); ++i) {
    Reaction r = first[i];
    r.rounding = 0;
    Vector3 bias = Vector3::Zero();
    Slid how;
    const bool taken = take(step, i, first, r, bias, how);
    if (struck_.touches(first[i])) first[i].p.setZero();
    if (!taken) continue;
    closed_.push_back(r);
    velocities_.push_back({r.W, bias});
    slid_.push_back(how);
  }
}

/// Whether reaction i of the first stage has a part in the second, and there as what: with W at q+, its velocity's bias, and how it came out.
bool SecondStage::take(const HalfStep& step, std::size_t i, const std::vector<Reaction>& first, Reaction& r,
                       Vector3& bias, Slid& how) const {
  const bool whole = struck_.touches(r);
  if (r.of == Reaction::Of::JointRow) {
    const JointRowInstant& row = step.end.joint_rows[at(r.source)];
    r.W = three_columns(row.W, 0);
    bias.x() = row.psi_b_t;
  } else if (r.of == Reaction::Of::JointFriction) {
    const JointRowInstant& row = step.end.joint_frictions[at(r.source)];
    r.W = three_columns(row.W, 1);
    bias.y() = row.psi_b_t;
    if (whole)
      r.mu *= 2;  // bounds of both halves of the step
    else if (slips(r, step.speed))
      how.direction.y() = r.u.y() > 0 ? 1 : -1;
  } else if (r.of == Reaction::Of::Moments) {
    if (closed_.empty() || closed_.back().of != Reaction::Of::Contact || closed_.back().source != r.source)
      return false;  // its contact is open
    const MomentInstant& m = *moments_of(r, step.end);
    place_moments(m, r);
    bias = r.lever * m.bias;
  } else {
    const ContactInstant *before = contact_of(r, step.start), *c = contact_of(r, step.end);
    const bool touched = before != nullptr && touches(*before, step.h, step.speed);
    const bool stays = whole && touched && !separates(*before, step.x, step.gained, step.speed);
    if (c == nullptr || !(closes_first(r) || stays)) return false;
    r.W = c->W;
    bias = c->bias;
    how.e = c->e;
    how.u_n_before = (before == nullptr ? *c : *before).velocity(step.x.nu).x();
    const bool goes_on = touched && !whole && r.law != Law::HalfLine;
    if (goes_on && r.has_moments)
      how.tie(r, first[i + 1], step.speed);
    else if (goes_on && slips(r, step.speed))
      how.direction.tail<2>() = r.u.tail<2>().normalized();
  }
  return true;
}

/// What Newton sees: friction of what slid is tied to p_2n, or known and then in `known`.
void SecondStage::pose(Vector& known) {
  posed_.clear();
  posed_velocities_.clear();
  source_.clear();
  const auto add = [&](const Reaction& r, std::size_t i) {
    posed_.push_back(r);
    posed_velocities_.push_back(velocities_[i]);
    source_.push_back(i);
  };
  for (std::size_t i = 0; i < closed_.size(); ++i) {
    Reaction& r = closed_[i];
    const Vector3& d = slid_[i].direction;
    if (!d.isZero(0) && r.of == Reaction::Of::JointFriction) {
      r.p = -r.mu * d;
      r.W.add_impulse(r.p, known);
      continue;
    }
    add(r, i);
    if (r.has_moments) {
      Reaction moments = closed_[i + 1];
      if (pose_with_moments(slid_[i], posed_.back(), moments)) add(moments, i + 1);
      ++i;
    } else if (!d.isZero(0)) {
      tie_friction(d, posed_.back());
    }
  }
}

/// p_2 and the velocities of all that closed, from Newton's answer.
void SecondStage::read_posed(const Vector& nu) {
  for (std::size_t k = 0; k < posed_.size(); ++k) {
    Reaction& r = closed_[source_[k]];
    r.p = posed_[k].p;
    if (const Vector3& d = slid_[source_[k]].direction; !d.isZero(0))
      r.p.tail<2>() = -r.mu * r.p.x() * d.tail<2>();
  }
  for (std::size_t i = 0; i < closed_.size(); ++i) {
    if (closed_[i].has_moments) give_tied(slid_[i], closed_[i], closed_[i + 1]);
    closed_[i].u = velocities_[i].W.velocity(nu) + velocities_[i].bias;
  }
}

bool SecondStage::untie_all() {
  bool tied = false;
  for (Slid& s : slid_) {
    tied = tied || s.tied();
    s.untie();
  }
  return tied;
}

/// Gives what the answer turns round its law at nu+; whether anything.
bool SecondStage::untie_turned() {
  bool turned = false;
  for (std::size_t i = 0; i < closed_.size(); ++i) {
    if (Vector3& d = slid_[i].direction; !d.isZero(0) && closed_[i].u.dot(d) < 0) {
      d.setZero();
      turned = true;
    }
    if (closed_[i].has_moments && untie_turned_moments(slid_[i], closed_[i], closed_[i + 1])) turned = true;
  }
  return turned;
}

bool SecondStage::solve_posed(const HalfStep& step, const NonsmoothNewton::Options& how, Vector& nu,
                              int& iterations) {
  for (;;) {
    Vector known = step.momentum;
    pose(known);
    VelocityLevel level(step.model, step.end, known, posed_velocities_);
    newton_.solve(step.model, step.end, level, how, nu, posed_, outcome_);
    iterations += outcome_.iterations;
    if (!outcome_.converged) {  // with much friction the tied law need not have a solution
      if (!untie_all()) return false;
      nu = step.half;
      continue;
    }
    read_posed(nu);
    if (!untie_turned()) return true;
  }
}

bool SecondStage::solve(const HalfStep& step, const NonsmoothNewton::Options& how, Vector& nu,
                        int& iterations) {
  const auto restitute = [&](Rebound law) {
    for (std::size_t i = 0; i < slid_.size(); ++i)
      velocities_[i].bias.x() += restitution_term(law, slid_[i].e, slid_[i].u_n_before);
  };
  nu = step.half;
  if (!struck_.any()) {
    restitute(Rebound::Newton);
    return solve_posed(step, how, nu, iterations);
  }
  const auto closed = closed_;
  const auto velocities = velocities_;
  const auto slid = slid_;
  Vector free;
  solve_mass(step.model, step.end, step.momentum, free);
  energy_.set(step.model, step.end, step.x.nu, free, [&](std::size_t body) { return struck_[body]; });
  for (const Rebound law : rebounds) {
    nu = step.half;
    closed_ = closed;
    velocities_ = velocities;
    slid_ = slid;
    restitute(law);
    if (!solve_posed(step, how, nu, iterations)) return false;
    if (!energy_.exceeded(step.model, step.end, nu)) break;
  }
  return true;
}

}  // namespace perp
