// What an engine has to say to be measured, and the measurement: one run is one process and one line.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "scenes.hpp"

namespace peers {

/// A scene inside an engine.
class World {
 public:
  virtual ~World() = default;
  /// By the step that it was made with; an engine that chooses its steps takes the whole run.
  virtual void step() = 0;
  virtual Vec centre(std::size_t body) = 0;
  virtual bool whole_run() const { return false; }
  /// Steps taken, where the engine chooses them.
  virtual long steps() const { return 0; }
};

/// The world of a scene under a configuration of the engine; null where the engine has no such scene. `h` is the step, or
/// the tolerance of an engine that chooses its steps.
using MakeWorld =
    std::function<std::unique_ptr<World>(const Scene&, const std::string& configuration, double h)>;

/// The program of an engine: arguments SCENE CONFIGURATION H [SECONDS], one line on standard output:
/// scene,engine,version,configuration,h,steps,error,seconds,status. `error` [m] is the largest distance of a centre from where it
/// belongs at t_end; `seconds` the CPU time of the stepping loop alone, the median of up to five; a run that would take more than
/// SECONDS (2) is given up. status: ended|gave-up|diverged|has-not.
int measure(int argc, char** argv, const char* engine, const std::string& version, const MakeWorld& make);

}  // namespace peers
