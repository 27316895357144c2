// A scene run by a method and judged: the one place that asks perp for anything, by its program or in this process.
#pragma once

#include <functional>

#include "judge.hpp"
#include "random_scene.hpp"

namespace checker {

enum class Ending { Done, Refused, Mistake, Unjudged };

struct Trial {
  Ending ending = Ending::Done;
  std::string reason;  // why it did not go to its end
  Judgement judgement;
  std::size_t undecided = 0;
  std::size_t wrong() const { return judgement.wrong_steps(); }
  std::size_t right() const { return judgement.steps - wrong(); }
};

struct TrialOptions {
  std::string program;    // perp's; empty: in this process
  std::string folder;     // for files; made if need be
  unsigned patience = 2;  // [s] of a run's own time
  bool energy = true;     // look for energy from nothing (in this process only)
};

[[nodiscard]] Trial try_scene(const RandomScene& random, const std::string& method,
                              const TrialOptions& options);

/// Runs the text of a scene file into files of `folder`. Returns why it did not reach its end, empty if it did; "mistake: ..." for input
/// that was not taken.
[[nodiscard]] std::string run_scene(const std::string& text, const std::string& method, double h,
                                    double until, const TrialOptions& options);

/// The smallest scene that still `fails`: things left out, the run begun at the step that fails, numbers made plain.
[[nodiscard]] RandomScene shrink(const RandomScene& random,
                                 const std::function<bool(const RandomScene&)>& fails);

/// The same scene where x begins.
[[nodiscard]] RandomScene begun_at(const RandomScene& random, const State& x);

/// Lengths times `length`, masses times `mass`, times by the square root of length; without motors and forces.
[[nodiscard]] RandomScene scaled(const RandomScene& random, double length, double mass);

/// How runs of a scene in two units differ; empty if places and speeds have the same nine digits.
[[nodiscard]] std::string units_differ(const RandomScene& random, const std::string& method, double length,
                                       double mass, const TrialOptions& options);

}  // namespace checker
