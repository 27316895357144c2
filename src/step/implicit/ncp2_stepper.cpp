#include "perp/step/ncp2_stepper.hpp"

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "step/certificate/certificate.hpp"
#include "step/certificate/step_gain.hpp"
#include "step/implicit/implicit_step.hpp"
#include "step/implicit/least_reactions.hpp"
#include "step/implicit/ncp2_first_stage.hpp"
#include "step/implicit/ncp2_second_stage.hpp"
#include "step/parts/free_rotation.hpp"
#include "step/parts/stable_step.hpp"
#include "step/run/step_record.hpp"

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

}  // namespace

struct Ncp2Stepper::Workspace {
  StartInstant start;
  Instant end, scratch;
  ContactDerivatives geometry;
  LastImpulses last;
  NonsmoothNewton newton;
  NewtonOutcome outcome;
  NewtonHistory history;
  StepReactions first;  // p_1
  SecondStage second;
  Vector nu, half, gained, kick, load, momentum;
  StepSpeeds speeds;
  StruckBodies jumped;
  StepAnswer answer;
  Certificate certificate;
  State next;

  bool move(const Model& model, const State& x, const StepRequest& request, double tolerance,
            StepReport& report);
  void carry_to_end(const Model& model, double h);
  void tell(const Model& model, const State& x, Reactions reactions, StepReport& report);
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

/// The first stage: q+, nu_½, p_1. False where it has no answer, and the report says so.
bool Ncp2Stepper::Workspace::move(const Model& model, const State& x, const StepRequest& request,
                                  double tolerance, StepReport& report) {
  const double h = request.h;
  do {
    const Instant& s = start.at(model, x, h);
    if (!s.fault.empty()) return give_up(report, StepStatus::NotFinite, s.fault), false;
    last.prepare(model, s, x);
    solve_mass(model, s, s.k, gained);
    gained *= h;
    nu = x.nu + 0.5 * gained;
    guess_rotations(model, s, x, h, nu);
    speeds.begin(model, s, x, gained, h, request.t_end, request.max_correction_speed, start.near());
    first.begin(model, s, x, h, 0.5 * h, last, speeds, nu);

    FirstStage problem(model, s, start.near(), x, request, end, scratch, geometry);
    const auto how = moving_from(model, x, h, {.speeds = speeds, .tolerance = tolerance});
    do {
      newton.solve(model, s, problem, how, nu, first.all, outcome);
      report.iterations += outcome.iterations;
      report.solver = outcome.solver;
      if (!end.fault.empty()) return give_up(report, StepStatus::NotFinite, end.fault), false;
      if (!outcome.converged)
        return give_up(model, x, request, "the first stage's residual", outcome.residuals, tolerance, report),
               false;
    } while (first.add_overlapping(s, speeds, end));
    next = problem.moved();
    problem.kick({}, kick);
  } while (start.widen(model, end));
  half = next.nu;
  history.residuals = outcome.history;
  return true;
}

/// The momentum that nu_½ carries to q+, with the second half of the loads: p_1 of what an impact changes has no part in it.
void Ncp2Stepper::Workspace::carry_to_end(const Model& model, double h) {
  loads_at(model, end, next, scratch, load);
  for (const Reaction& r : first.all) r.W.add_impulse(r.p, kick);
  carry(model, half, 2 * h, kick);  // half of the turn before nu_½, half after
  const Instant& s = start.instant();
  for (std::size_t i = 0; i < s.masses.size(); ++i) {
    const Body& b = model.bodies()[at(s.masses[i].body)];
    kick.segment(b.v0, b.nv) = end.masses[i].M * (s.masses[i].inverse * kick.segment(b.v0, b.nv));
  }
  momentum = kick + 0.5 * h * load;
}

/// The answer in the report's rows, and for the certificate.
void Ncp2Stepper::Workspace::tell(const Model& model, const State& x, Reactions reactions,
                                  StepReport& report) {
  const Instant& s = start.instant();
  const double speed = outcome.residuals.speed;
  const auto rows = [&] {
    begin_reactions(model, report);
    report_reactions(model, s, first.all, speed, report, 1);
    report_reactions(model, end, second.closed(), speed, report, 2);
    report_end(end, next, report);
  };
  rows();
  keep_impulses(model, first.all, report, next, last);
  for (double& p : last.row) p *= 2;
  for (double& p : last.friction) p *= 2;
  if (reactions == Reactions::MinimumNorm) {
    take_least(model, s, speed, first.all);
    take_least(model, end, speed, second.closed());
    if (!second.struck().any()) list_impulses(first.all, answer.first);
    rows();
  }
  answer.scheme = Scheme::Halves;
  answer.nu_q = half;
  answer.q_moved = next.q;
  list_impulses(second.closed(), answer.second);
  answer.struck.clear();
  if (second.struck().any()) answer.struck = second.struck().bodies();
  jumped = second.struck();
  for (const Reaction& r : second.closed())
    if (const ContactInstant* c = contact_of(r, s);
        c != nullptr && r.p.x() > 0 && approaches(*c, x, gained, speed))
      jumped.add(r);
  jumped.spread(second.closed());
  answer.jumped.clear();
  if (jumped.any()) answer.jumped = jumped.bodies();
}

void Ncp2Stepper::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Workspace& w = *work_;
  need_any_reactions(name(), model, options_.reactions);
  if (!w.move(model, x, request, options_.tolerance, report)) return;
  const Instant& s = w.start.instant();
  const double speed = w.outcome.residuals.speed;
  w.answer.h = request.h;
  w.answer.max_correction_speed = request.max_correction_speed;
  list_impulses(w.first.all, w.answer.first);

  const HalfStep step{model, s, w.end, x, w.gained, w.half, w.momentum, request.h, speed};
  w.second.close(step, w.first.all);
  w.carry_to_end(model, request.h);
  if (!w.second.solve(step, {.speeds = w.speeds, .tolerance = options_.tolerance}, w.next.nu,
                      report.iterations))
    return give_up(model, x, request, "the second stage's residual", w.second.outcome().residuals,
                   options_.tolerance, report);
  if (const std::string_view solver = w.second.outcome().solver;
      solver == "friction-chain" || solver == "ipopt")
    report.solver = solver;
  if (const std::string spring = unstable_spring(model, s, w.half, request.h, Damping::Midway, speed);
      !spring.empty())
    return give_up(report, StepStatus::NotSolved, spring);

  evaluate(model, w.next, w.end, &s, w.start.near());
  w.tell(model, x, options_.reactions, report);
  const double struck =
      w.certificate.certify(model, s, x, w.start.energy(model), w.end, w.next, w.answer, report);
  if (!keeps_energy(model, x, request, gain_of(model, s, x, w.next, w.answer, struck, request, report),
                    report))
    return;
  report.status = StepStatus::Solved;
  x = w.next;
  w.start.go_on_from(model, x, report.energy, w.end);
}

}  // namespace perp
