#include "step/implicit/implicit_step.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "step/certificate/certificate.hpp"
#include "step/certificate/closeness.hpp"
#include "step/parts/joint_projection.hpp"
#include "step/parts/moment_laws.hpp"
#include "step/run/step_record.hpp"

namespace perp {
namespace {

bool moves(const WrenchMap<3>& W) { return W.na + W.nb > 0; }

}  // namespace

Law law_of(const ContactInstant& c) {
  return c.tangents == 0 ? Law::HalfLine : c.tangents == 1 ? Law::Planar : Law::Cone;
}

namespace {

bool loads_follow_state(const Model& model) {
  return !model.springs().empty() || !model.forces().empty() || !model.joint_springs().empty() ||
         !model.motors().empty();
}

}  // namespace

bool loads_vary(const Model& model, const Instant& s) {
  return loads_follow_state(model) || !s.masses.empty();
}

bool move_to_end(const Model& model, const State& x, const StepRequest& request, const Vector& nu,
                 const Instant& start, const std::vector<int>* near, State& moved, Instant& end) {
  moved.t = request.t_end;
  moved.q = x.q;
  moved.winding = x.winding;
  moved.nu = nu;
  move(model, nu, request.h, moved.q);
  if (!moved.q.allFinite()) return false;
  perp::evaluate(model, moved, end, &start, near);
  return end.fault.empty();
}

NonsmoothNewton::Options moving_from(const Model& model, const State& x, double h,
                                     NonsmoothNewton::Options options) {
  options.start = &x;
  options.h = h;
  options.stiff = loads_follow_state(model);
  return options;
}

void LastImpulses::prepare(const Model& model, const Instant& s, const State& x) {
  if (revision == model.revision() && h > 0 && x.t == end.t && x.q == end.q && x.nu == end.nu &&
      row.size() == s.joint_rows.size() && friction.size() == s.joint_frictions.size())
    return;
  revision = model.revision();
  contact.reset(model.contact_points());
  moment.reset(model.contact_with_moments() == nullptr ? 0 : model.contact_points());
  row.assign(s.joint_rows.size(), 0);
  friction.assign(s.joint_frictions.size(), 0);
  h = 0;
}

void StepReactions::add_contact(const Instant& s, const ContactInstant& c, const Vector3& p,
                                const Vector3& moment, const StepSpeeds& speeds) {
  if (!moves(c.W)) return;
  Reaction& r = all.emplace_back();
  r.law = law_of(c);
  r.mu = c.mu;
  r.source = c.point;
  r.W = c.W;
  r.p.head(1 + c.tangents) = (c.frame.transpose() * p).head(1 + c.tangents);
  speeds.measure(r, &c);
  const MomentInstant* m = s.moments_of(c);
  if (m == nullptr) return;
  r.has_moments = true;
  Reaction& moments = all.emplace_back();
  moments.law = Law::Moments;
  moments.of = Reaction::Of::Moments;
  moments.source = c.point;
  moments.lever = speeds.lever_of(c, *m);
  place_moments(*m, moments);
  const Vector3 about = c.frame.transpose() * moment / moments.lever;
  if (m->torsion > 0) moments.p.x() = about.x();
  if (m->rolling > 0) moments.p.tail(c.tangents) = about.tail(c.tangents);
  speeds.measure_moments(moments, *m);
}

void StepReactions::begin(const Model& model, const Instant& s, const State& x, double h, double h_p,
                          const LastImpulses& last, const StepSpeeds& speeds, Vector& nu) {
  const double scale = last.h > 0 ? h_p / last.h : 0;
  all.clear();
  appeared_.clear();
  taken_.assign(s.contacts.size(), 0);
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const ContactInstant& c = s.contacts[i];
    const Vector3 p = scale * last.contact[at(c.point)];
    const Vector3 moment =
        last.moment.empty() ? Vector3::Zero().eval() : Vector3(scale * last.moment[at(c.point)]);
    const double rate = std::min(c.velocity(x.nu).x(), c.velocity(nu).x());
    if (c.psi_n + h * rate > 0 && p.isZero(0)) continue;
    taken_[i] = 1;
    add_contact(s, c, p, moment, speeds);
  }
  const auto add_joints = [&](const std::vector<JointRowInstant>& rows, const std::vector<double>& before,
                              Law law, Reaction::Of of, int column) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].W.na + rows[i].W.nb == 0) continue;
      Reaction& r = all.emplace_back();
      r.law = law;
      r.of = of;
      r.mu = rows[i].friction * h_p;
      r.source = static_cast<int>(i);
      r.W = three_columns(rows[i].W, column);
      r.p[column] = scale * before[i];
      speeds.measure(r);
    }
  };
  add_joints(s.joint_rows, last.row, Law::Equality, Reaction::Of::JointRow, 0);
  add_joints(s.joint_frictions, last.friction, Law::Interval, Reaction::Of::JointFriction, 1);

  Vector kick = Vector::Zero(nu.size()), moved;
  for (Reaction& r : all) {
    r.W.add_impulse(r.p, kick);
    if (r.of == Reaction::Of::JointRow) r.p.setZero();
  }
  solve_mass(model, s, kick, moved);
  nu += moved;
  // impulses that light bodies hand on hardly change from step to step, but enough to throw these about
  const bool thrown = std::any_of(all.begin(), all.end(), [&](const Reaction& r) {
    if (r.of != Reaction::Of::JointRow) return false;
    const JointRowInstant& row = s.joint_rows[at(r.source)];
    return r.length * std::abs(row.velocity(nu) - row.velocity(x.nu)) > r.speed;
  });
  if (!thrown) return;
  for (const Reaction& r : all) {
    if (r.of != Reaction::Of::JointRow) continue;
    nu.segment(r.W.va, r.W.na) = x.nu.segment(r.W.va, r.W.na);
    nu.segment(r.W.vb, r.W.nb) = x.nu.segment(r.W.vb, r.W.nb);
  }
}

