// Motion between events by SUNDIALS to a tolerance, events located to round-off.
#pragma once

#include <memory>
#include <string_view>

#include "perp/step/impact.hpp"
#include "perp/step/trajectory.hpp"

namespace perp {

enum class Integrator {
  Arkode,      ///< embedded Runge-Kutta; starts again at full order after an event
  CvodeAdams,  ///< Adams-Moulton, variable order to 12; starts at order 1
  CvodeBdf,    ///< backward differentiation, variable order to 5; starts at order 1
  Ida  ///< the differential-algebraic equations themselves, stabilised index 2, by backward differentiation
};

[[nodiscard]] std::string_view name_of(
    Integrator integrator);  ///< "arkode", "cvode-adams", "cvode-bdf", "ida"
/// Throws std::invalid_argument for a name that is none.
[[nodiscard]] Integrator integrator_named(std::string_view name);

/// Whether the library has SUNDIALS; without it EventDriven reports that it cannot run.
[[nodiscard]] bool has_sundials();

struct EventDrivenOptions {
  double rtol = 1e-10;    ///< of the local error, relative to each coordinate and velocity; in [1e-15, 1e-2]
  double atol = not_set;  ///< and absolute [m, rad, m/s, rad/s]; rtol if not set
  Integrator integrator = Integrator::Arkode;
  Restitution restitution = Restitution::Newton;
  ImpactOrder impacts = ImpactOrder::Simultaneous;
  /// The longest time between two looks at loads and motions that change with time, and at the user's events [s]; 1/4096 of the run if
  /// not set. Times at which a load says that it jumps (Timing) are met whatever it is.
  double look = not_set;
  long max_evaluations = 10'000'000;  ///< of the right-hand side in a run, which ends there with a report
};

/// The instantaneous model integrated: between events every contact is open, sticks or slips, and a differential equation (or,
/// with Ida, a differential-algebraic one) holds; where a mode ends the time is located, velocities jump if they must
/// (solve_impact), and CP1 says how it goes on.
///
/// Events end modes: psi_n = 0 (touch), c_n = 0 (lift), |u_f| = 0 (stick, reverse), |c_f| = mu c_n (slip), and the same of joints with
/// friction. A step in which one is bracketed is integrated again from its beginning to the time that a secant
/// method asks for, until the root function is at round-off: no state comes from an interpolant.
/// Gaps of closed contacts and joints are projected to zero after every step.
///
/// Each accepted step makes a row of the trajectory, each event two. doc/methods/event-driven.md has the details.
class EventDriven : public AdaptiveStepper {
 public:
  explicit EventDriven(EventDrivenOptions options = {});
  ~EventDriven() override;
  EventDriven(EventDriven&&) noexcept;
  EventDriven& operator=(EventDriven&&) noexcept;

  std::string_view name() const override { return "event"; }
  int order() const override { return 0; }
  bool knows_moments() const override { return true; }
  double tolerance() const override { return options_.rtol; }
  const EventDrivenOptions& options() const { return options_; }

  StepReport run(const Model& model, Trajectory& run, const RunRequest& request) override;

 private:
  void advance(const Model& model, State& x, const StepRequest& request, StepReport& report) override;

  EventDrivenOptions options_;
};

}  // namespace perp
