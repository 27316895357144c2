#include "step/run/step_record.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "step/certificate/closeness.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
bool touches(const ContactInstant& c, double h, double speed) {
  return closeness::touches(c.psi_n, h, speed);
}

bool separates(const ContactInstant& c, const State& x, const Vector& gained, double speed) {
  const double by_loads = 2 * std::abs(c.W.velocity(gained).x());
  return closeness::approaches(by_loads - c.velocity(x.nu).x(), speed);
}

bool approaches(const ContactInstant& c, const State& x, const Vector& gained, double speed) {
  const double by_loads = 2 * std::abs(c.W.velocity(gained).x());
  return closeness::approaches(c.velocity(x.nu).x() + by_loads, speed);
}

bool strikes(const ContactInstant& c, const State& x, const Vector& gained, double h, double speed) {
  return !touches(c, h, speed) && approaches(c, x, gained, speed);
}

namespace {

/// The rows of one joint in a report.
std::span<JointImpulse> rows_of(int joint, StepReport& report) {
  const auto [first, last] = std::ranges::equal_range(report.joints, joint, {}, &JointImpulse::joint);
  return {first, last};
}

/// What the joints' equations and friction gave, and where their coordinates are now.
void record_joints(const Model& model, const Instant& start, const Answer& answer, const Instant& end,
                   StepReport& report) {
  begin_joints(model, report);
  for (std::size_t i = 0; i < start.joint_rows.size(); ++i)
    add_joint_reaction(start.joint_rows[i], answer.reactions[static_cast<int>(i)], report);
  for (std::size_t i = 0; i < start.joint_frictions.size(); ++i) {
    const JointRowInstant& along = start.joint_frictions[i];
    const double p = answer.joint_friction[static_cast<int>(i)], rate = along.velocity(answer.nu);
    constexpr double rounding = 1e-10;  // of the speeds that enter the step: below it the joint is at rest
    const bool rests = std::abs(rate) <= rounding * answer.speed_scale;
    add_joint_friction(along, p, rests ? ContactMode::Stick : ContactMode::Slip, report);
  }
  end_joints(end, answer.nu, report);
}

}  // namespace

ContactRow contact_row(const ContactInstant& c, const Vector3& p, ContactMode mode) {
  return {.contact = c.contact,
          .point = c.point,
          .gap = c.psi_n,
          .p_n = p.x(),
          .normal = c.frame.col(0),
          .position = c.position,
          .impulse = c.frame * p,
          .mode = mode};
}

void begin_joints(const Model& model, StepReport& report) {
  report.joints.clear();
  report.joint_names = model.joint_names();
  for (int j = 0; j < static_cast<int>(model.joints().size()); ++j) {
    const int coordinates = static_cast<int>(model.joint({j}).coordinates.size());
    for (int i = 0; i < coordinates; ++i) report.joints.push_back({.joint = j, .coordinate = i});
    if (coordinates == 0) report.joints.push_back({.joint = j});
  }
}

void add_joint_reaction(const JointRowInstant& row, double p, StepReport& report) {
  for (JointImpulse& joint : rows_of(row.joint, report)) {
    joint.impulse += p * row.world.linear;
    joint.moment += p * row.world.angular_b;
  }
}

void add_joint_friction(const JointRowInstant& along, double p, ContactMode mode, StepReport& report) {
  for (JointImpulse& joint : rows_of(along.joint, report)) {
    if (joint.coordinate != along.coordinate) continue;
    joint.friction += p;
    joint.mode = mode;
  }
}

void end_joints(const Instant& end, const Vector& nu, StepReport& report) {
  for (JointImpulse& joint : report.joints) {
    if (joint.coordinate < 0) continue;
    const JointRowInstant& now = end.coordinate({joint.joint}, joint.coordinate);
    joint.value = now.psi_b;
    joint.rate = now.velocity(nu);
  }
}

namespace {

/// How far gaps may shrink in a step at the velocities at its start and those that loads alone give, with room to spare.
double reach(const Model& model, const Instant& s, double h, double lever) {
  constexpr double spare = 1.25;
  Vector gained;
  solve_mass(model, s, s.k, gained);
  double fastest = 0;
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    double speed = s.V[i].v.norm() + lever * s.V[i].w.norm();
    if (b.nv > 0) speed += h * std::max(1.0, lever) * gained.segment(b.v0, b.nv).norm();
    fastest = std::max(fastest, speed);
  }
  return 2 * spare * h * fastest;
}

}  // namespace

