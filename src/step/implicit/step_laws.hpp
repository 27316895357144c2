// The laws of a step's reactions at its answer: a part of the certificate.
#pragma once

#include <algorithm>
#include <cmath>

#include "step/certificate/certificate.hpp"
#include "step/implicit/implicit_step.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {

/// worst = max(worst, |value|); NaN stays.
inline void raise(double& worst, double value) {
  if (!(std::abs(value) <= worst) && !std::isnan(worst)) worst = std::abs(value);
}

/// |min(u, w p)|: how far from 0 <= p ⟂ u >= 0, as a speed.
inline double normal_residual(double u, double w, double p) { return std::abs(std::min(u, w * p)); }

/// What certify() asks of each reaction: its law, as the method poses it, and its work.
class StepLaws {
 public:
  StepLaws(const Model& model, const Instant& start, const State& x, const Instant& end, const State& moved,
           const StepAnswer& answer, StepEnergy& works, Residuals& e)
      : model_(model), start_(start), x_(x), end_(end), moved_(moved), a_(answer), works_(works), e_(e) {}

  void positions() {
    for (const Acting& r : a_.first) {
      if (r.of == Reaction::Of::Contact)
        contact_of_positions(r);
      else if (r.of == Reaction::Of::Moments)
        moments_of_positions(r);
      else if (r.of == Reaction::Of::JointFriction)
        joint_friction_of_positions(r);
      else if (counts(r))
        works_.joint_row(row_of(r), r);
    }
  }

  void velocities() {
    for (const Acting& r : a_.second) {
      if (r.of == Reaction::Of::Contact)
        contact_of_velocities(r);
      else if (r.of == Reaction::Of::Moments)
        moments_of_velocities(r);
      else if (r.of == Reaction::Of::JointFriction)
        joint_friction_of_velocities(r);
      else
        works_.joint_row(a_.scheme == Scheme::Halves ? end_.joint_rows[index_of(r.source)] : row_of(r), r);
    }
  }

  /// Contacts without an impulse must not overlap either.
  void open_contacts() {
    const double h = a_.h;
    if (a_.scheme != Scheme::Start) {
      for (const ContactInstant& c : end_.contacts) {
        const ContactInstant* before = contact_at(start_, c.point);
        raise(e_.normal, std::min(0.0, (c.psi_n - allowed(before)) / h));
      }
      return;
    }
    if (start_.joint_rows.empty() && start_.joint_frictions.empty() &&
        a_.first.size() == start_.contacts.size())
      return;
    auto next = a_.first.begin();  // contacts come first there, ascending
    for (const ContactInstant& c : start_.contacts) {
      const bool acts =
          next != a_.first.end() && next->of == Reaction::Of::Contact && next->source == c.point;
      if (acts) {
        if (++next != a_.first.end() && next->of == Reaction::Of::Moments) ++next;
      } else {
        raise(e_.normal,
              std::min(0.0, std::max(c.psi_n / h, -a_.max_correction_speed) + c.velocity(a_.nu_q).x()));
      }
    }
  }

  void joints(Instant& scratch) {
    if (start_.joint_rows.empty()) return;
    if (a_.scheme != Scheme::Start || a_.joints_closed) {
      const bool projected = a_.q_moved != moved_.q;
      if (projected) {
        State unprojected = moved_;
        unprojected.q = a_.q_moved;
        evaluate(model_, unprojected, scratch);
      }
      for (const JointRowInstant& row : (projected ? scratch : end_).joint_rows) raise(e_.joints, row.psi_b);
    }
    for (std::size_t i = 0; i < start_.joint_rows.size(); ++i) {
      const JointRowInstant &before = start_.joint_rows[i], &now = end_.joint_rows[i];
      const auto bias = [&] { return a_.joint_bias[static_cast<Eigen::Index>(i)]; };
      if (a_.scheme == Scheme::Start) {
        raise(e_.joints, a_.h * (before.W.velocity(a_.nu_q)[0] + bias()));
        if (!a_.struck.empty()) raise(e_.joints, a_.h * (before.W.velocity(moved_.nu)[0] + bias()));
      } else if (a_.scheme == Scheme::Halves || strikes(now.W)) {
        raise(e_.joints, a_.h * now.velocity(moved_.nu));
      }
    }
  }

