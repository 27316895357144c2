#include "perp/step/trajectory.hpp"

#include <algorithm>
#include <stdexcept>

#include "perp/core/errors.hpp"

namespace perp {

std::string_view name_of(EventKind kind) {
  switch (kind) {
    case EventKind::Touch:
      return "touch";
    case EventKind::Lift:
      return "lift";
    case EventKind::Stick:
      return "stick";
    case EventKind::Slip:
      return "slip";
    case EventKind::Reverse:
      return "reverse";
    case EventKind::Stop:
      return "stop";
    case EventKind::Impact:
      return "impact";
    case EventKind::Zeno:
      return "zeno";
    case EventKind::Painleve:
      return "painleve";
    case EventKind::Load:
      return "load";
    case EventKind::User:
      return "user";
  }
  return "";
}

Trajectory::Trajectory(const State& x, std::size_t steps)
    : nq_(static_cast<std::size_t>(x.q.size())),
      nv_(static_cast<std::size_t>(x.nu.size())),
      windings_(static_cast<std::size_t>(x.winding.size())) {
  t_.reserve(steps + 1);
  q_.reserve((steps + 1) * nq_);
  nu_.reserve((steps + 1) * nv_);
  winding_.reserve((steps + 1) * windings_);
  figures_.reserve(steps);
  contacts_end_.reserve(steps);
  halves_end_.reserve(steps);
  joints_end_.reserve(steps);
  t_.push_back(x.t);
  q_.insert(q_.end(), x.q.begin(), x.q.end());
  nu_.insert(nu_.end(), x.nu.begin(), x.nu.end());
  winding_.insert(winding_.end(), x.winding.begin(), x.winding.end());
}

void Trajectory::reserve_rows(std::size_t contacts, std::size_t joints) {
  contacts_.reserve(contacts);
  joints_.reserve(joints);
}

void Trajectory::add(const State& x, const StepReport& report) {
  t_.push_back(x.t);
  q_.insert(q_.end(), x.q.begin(), x.q.end());
  nu_.insert(nu_.end(), x.nu.begin(), x.nu.end());
  winding_.insert(winding_.end(), x.winding.begin(), x.winding.end());
  figures_.push_back(report);
  contacts_.insert(contacts_.end(), report.contacts.begin(), report.contacts.end());
  halves_.insert(halves_.end(), report.halves.begin(), report.halves.end());
  joints_.insert(joints_.end(), report.joints.begin(), report.joints.end());
  contacts_end_.push_back(contacts_.size());
  halves_end_.push_back(halves_.size());
  joints_end_.push_back(joints_.size());
  if (!point_names_) {
    point_names_ = report.point_names;
    joint_names_ = report.joint_names;
  }
}

State Trajectory::state(std::size_t i) const {
  if (i >= size())
    throw std::out_of_range("Trajectory::state: " + std::to_string(i) + " of " + std::to_string(size()));
  using Map = Eigen::Map<const Vector>;
  return {.t = t_[i],
          .q = Map(q_.data() + i * nq_, static_cast<Eigen::Index>(nq_)),
          .nu = Map(nu_.data() + i * nv_, static_cast<Eigen::Index>(nv_)),
          .winding = Map(winding_.data() + i * windings_, static_cast<Eigen::Index>(windings_))};
}

StepReport Trajectory::report(std::size_t step) const {
  if (step >= steps())
    throw std::out_of_range("Trajectory::report: " + std::to_string(step) + " of " + std::to_string(steps()));
  const auto range = [step](const auto& all, const std::vector<std::size_t>& end) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(step == 0 ? 0 : end[step - 1]);
    return std::pair(first, all.begin() + static_cast<std::ptrdiff_t>(end[step]));
  };
  StepReport report;
  static_cast<StepFigures&>(report) = figures_[step];
  const auto [c0, c1] = range(contacts_, contacts_end_);
  report.contacts.assign(c0, c1);
  const auto [h0, h1] = range(halves_, halves_end_);
  report.halves.assign(h0, h1);
  const auto [j0, j1] = range(joints_, joints_end_);
  report.joints.assign(j0, j1);
  report.point_names = point_names_;
  report.joint_names = joint_names_;
  return report;
}

State Trajectory::at(double t) const {
  if (size() == 0 || !(t >= t_.front() && t <= t_.back()))
    refuse("Trajectory::at", "t", t, "needs to be within the run");
  const auto i = static_cast<std::size_t>(std::upper_bound(t_.begin(), t_.end(), t) - t_.begin()) - 1;
  if (t == t_[i]) return state(i);
  if (!between) refuse("Trajectory::at", "run", "rows alone", "needs a run of simulate(), or `between`");
  return between(*this, i, t);
}

bool takes_whole_runs(const Stepper& stepper) {
  return dynamic_cast<const AdaptiveStepper*>(&stepper) != nullptr;
}

bool chooses_steps(const Stepper& stepper) {
  const auto* runs = dynamic_cast<const AdaptiveStepper*>(&stepper);
  return runs != nullptr && runs->chooses();
}

}  // namespace perp
