// A run: states, and what every step said of itself.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "perp/step/stepper.hpp"

namespace perp {

/// States at t_0 .. t_n and the reports of the n steps between them. Stored flat: what a step adds is copied into space
/// reserved at the start.
class Trajectory {
 public:
  Trajectory() = default;
  /// Starts with x; makes room for `steps` more.
  Trajectory(const State& x, std::size_t steps);
  void reserve_rows(std::size_t contacts, std::size_t joints);  ///< rows of all steps together

  void add(const State& x, const StepReport& report);

  std::size_t size() const { return t_.size(); }         ///< states, the first included
  std::size_t steps() const { return figures_.size(); }  ///< size() - 1
  double t(std::size_t i) const { return t_[i]; }
  State state(std::size_t i) const;  ///< throws std::out_of_range past size()
  State front() const { return state(0); }
  State back() const { return state(size() - 1); }

  const StepFigures& figures(std::size_t step) const { return figures_[step]; }
  StepReport report(std::size_t step) const;  ///< of the step to state(step + 1)

 private:
  std::size_t nq_ = 0, nv_ = 0, windings_ = 0;
  std::vector<double> t_, q_, nu_, winding_;
  std::vector<StepFigures> figures_;
  std::vector<ContactRow> contacts_;
  std::vector<JointImpulse> joints_;
  std::vector<std::size_t> contacts_end_, joints_end_;  // of each step, in the two above
  std::shared_ptr<const std::vector<std::string>> point_names_, joint_names_;
};

}  // namespace perp
