#include "perp/step/ncp2_stepper.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "solve/blocks/ellipsoid.hpp"
#include "step/certificate.hpp"
#include "step/closeness.hpp"
#include "step/free_rotation.hpp"
#include "step/impact_in_step.hpp"
#include "step/implicit_step.hpp"
#include "step/joint_projection.hpp"
#include "step/least_reactions.hpp"
#include "step/moment_laws.hpp"
#include "step/ncp2_first_stage.hpp"
#include "step/stable_step.hpp"
#include "step/step_gain.hpp"
#include "step/step_record.hpp"

namespace perp {
namespace {

/// Bodies that turn far in a step: first guesses of w_½ that solve their free rotation.
void guess_rotations(const Model& model, const Instant& s, const State& x, double h, Vector& nu) {
  constexpr double far = 0.5;  // [rad] a step
  for (const Body& b : model.bodies()) {
    if (b.kind != BodyKind::Spatial) continue;
    const Vector3 w = x.nu.segment<3>(b.v0 + 3), Jw = b.J * w;
    if (h * w.norm() < far) continue;
    const Vector3 torque = Vector3(s.k.segment<3>(b.v0 + 3)) + w.cross(Jw);
    nu.segment<3>(b.v0 + 3) = free_rotation(b.J, Jw + 0.5 * h * torque, h);
  }
}

/// How a reaction of the second stage came out of the first.
struct Slid {
  double e = 0, u_n_before = 0;  ///< restitution of a contact: u_n at the start of the step
  Vector3 direction =
      Vector3::Zero();  ///< u_½/|u_½| along t, o; zero: it stuck or arrived, and has its law at nu+
  /// Of a contact with moments: -p_f/p_n of what slid at u_½ (t, o, torsion), of what rolled (t, o); zero likewise.
  Vector3 sliding = Vector3::Zero();
  Vector2 rolling = Vector2::Zero();

  bool tied() const { return !direction.isZero(0) || !sliding.isZero(0) || !rolling.isZero(0); }
  void tie(const Reaction& contact, const Reaction& moments, double speed) {
    const SemiAxes axes = semi_axes_of(contact, moments);
    if (!axes.sliding.isZero(0) && slides(contact, moments, speed))
      sliding = ellipsoid_support_gradient(axes.sliding, {contact.u.y(), contact.u.z(), moments.u.x()});
    if (rolls(contact, moments, speed)) rolling = rolling_friction(axes.rolling, moments.u.tail<2>());
  }
  void untie() { direction.setZero(), sliding.setZero(), rolling.setZero(); }
};

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
bool untie_turned(Slid& slid, const Reaction& contact, const Reaction& moments) {
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

}  // namespace

struct Ncp2Stepper::Workspace {
  StartInstant start;
  Instant end, scratch;
  ContactDerivatives geometry;
  LastImpulses last;
  NonsmoothNewton newton, second_newton;
  NewtonOutcome outcome, second;
  NewtonHistory history;
  StepReactions first;                  // p_1
  std::vector<Reaction> closed, posed;  // p_2; what the second stage's Newton sees of them
  std::vector<Slid> slid;
  std::vector<RelativeVelocity> velocities;
  Vector nu, gained, kick, load, momentum;
  StepSpeeds speeds;
  StruckBodies struck, jumped;
  EnergyBefore energy;
  StepAnswer answer;
  Certificate certificate;
  State moved;

