#include "perp/step/ncp_stepper.hpp"

#include "perp/core/errors.hpp"
#include "step/certificate/certificate.hpp"
#include "step/certificate/step_gain.hpp"
#include "step/implicit/end_of_step.hpp"
#include "step/implicit/end_rebound.hpp"
#include "step/implicit/least_reactions.hpp"
#include "step/run/step_record.hpp"

namespace perp {

struct NcpStepper::Workspace {
  StartInstant start;
  Instant end;
  ContactDerivatives geometry;
  LastImpulses last;
  NonsmoothNewton newton;
  NewtonOutcome outcome;
  NewtonHistory history;
  StepReactions step;
  StepSpeeds speeds;
  EndRebound rebound;
  std::vector<Reaction> least;
  Vector nu, gained;
  State next;
  StepAnswer answer;
  Certificate certificate;

  bool move(const Model& model, const State& x, const StepRequest& request, const NcpStepperOptions& options,
            StepReport& report);
  void tell(const Model& model, const NcpStepperOptions& options, StepReport& report);
};

NcpStepper::NcpStepper(NcpStepperOptions options) : options_(options), work_(std::make_unique<Workspace>()) {
  if (!(options.tolerance > 0)) refuse("NcpStepper", "tolerance", options.tolerance, "needs to be positive");
}
NcpStepper::~NcpStepper() = default;
const StepAnswer* NcpStepper::answer() const { return &work_->answer; }
std::unique_ptr<Stepper> NcpStepper::anew() const { return std::make_unique<NcpStepper>(options_); }
NcpStepper::NcpStepper(NcpStepper&&) noexcept = default;
NcpStepper& NcpStepper::operator=(NcpStepper&&) noexcept = default;
const NewtonHistory& NcpStepper::history() const { return work_->history; }

/// q+ and the impulses that lead there, as if e were 0: `next`, `end`, `step`. False where there are none, and the report says so.
bool NcpStepper::Workspace::move(const Model& model, const State& x, const StepRequest& request,
                                 const NcpStepperOptions& options, StepReport& report) {
  const double h = request.h;
  do {
    const Instant& s = start.at(model, x, h);
    if (!s.fault.empty()) return give_up(report, StepStatus::NotFinite, s.fault), false;
    last.prepare(model, s, x);
    solve_mass(model, s, s.k, gained);
    gained *= h;
    nu = x.nu + gained;
    speeds.begin(model, s, x, gained, h, request.t_end, request.max_correction_speed, start.near());
    step.begin(model, s, x, h, h, last, speeds, nu);

    EndOfStep problem(model, s, start.near(), x, request, options.directions, end, geometry);
    const auto how = moving_from(model, x, h, {.speeds = speeds, .tolerance = options.tolerance});
    do {
      newton.solve(model, s, problem, how, nu, step.all, outcome);
      report.iterations += outcome.iterations;
      if (!end.fault.empty()) return give_up(report, StepStatus::NotFinite, end.fault), false;
    } while (outcome.converged && step.add_overlapping(s, speeds, end));
    next = problem.moved();
  } while (start.widen(model, end));
  history.residuals = outcome.history;
  report.solver = outcome.solver;
  if (!outcome.converged)
    give_up(model, x, request, "residual", outcome.residuals, options.tolerance, report);
  return outcome.converged;
}

/// The answer in the report's rows, and for the certificate.
void NcpStepper::Workspace::tell(const Model& model, const NcpStepperOptions& options, StepReport& report) {
  const bool ends = options.directions == Directions::End, struck = rebound.struck().any();
  const double speed = outcome.residuals.speed;
  const auto rows = [&](const std::vector<Reaction>& reactions) {
    begin_reactions(model, report);
    report_reactions(model, ends ? end : start.instant(), reactions, speed, report);
    report_end(end, next, report);
  };
  rows(step.all);
  keep_impulses(model, step.all, report, next, last);
  const std::vector<Reaction>* impulses = &step.all;
  if (options.reactions == Reactions::MinimumNorm) {
    least = step.all;
    take_least(model, end, speed, least);
    impulses = &least;
    rows(least);
  }
  answer.scheme = ends ? Scheme::End : Scheme::StartDirections;
  answer.q_moved = next.q;
  answer.second.clear();
  answer.struck.clear();
  list_impulses(*impulses, struck ? answer.second : answer.first);
  if (struck) answer.struck = rebound.struck().bodies();
  answer.jumped = answer.struck;
}

void NcpStepper::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Workspace& w = *work_;
  need_any_reactions(name(), model, options_.reactions);
  if (!w.move(model, x, request, options_, report)) return;
  const Instant& s = w.start.instant();
  w.answer.h = request.h;
  w.answer.max_correction_speed = request.max_correction_speed;
  w.answer.nu_q = w.next.nu;
  list_impulses(w.step.all, w.answer.first);

  const MovedStep step{model, s, w.end, x, w.gained, request.h, w.outcome.residuals.speed};
  w.rebound.find(step, w.step.all);
  if (w.rebound.struck().any()) {
    if (!w.rebound.solve(step, options_.directions, {.speeds = w.speeds, .tolerance = options_.tolerance},
                         w.newton, w.next.nu, w.step.all, report.iterations))
      return give_up(report, StepStatus::Inexact,
                     "the rebound's residual is " + shortest(w.rebound.residuals().largest()) + " m/s");
    evaluate(model, w.next, w.end, &s, w.start.near());
  }
  w.tell(model, options_, report);
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
