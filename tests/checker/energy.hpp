// Energy from nothing: what a step gains beyond the work of loads and of what is driven, and whether that falls with the step.
#pragma once

#include "trial.hpp"

namespace checker {

/// Of a run's steps together: energy at their end less that at their start, less the work of loads that have no potential, of prescribed
/// bodies, of motions; and the size of what was added up.
struct Gain {
  double gain = 0, size = 0, rounding = 0;
  double loads = 0;  // the work of loads that have no potential, as taken off the gain
};
[[nodiscard]] Gain gain_of(const Step& s);

/// Steps that gain more than a hundredth of kinetic energy and work are taken again as 2, 4, ... 1024 steps: the gain has to fall to .6 of
/// itself each time until it is below a hundredth. Adds a fault "energy" where it does not.
void judge_energy(const Scene& scene, const Run& run, const std::string& method, const TrialOptions& options,
                  Trial& trial);

}  // namespace checker