  void close(const Model& model, const Instant& s, const State& x, double h, double speed);
  bool solve_second(const Model& model, double tolerance, int& iterations);
  bool solve_rebound(const Model& model, const State& x, double tolerance, int& iterations);
};

Ncp2Stepper::Ncp2Stepper(Ncp2StepperOptions options)
    : options_(options), work_(std::make_unique<Workspace>()) {
  if (!(options.tolerance > 0)) refuse("Ncp2Stepper", "tolerance", options.tolerance, "needs to be positive");
}
Ncp2Stepper::~Ncp2Stepper() = default;
const StepAnswer* Ncp2Stepper::answer() const { return &work_->answer; }
std::unique_ptr<Stepper> Ncp2Stepper::anew() const { return std::make_unique<Ncp2Stepper>(options_); }
Ncp2Stepper::Ncp2Stepper(Ncp2Stepper&&) noexcept = default;
Ncp2Stepper& Ncp2Stepper::operator=(Ncp2Stepper&&) noexcept = default;
const NewtonHistory& Ncp2Stepper::history() const { return work_->history; }

/// The second stage's reactions: contacts that the first closed, with W at q+, and all joints. An impact's law is for all of its
/// impulse: p_1 of the bodies that it changes has moved q+ but gives no momentum, and the second stage finds the impulses of
/// the whole step, at all contacts that touch.
void Ncp2Stepper::Workspace::close(const Model& model, const Instant& s, const State& x, double h,
                                   double speed) {
  const auto closes = [](const Reaction& r) { return r.w * r.p.x() > r.u.x(); };
  struck.clear(model);
  for (const Reaction& r : first.all) {
    if (r.of != Reaction::Of::Contact || !closes(r)) continue;
    const ContactInstant* c = contact_of(r, s);  // null: it came into being, and was open before
    if (c == nullptr || strikes(*c, x, gained, h, speed)) struck.add(r);
  }
  struck.spread(first.all);

  closed.clear();
  velocities.clear();
  slid.clear();
  for (std::size_t i = 0; i < first.all.size(); ++i) {
    Reaction& r = first.all[i];
    Reaction next = r;
    next.rounding = 0;
    Vector3 b = Vector3::Zero();
    Slid how;
    const bool whole = struck.touches(r);
    if (whole) r.p.setZero();
    if (r.of == Reaction::Of::JointRow) {
      const JointRowInstant& row = end.joint_rows[at(r.source)];
      next.W = three_columns(row.W, 0);
      b.x() = row.psi_b_t;
    } else if (r.of == Reaction::Of::JointFriction) {
      const JointRowInstant& row = end.joint_frictions[at(r.source)];
      next.W = three_columns(row.W, 1);
      b.y() = row.psi_b_t;
      if (whole)
        next.mu *= 2;  // bounds of both halves of the step
      else if (slips(r, speed))
        how.direction.y() = r.u.y() > 0 ? 1 : -1;
    } else if (r.of == Reaction::Of::Moments) {
      if (closed.empty() || closed.back().of != Reaction::Of::Contact || closed.back().source != r.source)
        continue;  // its contact is open
      const MomentInstant& m = *moments_of(r, end);
      place_moments(m, next);
      b = r.lever * m.bias;
    } else {
      const ContactInstant *before = contact_of(r, s), *c = contact_of(r, end);
      const bool touched = before != nullptr && touches(*before, h, speed);
      if (c == nullptr || !(closes(next) || (whole && touched && !separates(*before, x, gained, speed))))
        continue;
      next.W = c->W;
      b = c->bias;
      how.e = c->e;
      how.u_n_before = (before == nullptr ? *c : *before).velocity(x.nu).x();
      const bool goes_on = touched && !whole && r.law != Law::HalfLine;
      if (goes_on && r.has_moments)
        how.tie(r, first.all[i + 1], speed);
      else if (goes_on && slips(r, speed))
        how.direction.tail<2>() = r.u.tail<2>().normalized();
    }
    closed.push_back(next);
    velocities.push_back({next.W, b});
    slid.push_back(how);
  }
}

/// Friction of what slid is tied to p_2n, or known; where that would turn a slip round, the law at nu+ takes its place.
bool Ncp2Stepper::Workspace::solve_second(const Model& model, double tolerance, int& iterations) {
  const Vector half = nu;
  for (;;) {
    posed.clear();
    Vector known = momentum;
    std::vector<RelativeVelocity> posed_velocities;
    std::vector<std::size_t> source;
    for (std::size_t i = 0; i < closed.size(); ++i) {
      Reaction& r = closed[i];
      const Vector3& d = slid[i].direction;
      if (!d.isZero(0) && r.of == Reaction::Of::JointFriction) {
        r.p = -r.mu * d;
        r.W.add_impulse(r.p, known);
        continue;
      }
      posed.push_back(r);
      posed_velocities.push_back(velocities[i]);
      source.push_back(i);
      if (r.has_moments) {
        Reaction moments = closed[i + 1];
        if (pose_with_moments(slid[i], posed.back(), moments)) {
          posed.push_back(moments);
          posed_velocities.push_back(velocities[i + 1]);
          source.push_back(i + 1);
        }
        ++i;
        continue;
      }
      if (d.isZero(0)) continue;
      Reaction& tied = posed.back();  // 0 <= p_n ⟂ u_n >= 0 with the column W_n - mu W_f d
      tied.law = Law::HalfLine;
      tied.W.A.col(0) -= r.mu * (r.W.A * d);
      tied.W.B.col(0) -= r.mu * (r.W.B * d);
      tied.p.tail<2>().setZero();
    }
    VelocityLevel level(model, end, known, posed_velocities);
    second_newton.solve(model, end, level, {.speeds = speeds, .tolerance = tolerance}, nu, posed, second);
    iterations += second.iterations;
    if (!second.converged) {  // with much friction the tied law need not have a solution
      bool tied = false;
      for (Slid& s : slid) {
        tied = tied || s.tied();
        s.untie();
      }
      if (!tied) return false;
      nu = half;
      continue;
    }
    for (std::size_t k = 0; k < posed.size(); ++k) {
      Reaction& r = closed[source[k]];
      r.p = posed[k].p;
      if (const Vector3& d = slid[source[k]].direction; !d.isZero(0))
        r.p.tail<2>() = -r.mu * r.p.x() * d.tail<2>();
    }
    for (std::size_t i = 0; i < closed.size(); ++i)
      if (closed[i].has_moments) give_tied(slid[i], closed[i], closed[i + 1]);
    bool turned = false;
    for (std::size_t i = 0; i < closed.size(); ++i) {
      closed[i].u = velocities[i].W.velocity(nu) + velocities[i].bias;
      if (slid[i].direction.isZero(0) || closed[i].u.dot(slid[i].direction) >= 0) continue;
      slid[i].direction.setZero();
      turned = true;
    }
    for (std::size_t i = 0; i < closed.size(); ++i)
      if (closed[i].has_moments && untie_turned(slid[i], closed[i], closed[i + 1])) turned = true;
    if (!turned) return true;
  }
}

/// The second stage with restitution: of an impact with a law that adds no energy.
bool Ncp2Stepper::Workspace::solve_rebound(const Model& model, const State& x, double tolerance,
                                           int& iterations) {
  const auto restitute = [&](Rebound law) {
    for (std::size_t i = 0; i < slid.size(); ++i)
      velocities[i].bias.x() += restitution_term(law, slid[i].e, slid[i].u_n_before);
  };
  if (!struck.any()) {
    restitute(Rebound::Newton);
    return solve_second(model, tolerance, iterations);
  }
  const Vector half = nu;
  const auto posed_closed = closed;
  const auto posed_velocities = velocities;
  const auto posed_slid = slid;
  Vector free;
  solve_mass(model, end, momentum, free);
  energy.set(model, end, x.nu, free, [&](std::size_t body) { return struck[body]; });
  for (const Rebound law : rebounds) {
    nu = half;
    closed = posed_closed;
    velocities = posed_velocities;
    slid = posed_slid;
    restitute(law);
    if (!solve_second(model, tolerance, iterations)) return false;
    if (!energy.exceeded(model, end, nu)) break;
  }
  return true;
}

void Ncp2Stepper::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Workspace& w = *work_;
  const Instant& s = w.start.at(model, x, request.h);
  const double h = request.h;
  const auto fail = [&](StepStatus status, const std::string& why) {
    report.status = status;
    report.message = why;
  };
  const auto inexact = [&](std::string_view stage, const StepResiduals& e) {
    fail(std::isfinite(e.largest()) ? StepStatus::Inexact : StepStatus::NotFinite,
         "the " + std::string(stage) + " stage's residual " + shortest(e.largest()) + " m/s is above " +
             shortest(options_.tolerance) + " of the speed " + shortest(e.speed) + " m/s" +
             joints_at_odds(model, x, request.t_end, h));
  };
  if (!s.fault.empty()) return fail(StepStatus::NotFinite, s.fault);
  need_any_reactions(name(), model, options_.reactions);