 private:
  static std::size_t index_of(int i) { return static_cast<std::size_t>(i); }
  /// How deep a contact may still overlap at the end.
  double allowed(const ContactInstant* before) const {
    return before == nullptr ? 0 : std::min(0.0, before->psi_n + a_.h * a_.max_correction_speed);
  }
  double inverse_mass_of(const Acting& r, const WrenchMap<3>& W, Law law) const {
    return std::isnan(r.w) ? inverse_mass(model_, start_, W, law) : r.w;
  }
  const JointRowInstant& row_of(const Acting& r) const {
    const Instant& s = a_.scheme == Scheme::End ? end_ : start_;
    return r.of == Reaction::Of::JointRow ? s.joint_rows[index_of(r.source)]
                                          : s.joint_frictions[index_of(r.source)];
  }
  template <int C>
  bool strikes(const WrenchMap<C>& W) const {
    if (a_.struck.empty()) return false;
    return (W.na > 0 && a_.struck[index_of(W.a)] != 0) || (W.nb > 0 && a_.struck[index_of(W.b)] != 0);
  }
  /// Whether an impulse of `first` is one that gives momentum: of a step with an impact `second` has what the whole step gives.
  bool counts(const Acting& r) const {
    if (a_.struck.empty()) return true;
    return a_.scheme == Scheme::Halves && !strikes_of(r);
  }
  bool strikes_of(const Acting& r) const {
    if (r.of == Reaction::Of::JointRow) return strikes(start_.joint_rows[index_of(r.source)].W);
    if (r.of == Reaction::Of::JointFriction) return strikes(start_.joint_frictions[index_of(r.source)].W);
    const ContactInstant* c = directions(r.source);
    return c != nullptr && strikes(c->W);
  }
  /// The contact whose axes and W the first stage takes.
  const ContactInstant* directions(int point) const {
    const ContactInstant *before = contact_at(start_, point), *now = contact_at(end_, point);
    if (a_.scheme == Scheme::End || (a_.scheme == Scheme::StartDirections && before == nullptr)) return now;
    return before;
  }

  double cone(const Acting& r, const ContactInstant& c, const Vector3& u, double w) const {
    if (c.tangents == 0 || c.moments >= 0) return 0;  // moments: by moments_of_*
    const Vector2 p_f = r.p.tail<2>(), u_f = u.tail<2>();
    const double bound = c.mu * std::max(r.p.x(), 0.0);
    return c.tangents == 2 && !a_.polygon.empty() ? polygon_residual(p_f, u_f, bound, w, a_.polygon)
                                                  : disc_residual(p_f, u_f, bound, w);
  }

  /// Velocity of a contact over the step: along n that of the gap, along t and o that which the law of the first stage has.
  Vector3 over_step(const ContactInstant& c, const ContactInstant* before, const ContactInstant* now) const {
    Vector3 u = c.velocity(a_.nu_q);
    if (a_.scheme == Scheme::Start || before == nullptr || now == nullptr) return u;
    if (a_.scheme == Scheme::Halves) u = 0.5 * (before->velocity(a_.nu_q) + now->velocity(a_.nu_q));
    u.x() = (now->psi_n - before->psi_n) / a_.h;
    return u;
  }

  void contact_of_positions(const Acting& r) {
    const ContactInstant *before = contact_at(start_, r.source), *now = contact_at(end_, r.source);
    const ContactInstant* c = directions(r.source);
    if (c == nullptr) return;
    const double w = inverse_mass_of(r, c->W, law_of(*c));
    const Vector3 u = over_step(*c, before, now);
    double gap = u.x() + r.gap;
    if (a_.scheme != Scheme::Start) {
      if (now != nullptr) gap = (now->psi_n - allowed(before)) / a_.h;
      if (now == nullptr)
        gap = a_.scheme == Scheme::Halves ? (c->psi_n - allowed(c)) / a_.h + u.x() : infinity;
    }
    raise(e_.normal, normal_residual(gap, w, r.p.x()));
    raise(e_.friction, cone(r, *c, u, w));
    if (counts(r)) works_.contact(*c, r.p, u);
    contact_ = {r.p, u, w};
  }

  /// Instants' moments of a point, where the first stage takes W, and angular velocities over the step.
  struct Moments {
    const ContactInstant* c = nullptr;
    const MomentInstant* m = nullptr;
    Vector3 omega = Vector3::Zero();
  };
  Moments over_step(const Acting& r) const {
    const ContactInstant *before = contact_at(start_, r.source), *now = contact_at(end_, r.source);
    Moments all{.c = directions(r.source)};
    if (all.c == nullptr) return all;
    const auto of = [&](const ContactInstant* c) { return (c == now ? end_ : start_).moments_of(*c); };
    all.m = of(all.c);
    all.omega = all.m->velocity(a_.nu_q);
    if (a_.scheme == Scheme::Halves && before != nullptr && now != nullptr)
      all.omega = 0.5 * (of(before)->velocity(a_.nu_q) + of(now)->velocity(a_.nu_q));
    return all;
  }

  MomentLaw law_of_moments(const Moments& at, const Acting& r) const {
    return {*at.c, *at.m, contact_.p, r.p, contact_.w, r.lever};
  }

  std::array<double, 2> misses(const MomentLaw& law, const Vector3& u, const Vector3& omega) const {
    return a_.polygon.empty() ? law.residuals(u, omega)
                              : law.residuals(u, omega, static_cast<int>(a_.polygon.size()));
  }

  void moments_of_positions(const Acting& r) {
    const Moments at = over_step(r);
    if (at.c == nullptr) return;
    for (const double miss : misses(law_of_moments(at, r), contact_.u, at.omega)) raise(e_.friction, miss);
    if (counts(r)) works_.moments(*at.m, r.p, at.omega);
  }

