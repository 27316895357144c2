#include "perp/step/event_driven.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "step/event_run.hpp"

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

StepReport EventDriven::run(const Model& model, Trajectory& run, const RunRequest& request) {
  EventRun event_run(model, options_, run);
  (void)event_run.run(request);
  return event_run.report;
}

void EventDriven::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Trajectory rows(x, 0);
  EventRun event_run(model, options_, rows);
  if (!event_run.run({.t_end = request.t_end})) {
    report = event_run.report;
    report.h = request.h;
    return;
  }
  const double h = report.h;
  report = event_run.report;
  report.h = h;
  for (std::size_t i = 0; i + 1 < rows.steps(); ++i) {  // what the rows before the last add
    const StepReport row = rows.report(i);
    report.iterations += row.iterations;
    for (double StepFigures::*energy :
         {&StepFigures::energy_friction, &StepFigures::energy_impact, &StepFigures::energy_load,
          &StepFigures::energy_motor, &StepFigures::energy_surface, &StepFigures::energy_left})
      report.*energy = std::isnan(report.*energy) ? row.*energy
                       : std::isnan(row.*energy)  ? report.*energy
                                                  : report.*energy + row.*energy;
    for (double Residuals::*part : {&Residuals::newton_euler, &Residuals::kinematic, &Residuals::joints,
                                    &Residuals::normal, &Residuals::friction})
      report.residuals.*part = std::fmax(report.residuals.*part, row.residuals.*part);
    for (const ContactRow& c : row.contacts) {
      const auto same = std::find_if(report.contacts.begin(), report.contacts.end(),
                                     [&](const ContactRow& r) { return r.point == c.point; });
      if (same == report.contacts.end()) {
        report.contacts.push_back(c);
        report.contacts.back().mode = ContactMode::Open;
        report.contacts.back().force.setZero();
        continue;
      }
      same->p_n += c.p_n;
      same->impulse += c.impulse;
    }
    for (std::size_t j = 0; j < report.joints.size(); ++j) {
      report.joints[j].impulse += row.joints[j].impulse;
      report.joints[j].moment += row.joints[j].moment;
      report.joints[j].friction += row.joints[j].friction;
    }
  }
  std::sort(report.contacts.begin(), report.contacts.end(),
            [](const ContactRow& a, const ContactRow& b) { return a.point < b.point; });
  x = rows.back();
}

}  // namespace perp