  // first stage
  w.last.prepare(model, s, x);
  solve_mass(model, s, s.k, w.gained);
  w.gained *= h;
  w.nu = x.nu + 0.5 * w.gained;
  guess_rotations(model, s, x, h, w.nu);
  w.speeds.begin(model, s, x, w.gained, h, request.t_end, request.max_correction_speed, w.start.near());
  w.first.begin(model, s, x, h, 0.5 * h, w.last, w.speeds, w.nu);

  FirstStage problem(model, s, w.start.near(), x, request, w.end, w.scratch, w.geometry);
  const NonsmoothNewton::Options how{.speeds = w.speeds, .tolerance = options_.tolerance};
  const NonsmoothNewton::Options at_first = moving_from(model, x, h, how);
  do {
    w.newton.solve(model, s, problem, at_first, w.nu, w.first.all, w.outcome);
    report.iterations += w.outcome.iterations;
    report.solver = w.outcome.solver;
    if (!w.end.fault.empty()) return fail(StepStatus::NotFinite, w.end.fault);
    if (!w.outcome.converged) return inexact("first", w.outcome.residuals);
  } while (w.first.add_overlapping(s, w.speeds, w.end));
  if (w.start.widen(model, w.end)) return advance(model, x, request, report);
  w.history.residuals = w.outcome.history;
  w.moved = problem.moved();
  const Vector half = w.moved.nu;
  const double speed = w.outcome.residuals.speed;