  void moments_of_velocities(const Acting& r) {
    const Moments over = over_step(r);
    Moments at = over;
    if (a_.scheme == Scheme::Halves) {
      at.c = contact_at(end_, r.source);
      if (at.c != nullptr) at.m = end_.moments_of(*at.c);
    }
    if (at.c == nullptr) return;
    const bool struck = strikes(at.c->W);
    if (struck || a_.scheme == Scheme::Halves) {
      const MomentLaw law = law_of_moments(at, r);
      const auto miss = misses(law, contact_.u, at.m->velocity(moved_.nu));
      const bool may_be_tied =
          !struck && a_.scheme == Scheme::Halves && contact_at(start_, r.source) != nullptr;
      const auto tied = law.tied(contact_.u_over_step, over.omega);
      for (std::size_t k = 0; k < miss.size(); ++k)
        raise(e_.friction, may_be_tied ? std::min(miss[k], tied[k]) : miss[k]);
    }
    works_.moments(*at.m, r.p, over.omega);
  }

  void contact_of_velocities(const Acting& r) {
    const ContactInstant *before = contact_at(start_, r.source), *now = contact_at(end_, r.source);
    const ContactInstant* c = a_.scheme == Scheme::Halves ? now : directions(r.source);
    if (c == nullptr) return;
    const bool struck = strikes(c->W);
    contact_ = {r.p, c->velocity(moved_.nu), r.w, over_step(*c, before, now)};
    if (struck || a_.scheme != Scheme::End) {
      const double w = inverse_mass_of(r, c->W, law_of(*c));
      Vector3 u = c->velocity(moved_.nu);
      const double approach = before == nullptr ? 0 : std::min(before->velocity(x_.nu).x(), 0.0);
      u.x() += a_.scheme == Scheme::Start ? r.gap : c->e * approach;
      if (struck || a_.scheme == Scheme::Start || a_.scheme == Scheme::Halves) {
        raise(e_.normal, normal_residual(u.x(), w, r.p.x()));
        raise(e_.friction, std::min(cone(r, *c, u, w), tied(r, *c, before, now, w)));
      }
    }
    works_.contact(*c, r.p, over_step(*c, before, now));
  }

  /// The second stage's other law: what slid at nu_½ has friction -mu p_n u_½/|u_½|.
  double tied(const Acting& r, const ContactInstant& c, const ContactInstant* before,
              const ContactInstant* now, double w) const {
    if (a_.scheme != Scheme::Halves || before == nullptr || strikes(c.W)) return infinity;
    const Vector2 u_f = over_step(c, before, now).tail<2>();
    const double speed = u_f.norm();
    if (!(speed > 0)) return infinity;
    return w * (r.p.tail<2>() + c.mu * r.p.x() / speed * u_f).norm();
  }

  void joint_friction_of_positions(const Acting& r) {
    const JointRowInstant& row = row_of(r);
    double u = row.velocity(a_.nu_q), bound = a_.h * row.friction;
    if (a_.scheme == Scheme::Halves) {
      u = 0.5 * (u + end_.joint_frictions[index_of(r.source)].velocity(a_.nu_q));
      bound *= 0.5;
    }
    interval(r, row, u, bound);
    if (counts(r)) works_.joint_friction(row, r.p.x(), u);
  }

  void joint_friction_of_velocities(const Acting& r) {
    const bool halves = a_.scheme == Scheme::Halves;
    const JointRowInstant& row = halves ? end_.joint_frictions[index_of(r.source)] : row_of(r);
    const bool struck = strikes(row.W);
    const double bound = (halves && !struck ? 0.5 : 1) * a_.h * row.friction, u = row.velocity(moved_.nu);
    if (struck || a_.scheme == Scheme::Start || halves) {
      const double half =
          0.5 * (start_.joint_frictions[index_of(r.source)].velocity(a_.nu_q) + row.velocity(a_.nu_q));
      const bool may_be_tied = halves && !struck && half * u >= 0;  // what slid keeps its friction
      if (!may_be_tied || std::abs(r.p.x() + (half > 0 ? bound : -bound)) > 1e-12 * bound)
        interval(r, row, u, bound);
    }
    works_.joint_friction(row, r.p.x(), row.velocity(a_.nu_q));
  }

  void interval(const Acting& r, const JointRowInstant& row, double u, double bound) {
    const double w = inverse_mass_of(r, three_columns(row.W, 1), Law::Interval), p = r.p.x();
    raise(e_.friction, w * (p - std::clamp(p - u / w, -bound, bound)));
  }

  /// The contact looked at last, whose moments come next.
  struct {
    Vector3 p = Vector3::Zero(), u = Vector3::Zero();
    double w = 1;
    Vector3 u_over_step = Vector3::Zero();
  } contact_;
  const Model& model_;
  const Instant& start_;
  const State& x_;
  const Instant& end_;
  const State& moved_;
  const StepAnswer& a_;
  StepEnergy& works_;
  Residuals& e_;
};

}  // namespace perp
