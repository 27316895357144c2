#include "perp/step/event_driven.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "step/run/run_as_step.hpp"

namespace perp {

std::string_view name_of(Integrator integrator) {
  switch (integrator) {
    case Integrator::Arkode:
      return "arkode";
    case Integrator::CvodeAdams:
      return "cvode-adams";
    case Integrator::CvodeBdf:
      return "cvode-bdf";
    case Integrator::Ida:
      return "ida";
  }
  return "";
}

Integrator integrator_named(std::string_view name) {
  std::string known;
  for (const Integrator i :
       {Integrator::Arkode, Integrator::CvodeAdams, Integrator::CvodeBdf, Integrator::Ida}) {
    if (name_of(i) == name) return i;
    known.append(known.empty() ? "" : ", ").append(name_of(i));
  }
  refuse("integrator", "name", name, "needs to be one of: " + known);
}

EventDriven::EventDriven(EventDrivenOptions options) : options_(options) {
  const auto tolerance = [](const char* argument, double value) {
    if (!(value >= 1e-15 && value <= 1e-2))
      refuse("EventDriven", argument, value, "needs to be in [1e-15, 1e-2]");
  };
  tolerance("rtol", options.rtol);
  if (!std::isnan(options.atol)) tolerance("atol", options.atol);
  if (!std::isnan(options.look) && !(options.look > 0 && std::isfinite(options.look)))
    refuse("EventDriven", "look", options.look, "needs to be positive [s]");
}
EventDriven::~EventDriven() = default;
EventDriven::EventDriven(EventDriven&&) noexcept = default;
EventDriven& EventDriven::operator=(EventDriven&&) noexcept = default;

namespace {

/// The run of `options`, its stretches by SUNDIALS; between rows always by ARKODE, which starts at full order.
EventRun run_of(const Model& model, const EventDrivenOptions& options, Trajectory& rows) {
  const auto by = [rtol = options.rtol,
                   atol = std::isnan(options.atol) ? options.rtol : options.atol](Integrator kind) {
    return [=](ModeDynamics& dynamics) { return make_integrator(kind, dynamics, rtol, atol); };
  };
  return {model, options, by(options.integrator), by(Integrator::Arkode), rows};
}

}  // namespace

StepReport EventDriven::run(const Model& model, Trajectory& run, const RunRequest& request) {
  EventRun event_run = run_of(model, options_, run);
  (void)event_run.run(request);
  return event_run.report;
}

void EventDriven::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Trajectory rows(x, 0);
  EventRun event_run = run_of(model, options_, rows);
  (void)event_run.run({.t_end = request.t_end});
  take_as_step(rows, event_run.report, request.h, x, report);
}

}  // namespace perp