  // second stage, from the momentum that nu_½ carries to q+
  list_impulses(w.first.all, w.answer.first);
  w.close(model, s, x, h, speed);
  loads_at(model, w.end, w.moved, w.scratch, w.load);
  problem.kick(w.first.all, w.kick);
  carry(model, half, 2 * h, w.kick);  // half of the turn before nu_½, half after
  for (std::size_t i = 0; i < s.masses.size(); ++i) {
    const Body& b = model.bodies()[at(s.masses[i].body)];
    w.kick.segment(b.v0, b.nv) =
        w.end.masses[i].M * (s.masses[i].inverse * w.kick.segment(b.v0, b.nv));  // of the same nu_½
  }
  w.momentum = w.kick + 0.5 * h * w.load;
  w.nu = half;
  if (!w.solve_rebound(model, x, options_.tolerance, report.iterations))
    return inexact("second", w.second.residuals);
  if (w.second.solver == "friction-chain" || w.second.solver == "ipopt") report.solver = w.second.solver;

  w.moved.nu = w.nu;
  if (const std::string spring = unstable_spring(model, s, half, h, Damping::Midway, speed); !spring.empty())
    return fail(StepStatus::NotSolved, spring);
  evaluate(model, w.moved, w.end, &s, w.start.near());
  const auto rows = [&] {
    begin_reactions(model, report);
    report_reactions(model, s, w.first.all, speed, report, 1);
    report_reactions(model, w.end, w.closed, speed, report, 2);
    report_end(w.end, w.moved, report);
  };
  rows();
  keep_impulses(model, w.first.all, report, w.moved, w.last);
  for (std::size_t i = 0; i < w.last.row.size(); ++i) w.last.row[i] *= 2;
  for (double& p : w.last.friction) p *= 2;
  if (options_.reactions == Reactions::MinimumNorm) {
    take_least(model, s, speed, w.first.all);
    take_least(model, w.end, speed, w.closed);
    if (!w.struck.any()) list_impulses(w.first.all, w.answer.first);
    rows();
  }
  StepAnswer& answer = w.answer;
  answer.scheme = Scheme::Halves;
  answer.h = h;
  answer.max_correction_speed = request.max_correction_speed;
  answer.nu_q = half;
  answer.q_moved = w.moved.q;
  list_impulses(w.closed, answer.second);
  answer.struck.clear();
  if (w.struck.any()) answer.struck = w.struck.bodies();
  w.jumped = w.struck;
  for (const Reaction& r : w.closed)
    if (const ContactInstant* c = contact_of(r, s);
        c != nullptr && r.p.x() > 0 && approaches(*c, x, w.gained, speed))
      w.jumped.add(r);
  w.jumped.spread(w.closed);
  answer.jumped.clear();
  if (w.jumped.any()) answer.jumped = w.jumped.bodies();
  const double struck =
      w.certificate.certify(model, s, x, w.start.energy(model), w.end, w.moved, answer, report);
  if (!keeps_energy(model, x, request, gain_of(model, s, x, w.moved, answer, struck, request, report),
                    report))
    return;
  report.status = StepStatus::Solved;
  x = w.moved;
  w.start.go_on_from(model, x, report.energy, w.end);
}

}  // namespace perp