const Instant& StartInstant::at(const Model& model, const State& x, double h) {
  const bool known = revision_ == model.revision() && x.t == x_.t && x.q == x_.q && x.nu == x_.nu &&
                     x.winding.size() == x_.winding.size() && x.winding == x_.winding &&
                     (!contacts_.selective() || h == h_);
  if (known) return instant_;
  revision_ = model.revision();
  x_ = x;
  h_ = h;
  energy_ = not_set;
  if (model.touching_contacts() < NearContacts::worth_it) {
    evaluate(model, x, instant_);
    return instant_;
  }
  evaluate_loads(model, x, instant_);
  margin_ = reach(model, instant_, h, contacts_.lever(model));
  evaluate_near(model);
  return instant_;
}

void StartInstant::evaluate_near(const Model& model) {
  near_ = contacts_.find(model, instant_.X, x_.t, margin_);
  evaluate(model, x_, instant_, nullptr, near());
}

bool StartInstant::widen(const Model& model, const Instant& end) {
  if (!contacts_.selective()) return false;
  const double travel = contacts_.travel_to(model, end.X);
  if (travel <= margin_) return false;
  constexpr double spare = 1.5;
  margin_ = spare * travel;
  evaluate_near(model);
  return true;
}

double StartInstant::energy(const Model& model) {
  if (std::isnan(energy_)) energy_ = model.energy(x_);
  return energy_;
}

void StartInstant::go_on_from(const Model& model, const State& x, double energy, Instant& instant) {
  if (contacts_.selective()) return;  // the next step looks at other contacts
  std::swap(instant_, instant);
  revision_ = model.revision();
  x_ = x;
  energy_ = energy;
}

void Answer::clear(const Instant& instant, const Vector& nu_free) {
  const auto contacts = static_cast<Eigen::Index>(instant.contacts.size());
  nu = nu_free;
  impulse.setZero(nu_free.size());
  p.setZero(3, contacts);
  moments.setZero(3, instant.moments.empty() ? 0 : contacts);
  reactions.setZero(static_cast<Eigen::Index>(instant.joint_rows.size()));
  joint_friction.setZero(static_cast<Eigen::Index>(instant.joint_frictions.size()));
  slips.assign(instant.contacts.size(), 0);
  w.setConstant(contacts, not_set);
  normal_residual = friction_residual = speed_scale = 0;
  iterations = 0;
  solver = "none";
}

void record(const Model& model, const Instant& start, const Answer& answer, std::span<const int> active,
            const Instant& end, StepReport& report) {
  report.solver = answer.solver;
  report.iterations = answer.iterations;
  report.gap_min = end.gap_min();
  report.joint_error = end.joint_error();
  for (const int i : active) {
    const ContactInstant& c = start.contacts[at(i)];
    const Vector3 p = answer.p.col(i);
    const int now = end.contact_of_point[at(c.point)];
    const ContactMode closed = answer.slips[at(i)] != 0 ? ContactMode::Slip : ContactMode::Stick;
    report.contacts.push_back(contact_row(c, p, p.x() > 0 ? closed : ContactMode::Open));
    report.contacts.back().gap = now < 0 ? infinity : end.contacts[at(now)].psi_n;
    if (c.moments >= 0) report.contacts.back().moment = c.frame * answer.moments.col(i);
  }
  record_joints(model, start, answer, end, report);
}

void list_impulses(const Model& model, const Instant& start, const Answer& answer,
                   std::span<const int> active, const Vector& gap_term, std::vector<Acting>& all) {
  all.clear();
  for (const int i : active) {
    const ContactInstant& c = start.contacts[at(i)];
    all.push_back({.source = c.point, .p = answer.p.col(i), .w = answer.w[i], .gap = gap_term[i]});
    if (const MomentInstant* m = start.moments_of(c); m != nullptr)
      all.push_back({.of = Reaction::Of::Moments,
                     .source = c.point,
                     .p = answer.moments.col(i),
                     .lever = lever_of(model, start, c, *m)});
  }
  for (int i = 0; i < static_cast<int>(start.joint_rows.size()); ++i)
    all.push_back({.of = Reaction::Of::JointRow, .source = i, .p = {answer.reactions[i], 0, 0}});
  for (int i = 0; i < static_cast<int>(start.joint_frictions.size()); ++i)
    all.push_back({.of = Reaction::Of::JointFriction, .source = i, .p = {answer.joint_friction[i], 0, 0}});
}

}  // namespace perp
