#include "step/run/run_as_step.hpp"

#include <algorithm>
#include <cmath>

namespace perp {

void take_as_step(const Trajectory& rows, const StepReport& last, double h, State& x, StepReport& report) {
  report = last;
  report.h = h;
  if (!last.advanced()) return;
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