bool StepReactions::add_overlapping(const Instant& s, const StepSpeeds& speeds, const Instant& end) {
  const std::size_t before = all.size();
  for (const ContactInstant& now : end.contacts) {
    if (!(now.psi_n < 0)) continue;
    const int then = s.contact_of_point[at(now.point)];
    if (then >= 0 ? taken_[at(then)] != 0
                  : std::find(appeared_.begin(), appeared_.end(), now.point) != appeared_.end())
      continue;
    if (then >= 0)
      taken_[at(then)] = 1;
    else
      appeared_.push_back(now.point);
    add_contact(then >= 0 ? s : end, then >= 0 ? s.contacts[at(then)] : now, Vector3::Zero(), Vector3::Zero(),
                speeds);
  }
  return all.size() > before;
}

const ContactInstant* contact_of(const Reaction& r, const Instant& s) {
  return r.of == Reaction::Of::Contact ? contact_at(s, r.source) : nullptr;
}

const MomentInstant* moments_of(const Reaction& r, const Instant& s) {
  const ContactInstant* c = r.of == Reaction::Of::Moments ? contact_at(s, r.source) : nullptr;
  return c == nullptr ? nullptr : s.moments_of(*c);
}

bool StruckBodies::add(const Reaction& r) {
  bool more = false;
  for (const auto& [body, n] : {std::pair(r.W.a, r.W.na), std::pair(r.W.b, r.W.nb)}) {
    if (n == 0 || struck_[at(body)] != 0) continue;
    struck_[at(body)] = 1;
    more = any_ = true;
  }
  return more;
}

void StruckBodies::spread(const std::vector<Reaction>& all) {
  for (bool more = any_; more;) {
    more = false;
    for (const Reaction& r : all)
      if (r.of == Reaction::Of::Moments)
        continue;  // with its contact
      else if (r.of != Reaction::Of::Contact || r.p.x() > 0)
        more = (touches(r) && add(r)) || more;
  }
}

