// Integration in fixed modes, step by accepted step: what methods that locate events have between them.
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "perp/step/event_driven.hpp"
#include "step/events/row_sums.hpp"

namespace perp {

/// An initial value problem with its solver, one of SUNDIALS's or extrapolation. It keeps a reference to the dynamics, whose modes must stay as they
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

  /// Impulses and works of the last step; null of solvers that do not sum them.
  virtual const RowSums* sums() const { return nullptr; }

  std::string message;
  std::exception_ptr thrown;  ///< by a function of the user's within a step
};

/// Makes one for the dynamics of a run; null where there is none.
using MakeIntegrator = std::function<std::unique_ptr<ModeIntegrator>(ModeDynamics&)>;

/// Null if the library was built without SUNDIALS.
[[nodiscard]] std::unique_ptr<ModeIntegrator> make_integrator(Integrator kind, ModeDynamics& dynamics,
                                                              double rtol, double atol);

}  // namespace perp
