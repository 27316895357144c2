#include "step/implicit/ncp2_first_stage.hpp"

#include <algorithm>

#include "core/index.hpp"
#include "step/certificate/certificate.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
void loads_at(const Model& model, const Instant& s, State& at_nu, Instant& scratch, Vector& f) {
  const bool constant = !loads_vary(model, s);
  if (!constant) evaluate_loads(model, at_nu, scratch);
  f = constant ? s.k : scratch.k;
  const Vector& nu = constant ? s.nu : at_nu.nu;
  for (const Body& b : model.bodies()) {
    if (b.kind != BodyKind::Spatial) continue;
    const Vector3 w = nu.segment<3>(b.v0 + 3);
    f.segment<3>(b.v0 + 3) += w.cross(b.J * w);
  }
}

void carry(const Model& model, const Vector& nu, double h, Vector& y) {
  for (const Body& b : model.bodies()) {
    if (b.kind != BodyKind::Spatial) continue;
    const Vector3 w = nu.segment<3>(b.v0 + 3);
    y.segment<3>(b.v0 + 3) = rotation(-0.5 * h * w) * Vector3(y.segment<3>(b.v0 + 3));
  }
}

FirstStage::FirstStage(const Model& model, const Instant& start, const std::vector<int>* near, const State& x,
                       const StepRequest& request, Instant& end, Instant& scratch,
                       ContactDerivatives& geometry)
    : model_(model),
      start_(start),
      near_(near),
      x_(x),
      request_(request),
      end_(end),
      scratch_(scratch),
      geometry_(geometry) {
  multiply_mass(model, start, x.nu, momentum_);
  half_ = x;
}

bool FirstStage::evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) {
  if (!move_to_end(model_, x_, request_, nu, start_, near_, moved_, end_)) return false;
  half_.nu = nu;
  loads_at(model_, start_, half_, scratch_, load_);
  multiply_mass(model_, start_, nu, R);
  carry(model_, nu, -request_.h, R);
  R -= momentum_ + 0.5 * request_.h * load_;
  for (Reaction& r : reactions) place(nu, r);
  return true;
}

void FirstStage::differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) {
  const double h = request_.h;
  const Vector& nu = moved_.nu;
  const Motion motion(model_, nu, h);
  K.clear();
  add_mass(model_, start_, K);
  for (Coupling& c : K) {  // exp(a) (J - [J w]/2 h J_r(a)), a = h w/2
    const Body& b = model_.bodies()[at(c.row)];
    if (b.kind != BodyKind::Spatial) continue;
    const Vector3 w = nu.segment<3>(b.v0 + 3), a = 0.5 * h * w;
    c.value.bottomRightCorner<3, 3>() =
        rotation(a).toRotationMatrix() * (b.J - 0.5 * h * skew(b.J * w) * rotation_jacobian(a));
  }
  if (loads_vary(model_, start_)) {
    differentiate_loads(model_, half_, scratch_, loads_);
    for (LoadDerivative& load : loads_) load.xi.setZero();
    std::erase_if(loads_, [&](const LoadDerivative& load) { return load.gyroscopic; });
    add_loads(loads_, 0.5 * h, 0, motion, K);
  }
  active_.clear();
  for (const Reaction& r : reactions)
    if (const ContactInstant* c = contact_of(r, end_))
      if (r.law != Law::HalfLine) active_.push_back(static_cast<int>(c - end_.contacts.data()));
  geometry_.evaluate(model_, end_, active_);
  for (Reaction& r : reactions) slopes(motion, r);
}

void FirstStage::kick(const std::vector<Reaction>& reactions, Vector& y) const {
  y = momentum_ + 0.5 * request_.h * load_;
  for (const Reaction& r : reactions) r.W.add_impulse(r.p, y);
}

