// Integration in fixed modes, step by accepted step: what SUNDIALS does for the event-driven method.
#pragma once

#include <exception>
#include <memory>
#include <string>
#include <string_view>

#include "perp/step/event_driven.hpp"
#include "step/mode_dynamics.hpp"

namespace perp {

/// An initial value problem with one of SUNDIALS's solvers. It keeps a reference to the dynamics, whose modes must stay as they
/// are from start() on.
class ModeIntegrator {
 public:
  virtual ~ModeIntegrator() = default;
  virtual std::string_view name() const = 0;

  /// From x, with a first step near h (0: the solver's own guess).
  virtual bool start(const State& x, double h) = 0;

  /// One step, of the solver's own size but not past t_stop. x is on the constraints. False with `message` if it failed; x is then
  /// as it was.
  virtual bool step(double t_stop, State& x) = 0;

  std::string message;
  std::exception_ptr thrown;  ///< by a function of the user's within a step
};

/// Null if the library was built without SUNDIALS.
[[nodiscard]] std::unique_ptr<ModeIntegrator> make_integrator(Integrator kind, ModeDynamics& dynamics,
                                                              double rtol, double atol);

}  // namespace perp