bool StruckBodies::touches(const Reaction& r) const {
  return (r.W.na > 0 && struck_[at(r.W.a)] != 0) || (r.W.nb > 0 && struck_[at(r.W.b)] != 0);
}

Reaction::Slope slopes_of(const WrenchMap<3>& W) {
  Reaction::Slope G;
  G << W.A.transpose(), W.B.transpose();
  return G;
}

void add_mass(const Model& model, const Instant& instant, std::vector<Coupling>& K) {
  for (const Instant::GeneralizedMass& mass : instant.masses) {
    Coupling& c = K.emplace_back();
    c.row = c.column = mass.body;
    c.value.setZero();
    c.value.topLeftCorner(mass.M.rows(), mass.M.cols()) = mass.M;
  }
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv == 0 || b.kind == BodyKind::Generalized) continue;
    Coupling& c = K.emplace_back();
    c.row = c.column = static_cast<int>(i);
    c.value.setZero();
    const int linear = b.kind == BodyKind::Planar ? 2 : 3;
    c.value.diagonal().head(linear).setConstant(b.mass);
    if (b.kind == BodyKind::Planar) c.value(2, 2) = b.J(2, 2);
    if (b.kind == BodyKind::Spatial) c.value.bottomRightCorner<3, 3>() = b.J;
  }
}

void add_loads(const std::vector<LoadDerivative>& loads, double h_nu, double h_q, const Motion& motion,
               std::vector<Coupling>& K) {
  for (const LoadDerivative& load : loads) {
    Coupling& c = K.emplace_back();
    c.row = load.row;
    c.column = load.column;
    Eigen::Matrix<double, 6, 6> xi = load.xi;
    motion.turn_body(load.column, xi);
    c.value = -h_nu * load.nu - h_q * motion.h() * xi;
  }
}

void add_turning(const WrenchMap<3>& W, Eigen::Matrix<double, 12, 12> force, const Motion& motion,
                 std::vector<Coupling>& K) {
  motion.turn(W, force);
  const auto add = [&](int row, int column, int first_row, int first_column) {
    K.push_back({row, column, -motion.h() * force.block<6, 6>(first_row, first_column)});
  };
  if (W.na > 0) add(W.a, W.a, 0, 0);
  if (W.nb > 0) add(W.b, W.b, 6, 6);
  if (W.na > 0 && W.nb > 0) {
    add(W.a, W.b, 0, 6);
    add(W.b, W.a, 6, 0);
  }
}

bool VelocityLevel::evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) {
  multiply_mass(model_, instant_, nu, R);
  R -= momentum_;
  for (std::size_t i = 0; i < reactions.size(); ++i)
    reactions[i].u = velocities_[i].W.velocity(nu) + velocities_[i].bias;
  return true;
}

void VelocityLevel::differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) {
  K.clear();
  add_mass(model_, instant_, K);
  for (std::size_t i = 0; i < reactions.size(); ++i) reactions[i].G = slopes_of(velocities_[i].W);
}

bool slips(const Reaction& r, double speed) {
  if (r.law == Law::HalfLine) return true;
  // in a small step psi/h rounds to more, so that a contact that sticks may seem to slide: its friction tells
  const double bound = r.law == Law::Interval ? r.mu : r.mu * std::max(r.p.x(), 0.0);
  return !closeness::sticks(r.length * r.u.tail<2>().norm(), speed) &&
         closeness::on_bound(r.p.tail<2>().norm(), bound);
}

void give_up(StepReport& report, StepStatus status, std::string why) {
  report.status = status;
  report.message = std::move(why);
}

void give_up(const Model& model, const State& x, const StepRequest& request, std::string_view what,
             const StepResiduals& e, double tolerance, StepReport& report) {
  give_up(report, std::isfinite(e.largest()) ? StepStatus::Inexact : StepStatus::NotFinite,
          std::string(what) + " " + shortest(e.largest()) + " m/s is above " + shortest(tolerance) +
              " of the speed " + shortest(e.speed) + " m/s" +
              joints_at_odds(model, x, request.t_end, request.h));
}