void FirstStage::place(const Vector& nu, Reaction& r) const {
  const double h = request_.h;
  if (r.of == Reaction::Of::JointRow) {
    r.u.x() = end_.joint_rows[at(r.source)].psi_b / h;
  } else if (r.of == Reaction::Of::JointFriction) {
    r.u.y() = 0.5 * (start_.joint_frictions[at(r.source)].velocity(nu) +
                     end_.joint_frictions[at(r.source)].velocity(nu));
  } else if (r.of == Reaction::Of::Moments) {
    const MomentInstant *before = moments_of(r, start_), *now = moments_of(r, end_);
    r.u.setZero();
    if (before == nullptr && now == nullptr) return;  // nor has its contact a load there
    r.u = r.lever * 0.5 *
          ((before == nullptr ? now : before)->velocity(nu) + (now == nullptr ? before : now)->velocity(nu));
  } else {
    const ContactInstant *before = contact_of(r, start_), *c = contact_of(r, end_);
    if (before == nullptr && c == nullptr) {
      r.u = {Reaction::no_point, 0, 0};
      return;
    }
    const double cap = h * request_.max_correction_speed;
    const double allowed = before == nullptr ? 0 : std::min(0.0, before->psi_n + cap);
    r.u = before == nullptr ? c->velocity(nu) : before->velocity(nu);
    if (c == nullptr) {
      r.u.x() += (before->psi_n - allowed) / h;
      return;
    }
    r.u = 0.5 * (r.u + c->velocity(nu));
    r.u.x() = (c->psi_n - allowed) / h;
  }
}

void FirstStage::slopes(const Motion& motion, Reaction& r) const {
  if (r.of == Reaction::Of::Contact) {
    const ContactInstant *before = contact_of(r, start_), *c = contact_of(r, end_);
    r.G.setZero();
    if (before != nullptr) r.G = slopes_of(before->W);
    if (c == nullptr) return;
    Reaction::Slope along = slopes_of(c->W);
    const double weight =
        before == nullptr ? 1 : 0.5;  // of the end; a point that came into being is all there
    r.G = (1 - weight) * r.G + weight * along;
    motion.turn(r.W, along);
    if (r.law != Law::HalfLine) {
      PairDerivative<3> d;
      perp::differentiate(model_, moved_, end_, *c,
                          geometry_[static_cast<std::size_t>(c - end_.contacts.data())], Vector3::Zero(), d);
      motion.turn(r.W, d.velocity);
      r.G += weight * motion.h() * d.velocity;
    }
    r.G.row(0) = along.row(0);
  } else if (r.of == Reaction::Of::Moments) {
    moment_slopes(motion, r);
  } else if (r.of == Reaction::Of::JointRow) {
    r.G = slopes_of(three_columns(end_.joint_rows[at(r.source)].W, 0));
    motion.turn(r.W, r.G);
  } else {
    const JointRowInstant& now = end_.joint_frictions[at(r.source)];
    PairDerivative<1> d;
    perp::differentiate(model_, end_, now, 0, d);
    motion.turn(r.W, d.velocity);
    r.G = 0.5 * (slopes_of(three_columns(start_.joint_frictions[at(r.source)].W, 1)) +
                 slopes_of(three_columns(now.W, 1)));
    r.G.row(1) += 0.5 * motion.h() * d.velocity;
  }
}

void FirstStage::moment_slopes(const Motion& motion, Reaction& r) const {
  const MomentInstant *before = moments_of(r, start_), *now = moments_of(r, end_);
  r.G.setZero();
  if (before != nullptr) r.G = r.lever * slopes_of(before->W);
  if (now == nullptr) return;
  const double weight = before == nullptr ? 1 : 0.5;  // of the end, as of its contact
  const ContactInstant& c = *contact_at(end_, r.source);
  PairDerivative<3> d;
  differentiate_moments(model_, moved_, end_, c,
                        geometry_[static_cast<std::size_t>(&c - end_.contacts.data())], Vector3::Zero(), d);
  motion.turn(r.W, d.velocity);
  r.G = (1 - weight) * r.G + weight * r.lever * (slopes_of(now->W) + motion.h() * d.velocity);
}

}  // namespace perp
