#include "step/certificate/certificate.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/implicit/step_laws.hpp"
#include "step/parts/free_rotation.hpp"

namespace perp {
namespace {

/// sum W p of a stage. Contacts and joints are those of `s`, or where it has not the contact, of `other`.
void add_impulses(const Instant& s, const Instant& other, std::span<const Acting> all, Vector& out) {
  for (const Acting& r : all) {
    if (r.of == Reaction::Of::JointRow) {
      s.joint_rows[at(r.source)].W.add_impulse(r.p.head<1>(), out);
    } else if (r.of == Reaction::Of::JointFriction) {
      s.joint_frictions[at(r.source)].W.add_impulse(r.p.head<1>(), out);
    } else {
      const Instant* where = &s;
      const ContactInstant* c = contact_at(s, r.source);
      if (c == nullptr) c = contact_at(*(where = &other), r.source);
      if (c == nullptr) continue;
      const bool moments = r.of == Reaction::Of::Moments;
      (moments ? where->moments_of(*c)->W : c->W).add_impulse(r.p, out);
    }
  }
}

/// max |M (nu - nu_0) - impulse|, M that of the instant.
double momentum_residual(const Model& model, const Instant& s, const Vector& nu, const Vector& nu_0,
                         const Vector& impulse) {
  double worst = 0;
  for (const Body& b : model.bodies()) {
    if (b.nv == 0 || b.kind == BodyKind::Generalized) continue;
    const int linear = b.kind == BodyKind::Planar ? 2 : 3;
    for (int i = b.v0; i < b.v0 + linear; ++i) raise(worst, b.mass * (nu[i] - nu_0[i]) - impulse[i]);
    if (b.kind == BodyKind::Planar) {
      const int i = b.v0 + 2;
      raise(worst, b.J(2, 2) * (nu[i] - nu_0[i]) - impulse[i]);
    } else if (b.kind == BodyKind::Spatial) {
      const Vector3 turned = b.J * Vector3(nu.segment<3>(b.v0 + 3) - nu_0.segment<3>(b.v0 + 3));
      for (int i = 0; i < 3; ++i) raise(worst, turned[i] - impulse[b.v0 + 3 + i]);
    }
  }
  for (const Instant::GeneralizedMass& mass : s.masses) {
    const Body& b = model.bodies()[at(mass.body)];
    const auto part = [&](const Vector& v) { return v.segment(b.v0, b.nv); };
    raise(worst, (mass.M * (part(nu) - part(nu_0)) - part(impulse)).cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace

const ContactInstant* contact_at(const Instant& s, int point) {
  const int i = s.contact_of_point[at(point)];
  return i < 0 ? nullptr : &s.contacts[at(i)];
}

double disc_residual(const Vector2& p, const Vector2& u, double bound, double w) {
  const Vector2 z = p - u / w;
  const double size = z.norm();
  const double inside = size <= bound ? 1 : bound / size;
  return w * (p - inside * z).norm();
}

double polygon_residual(const Vector2& p, const Vector2& u, double bound, double w,
                        std::span<const Vector2> polygon) {
  const Vector2 z = p - u / w;
  Vector2 nearest = z;
  double least = infinity;
  bool inside = true;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector2 a = bound * polygon[k], edge = bound * polygon[(k + 1) % polygon.size()] - a;
    const Vector2 off = z - a;
    if (edge.x() * off.y() - edge.y() * off.x() < 0) inside = false;  // vertices go round anticlockwise
    const double square = edge.squaredNorm();
    const double along = square > 0 ? std::clamp(edge.dot(off) / square, 0.0, 1.0) : 0;
    const double distance = (off - along * edge).squaredNorm();
    if (distance < least) {
      least = distance;
      nearest = a + along * edge;
    }
  }
  return std::min(w * (p - (inside ? z : nearest)).norm(), disc_residual(p, u, bound, w));
}

double kinematic_residual(const Model& model, const Vector& q, const Vector& nu, double h,
                          const Vector& q_end) {
  double worst = 0;
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    const int n = b.kind == BodyKind::Generalized ? b.nq : 3;
    for (int i = 0; i < n; ++i) raise(worst, q_end[b.q0 + i] - q[b.q0 + i] - h * nu[b.v0 + i]);
    if (b.kind != BodyKind::Spatial) continue;
    const auto orientation = [&](const Vector& y) {
      return Quaternion(y[b.q0 + 3], y[b.q0 + 4], y[b.q0 + 5], y[b.q0 + 6]);
    };
    const Quaternion there = orientation(q) * rotation(h * nu.segment<3>(b.v0 + 3)), now = orientation(q_end);
    const Quaternion off = there.conjugate() * now;  // its vector part is half of the turn left over
    const Vector3 turn = (off.w() < 0 ? -2.0 : 2.0) * off.vec();
    raise(worst, turn.cwiseAbs().maxCoeff());
    raise(worst, now.squaredNorm() - 1);
  }
  return worst;
}

double Certificate::certify(const Model& model, const Instant& start, const State& x, double energy,
                            const Instant& end, const State& moved, const StepAnswer& answer,
                            StepReport& report) {
  Residuals& e = report.residuals;
  e = {};
  const bool impact = !answer.struck.empty();
  StepEnergy works(model, start, x, end, moved, answer, nu_);
  StepLaws laws(model, start, x, end, moved, answer, works, e);
  laws.positions();
  if (impact || answer.scheme == Scheme::Halves) laws.velocities();
  laws.open_contacts();
  laws.joints(scratch_);
  const bool projected = report.projection > 0;  // by as much as it says, and no more
  e.kinematic = kinematic_residual(model, x.q, answer.nu_q, answer.h, projected ? answer.q_moved : moved.q);
  if (projected)
    raise(e.kinematic, std::max(0.0, (moved.q - answer.q_moved).cwiseAbs().maxCoeff() - report.projection));
  if (answer.scheme == Scheme::Halves) {
    halves(model, start, x, end, moved, answer, e, works);
  } else {
    whole(model, start, x, end, moved, answer, e, works);
  }
  report.energy = model.energy(moved);
  works.fill(report.energy - energy, report);
  return works.struck();
}

/// (25) of schemes with one momentum equation, for nu_q and, of an impact, nu+.
void Certificate::whole(const Model& model, const Instant& start, const State& x, const Instant& end,
                        const State& moved, const StepAnswer& answer, Residuals& e, StepEnergy& works) {
  const bool at_start = answer.scheme == Scheme::Start, impact = !answer.struck.empty();
  const Instant& of_mass = at_start ? start : end;
  const Instant& of_impulse = answer.scheme == Scheme::End ? end : start;
  const Instant& other = answer.scheme == Scheme::End ? start : end;
  const Instant* of_load = &of_mass;
  if (!at_start && impact) {  // loads at nu_q, where `end` has nu+
    scratch_state_ = moved;
    scratch_state_.nu = answer.nu_q;
    evaluate_loads(model, scratch_state_, scratch_);
    of_load = &scratch_;
  }
  impulse_ = of_load->k;
  if (at_start) implicit_gyroscopic(model, x, answer.h, impulse_);
  impulse_ *= answer.h;
  if (impact) R_ = impulse_;
  add_impulses(of_impulse, other, answer.first, impulse_);
  raise(e.newton_euler, momentum_residual(model, of_mass, impact ? answer.nu_q : moved.nu, x.nu, impulse_));
  if (impact) {
    add_impulses(of_impulse, other, answer.second, R_);
    raise(e.newton_euler, momentum_residual(model, of_mass, moved.nu, x.nu, R_));
  }
  works.loads(*of_load, answer.h);
  works.moving_springs(at_start ? start : end, answer.h);
  works.generalized(*of_load, answer.h);
}

namespace {

/// k without gyroscopic terms, of an instant.
void without_gyroscopic(const Model& model, const Instant& s, Vector& f) {
  f = s.k;
  for (const Body& b : model.bodies()) {
    if (b.kind != BodyKind::Spatial) continue;
    const Vector3 w = s.nu.segment<3>(b.v0 + 3);
    f.segment<3>(b.v0 + 3) += w.cross(b.J * w);
  }
}

}  // namespace

/// The two momentum equations of a step in halves, the angular parts carried through half a turn each.
void Certificate::halves(const Model& model, const Instant& start, const State& x, const Instant& end,
                         const State& moved, const StepAnswer& answer, Residuals& e, StepEnergy& works) {
  const double h = answer.h;
  const Vector& half = answer.nu_q;
  const auto loads_at = [&](const Instant& s, const State& there, Vector& f) {
    const Instant* of = &s;
    if (loads_vary(model, s)) {
      scratch_state_ = there;
      scratch_state_.nu = half;
      evaluate_loads(model, scratch_state_, scratch_);
      of = &scratch_;
    }
    without_gyroscopic(model, *of, f);
    works.loads(*of, 0.5 * h);
    works.moving_springs(*of, 0.5 * h);
    works.generalized(*of, 0.5 * h);
  };
  loads_at(start, x, f_start_);
  loads_at(end, moved, f_end_);

  // (a) T^-1 M nu_½ - M nu - h/2 f = W(q) p_1
  multiply_mass(model, start, half, momentum_);
  multiply_mass(model, start, x.nu, R_);
  R_ += 0.5 * h * f_start_;
  kick_ = R_;  // what goes on to (b) where p_1 gives no momentum
  add_impulses(start, end, answer.first, R_);
  impulse_ = 0.5 * h * f_end_;
  add_impulses(end, start, answer.second, impulse_);
  multiply_mass(model, end, moved.nu, nu_after_);
  const auto judge = [&](const auto& before, const auto& after) {
    raise(e.newton_euler, before.cwiseAbs().maxCoeff());
    raise(e.newton_euler, after.cwiseAbs().maxCoeff());
  };
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv == 0) continue;
    const bool struck = !answer.struck.empty() && answer.struck[i] != 0;
    const auto part = [&](Vector& v) { return v.segment(b.v0, b.nv); };
    if (b.kind == BodyKind::Generalized) {
      const auto of = [&](const Instant& s) -> const Instant::GeneralizedMass& {
        return *std::find_if(s.masses.begin(), s.masses.end(),
                             [&](const auto& m) { return m.body == static_cast<int>(i); });
      };
      const Vector carried = of(end).M * (of(start).inverse * part(struck ? kick_ : R_));
      judge(part(momentum_) - part(R_), part(nu_after_) - carried - part(impulse_));
      continue;
    }
    if (b.kind != BodyKind::Spatial) {
      judge(part(momentum_) - part(R_), part(nu_after_) - part(struck ? kick_ : momentum_) - part(impulse_));
      continue;
    }
    // (b) M nu+ = T M nu_½ + h/2 f + W(q+) p_2
    const Quaternion T = rotation(-0.5 * h * half.segment<3>(b.v0 + 3));
    const auto linear = [&](const Vector& v) -> Vector3 { return v.segment<3>(b.v0); };
    const auto angular = [&](const Vector& v) -> Vector3 { return v.segment<3>(b.v0 + 3); };
    const Vector3 L = angular(momentum_);
    judge(linear(momentum_) - linear(R_),
          linear(nu_after_) - linear(struck ? kick_ : momentum_) - linear(impulse_));
    const Vector3 carried = struck ? Vector3(T * (T * angular(kick_))) : Vector3(T * L);
    judge(Vector3(T.conjugate() * L - angular(R_)),
          Vector3(angular(nu_after_) - carried - angular(impulse_)));
  }
}

}  // namespace perp