void begin_reactions(const Model& model, StepReport& report) {
  report.contacts.clear();
  report.halves.clear();
  begin_joints(model, report);
}

namespace {

/// Adds a row to that of the same point, at its place; and to those of halves.
void add_row(const ContactRow& row, int half, StepReport& report) {
  const auto place = [](std::vector<ContactRow>& rows, const ContactRow& of) {
    return std::lower_bound(rows.begin(), rows.end(), of, [](const ContactRow& a, const ContactRow& b) {
      return a.point != b.point ? a.point < b.point : a.half < b.half;
    });
  };
  if (const auto sum = place(report.contacts, row); sum != report.contacts.end() && sum->point == row.point) {
    const ContactRow before = *sum;
    *sum = row;
    sum->p_n += before.p_n;
    sum->impulse += before.impulse;
    sum->moment += before.moment;
    if (row.mode == ContactMode::Open) sum->mode = before.mode;
  } else {
    report.contacts.insert(sum, row);
  }
  if (half == 0) return;
  ContactRow own = row;
  own.half = half;
  report.halves.insert(place(report.halves, own), own);
}

}  // namespace

void report_reactions(const Model& model, const Instant& s, const std::vector<Reaction>& reactions,
                      double speed, StepReport& report, int half) {
  if (report.joints.empty()) begin_joints(model, report);
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    if (r.of == Reaction::Of::JointFriction)
      add_joint_friction(s.joint_frictions[at(r.source)], r.p.y(),
                         slips(r, speed) ? ContactMode::Slip : ContactMode::Stick, report);
    if (r.of == Reaction::Of::JointRow) add_joint_reaction(s.joint_rows[at(r.source)], r.p.x(), report);
    const ContactInstant* c = contact_of(r, s);
    if (c == nullptr) continue;
    const bool slip = r.has_moments ? slides(r, reactions[i + 1], speed) : slips(r, speed);
    const ContactMode closed = slip ? ContactMode::Slip : ContactMode::Stick;
    ContactRow row = contact_row(*c, r.p, r.p.x() > 0 ? closed : ContactMode::Open);
    if (r.has_moments) row.moment = reactions[i + 1].lever * (c->frame * reactions[i + 1].p);
    add_row(row, half, report);
  }
}

void list_impulses(const std::vector<Reaction>& reactions, std::vector<Acting>& all) {
  all.clear();
  for (const Reaction& r : reactions) {
    Acting& one = all.emplace_back(Acting{.of = r.of, .source = r.source, .p = r.p, .w = r.w});
    if (r.of == Reaction::Of::JointFriction) one.p = {r.p.y(), 0, 0};
    if (r.of == Reaction::Of::Moments) {
      one.lever = r.lever;
      one.p *= r.lever;
    }
  }
}

void report_end(const Instant& end, const State& moved, StepReport& report) {
  report.gap_min = end.gap_min();
  report.joint_error = end.joint_error();
  end_joints(end, moved.nu, report);
  for (std::vector<ContactRow>* rows : {&report.contacts, &report.halves})
    for (ContactRow& row : *rows) {
      const int i = end.contact_of_point[at(row.point)];
      row.gap = i < 0 ? infinity : end.contacts[at(i)].psi_n;
    }
}

void keep_impulses(const Model& model, const std::vector<Reaction>& reactions, const StepReport& report,
                   const State& end, LastImpulses& last) {
  last.contact.reset(model.contact_points());
  last.moment.reset(last.moment.size());
  for (const ContactRow& row : report.contacts) {
    last.contact.set(row.point, row.impulse);
    if (!last.moment.empty()) last.moment.set(row.point, row.moment);
  }
  for (const Reaction& r : reactions) {
    if (r.of == Reaction::Of::JointRow) last.row[at(r.source)] = r.p.x();
    if (r.of == Reaction::Of::JointFriction) last.friction[at(r.source)] = r.p.y();
  }
  last.h = report.h;
  last.end = end;
  last.revision = model.revision();
}

}  // namespace perp
