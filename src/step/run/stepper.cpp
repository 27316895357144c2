#include "perp/step/stepper.hpp"

#include <cmath>

#include "perp/core/errors.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {

std::string_view name_of(StepStatus status) {
  switch (status) {
    case StepStatus::Solved:
      return "solved";
    case StepStatus::Inexact:
      return "inexact";
    case StepStatus::NotSolved:
      return "not-solved";
    case StepStatus::NotFinite:
      return "not-finite";
  }
  return "";
}

std::string_view name_of(ContactMode mode) {
  switch (mode) {
    case ContactMode::Open:
      return "open";
    case ContactMode::Stick:
      return "stick";
    case ContactMode::Slip:
      return "slip";
  }
  return "";
}

ContactRow StepReport::contact(std::string_view name) const {
  const int point = point_names->find(name);
  if (point < 0) refuse("StepReport::contact", "name", name, "needs to be one of: " + point_names->known());
  for (const ContactRow& row : contacts)
    if (row.point == point) return row;
  return {.point = point};
}

JointImpulse StepReport::joint(std::string_view name) const {
  std::string known;
  for (std::size_t i = 0; i < joint_names->size(); ++i) {
    const std::string& full = (*joint_names)[i];
    const bool whole_joint = full.size() > name.size() && full.starts_with(name) && full[name.size()] == '.';
    if ((full == name || whole_joint) && i < joints.size()) return joints[i];
    known += (known.empty() ? "" : ", ") + full;
  }
  refuse("StepReport::joint", "name", name, "needs to be one of: " + known);
}

void Stepper::need_known_laws(const Model& model) const {
  if (!knows(model)) need_no_moments(name(), model);
}

StepReport Stepper::step(const Model& model, State& x, double h) {
  StepReport report;
  step(model, x, {.h = h}, report);
  return report;
}

void Stepper::step(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  if (!(request.h > 0) || !std::isfinite(request.h))
    refuse("step", "h", request.h, "needs to be positive [s]");
  if (!(request.max_correction_speed >= 0))
    refuse("step", "max_correction_speed", request.max_correction_speed, "needs to be >= 0 [m/s]");
  model.check("step", x);
  need_known_laws(model);
  StepRequest complete = request;
  if (std::isnan(request.t_end)) complete.t_end = x.t + request.h;
  static_cast<StepFigures&>(report) = {.t = complete.t_end, .h = request.h};
  report.message.clear();
  report.contacts.clear();
  report.joints.clear();
  report.halves.clear();
  report.point_names = model.point_names();
  report.joint_names = model.joint_names();
  advance(model, x, complete, report);
  if (report.advanced()) model.follow_turns(x);
}

}  // namespace perp
