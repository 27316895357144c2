#include "step/implicit_step.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Law law_of(const ContactInstant& c) {
  return c.tangents == 0 ? Law::HalfLine : c.tangents == 1 ? Law::Planar : Law::Cone;
}

bool moves(const WrenchMap<3>& W) { return W.na + W.nb > 0; }

}  // namespace

void LastImpulses::prepare(const Model& model, const Instant& s, const State& x) {
  if (revision == model.revision() && h > 0 && x.t == end.t && x.q == end.q && x.nu == end.nu &&
      row.size() == s.joint_rows.size() && friction.size() == s.joint_frictions.size())
    return;
  revision = model.revision();
  contact.assign(at(model.contact_points()), Vector3::Zero());
  row.assign(s.joint_rows.size(), 0);
  friction.assign(s.joint_frictions.size(), 0);
  h = 0;
}

void make_reactions(const Model& model, const Instant& s, std::span<const int> active,
                    const LastImpulses& last, double h, std::vector<Reaction>& out) {
  out.clear();
  const double scale = last.h > 0 ? h / last.h : 0;
  for (const int i : active) {
    const ContactInstant& c = s.contacts[at(i)];
    if (!moves(c.W)) continue;
    Reaction& r = out.emplace_back();
    r.law = law_of(c);
    r.mu = c.mu;
    r.source = c.point;
    r.W = c.W;
    r.p = scale * (c.frame.transpose() * last.contact[at(c.point)]);
    for (int j = c.tangents + 1; j < 3; ++j) r.p[j] = 0;
  }
  const auto joint = [&](const JointRowInstant& row, std::size_t i, Law law, Reaction::Of of, int column,
                         double p) {
    if (row.W.na + row.W.nb == 0) return;
    Reaction& r = out.emplace_back();
    r.law = law;
    r.of = of;
    r.mu = row.friction * h;
    r.source = static_cast<int>(i);
    r.W = three_columns(row.W, column);
    r.p[column] = p;
  };
  for (std::size_t i = 0; i < s.joint_rows.size(); ++i)
    joint(s.joint_rows[i], i, Law::Equality, Reaction::Of::JointRow, 0, scale * last.row[i]);
  for (std::size_t i = 0; i < s.joint_frictions.size(); ++i)
    joint(s.joint_frictions[i], i, Law::Interval, Reaction::Of::JointFriction, 1, scale * last.friction[i]);
  (void)model;
}

const ContactInstant* contact_of(const Reaction& r, const Instant& s) {
  if (r.of != Reaction::Of::Contact) return nullptr;
  const int i = s.contact_of_point[at(r.source)];
  return i < 0 ? nullptr : &s.contacts[at(i)];
}

Reaction::Slope slopes_of(const WrenchMap<3>& W) {
  Reaction::Slope G;
  G << W.A.transpose(), W.B.transpose();
  return G;
}

void add_mass(const Model& model, std::vector<Coupling>& K) {
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv == 0) continue;
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
  multiply_mass(model_, nu, R);
  R -= momentum_;
  for (std::size_t i = 0; i < reactions.size(); ++i)
    reactions[i].u = velocities_[i].W.velocity(nu) + velocities_[i].bias;
  return true;
}

void VelocityLevel::differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) {
  K.clear();
  add_mass(model_, K);
  for (std::size_t i = 0; i < reactions.size(); ++i) reactions[i].G = slopes_of(velocities_[i].W);
}

bool slips(const Reaction& r, double speed) {
  constexpr double rounding = 1e-9;  // of the step's speeds
  return r.law == Law::HalfLine || r.u.tail<2>().norm() > rounding * speed;
}

void report_reactions(const Instant& s, const std::vector<Reaction>& reactions, const Vector& before,
                      const Vector& after, double speed, StepReport& report) {
  const Vector mean = 0.5 * (before + after);
  std::size_t next = 0, next_joint = 0;
  for (const Reaction& r : reactions) {
    if (r.of == Reaction::Of::JointFriction) {
      const JointRowInstant& joint = s.joint_frictions[at(r.source)];
      report.energy_friction += r.p.y() * joint.velocity(mean);
      if (next_joint == report.joints.size()) report.joints.push_back({.joint = joint.joint, .friction = 0});
      report.joints[next_joint++].friction += r.p.y();
    }
    const ContactInstant* c = contact_of(r, s);
    if (c == nullptr) continue;
    const Vector3 u = c->velocity(mean);
    report.energy_impact += r.p.x() * u.x();
    report.energy_friction += r.p.tail<2>().dot(u.tail<2>());
    while (next < report.contacts.size() && report.contacts[next].point != r.source) ++next;
    if (next == report.contacts.size())
      report.contacts.push_back({.contact = c->contact, .point = r.source, .p_n = 0});
    ContactRow& row = report.contacts[next];
    row.p_n += r.p.x();
    row.normal = c->frame.col(0);
    row.position = c->position;
    row.impulse += c->frame * r.p;
    if (r.p.x() > 0) row.mode = slips(r, speed) ? ContactMode::Slip : ContactMode::Stick;
  }
}

void report_end(const Model& model, const Instant& end, const State& moved, StepReport& report) {
  report.gap_min = end.gap_min();
  report.joint_error = end.joint_error();
  report.energy = model.energy(moved);
  for (ContactRow& row : report.contacts) {
    const int i = end.contact_of_point[at(row.point)];
    row.gap = i < 0 ? infinity : end.contacts[at(i)].psi_n;
  }
}

void keep_impulses(const Model& model, const std::vector<Reaction>& reactions, const StepReport& report,
                   const State& end, LastImpulses& last) {
  std::fill(last.contact.begin(), last.contact.end(), Vector3::Zero());
  for (const ContactRow& row : report.contacts) last.contact[at(row.point)] = row.impulse;
  for (const Reaction& r : reactions) {
    if (r.of == Reaction::Of::JointRow) last.row[at(r.source)] = r.p.x();
    if (r.of == Reaction::Of::JointFriction) last.friction[at(r.source)] = r.p.y();
  }
  last.h = report.h;
  last.end = end;
  last.revision = model.revision();
}

double gap_rounding(const State& x, double h) {
  return 4 * std::numeric_limits<double>::epsilon() * std::max(1.0, x.q.cwiseAbs().maxCoeff()) / h;
}

}  // namespace perp
