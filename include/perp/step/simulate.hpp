// From a first state to a time: step after step, none of them unsolved.
#pragma once

#include <functional>
#include <stdexcept>

#include "perp/step/trajectory.hpp"

namespace perp {

struct SimulateOptions {
  double t_end = not_set;  ///< [s] > x.t; required
  double h = not_set;  ///< [s] > 0; required by steppers of fixed step; of others rows at its multiples too
  bool project_initial = false;            ///< first moves x onto its constraints (project_onto_constraints)
  double max_correction_speed = infinity;  ///< cap on the speed at which an overlap is pushed out [m/s]
  std::function<bool(double t)> progress = {};  ///< called after every step; false ends the run there
  std::vector<UserEvent> events = {};           ///< what the run looks out for

  // Of a run of fixed steps that is made in pieces: x is its state after `taken` steps from t_start.
  double t_start = not_set;  ///< [s]; x.t if not set
  std::size_t taken = 0;
  double first_overlap = not_set;  ///< overlap() at t_start; that of x if not set
  std::size_t most = 0;            ///< steps to take now at most; 0: all to t_end
};

/// By how much contacts overlap or joints are open at x, the largest [m, rad]; 0 where they fit.
[[nodiscard]] double overlap(const Model& model, const State& x);

/// Where a run's rows go as they come, for runs that are not to be kept in memory. What a sink throws ends the run and comes out of
/// simulate().
class RunSink {
 public:
  virtual ~RunSink() = default;
  virtual void step(const State& x, const StepReport& report) = 0;  ///< one that advanced, to x
  virtual void event(const Event& event) { (void)event; }           ///< after the row it belongs to
};

/// How a run into a sink ended.
struct RunEnd {
  State x;                 ///< of the last step
  std::size_t steps = 0;   ///< taken now; of fixed steps those of the grid, each once
  bool reached = false;    ///< t_end; else `progress` ended it, or
  std::string stopped_by;  ///< the user's event of this name
  long evaluations = 0;    ///< of the right-hand side, of methods that have one
  double unseen = 0;       ///< Trajectory::unseen
};

/// A step that did not reach its tolerance: what it said, and the trajectory up to it. The one exception that a correct
/// program can meet.
class StepFailure : public std::runtime_error {
 public:
  StepFailure(StepReport report, Trajectory trajectory);
  const StepReport report;      ///< of the step that failed; report.t is where it would have ended
  const Trajectory trajectory;  ///< all steps before it
};

/// Takes n = max(1, round((t_end - x.t)/h)) steps of (t_end - x.t)/n, so that t_k = x.t + k (t_end - x.t)/n. A method
/// that chooses its steps (EventDriven) takes its own, and only needs t_end. Where a user's event does something the step is divided
/// there; a state that it changed is a row of its own, of length 0 and the same time.
/// Throws StepFailure at the first step that does not advance; std::invalid_argument for options or a state that it
/// cannot take.
[[nodiscard]] Trajectory simulate(const Model& model, Stepper& stepper, const State& x,
                                  const SimulateOptions& options);

/// The same, its rows given to `sink`: memory does not grow with the run. A StepFailure's trajectory then holds the last state alone.
[[nodiscard]] RunEnd simulate(const Model& model, Stepper& stepper, const State& x,
                              const SimulateOptions& options, RunSink& sink);

/// How far project_onto_constraints moved a state.
struct Projection {
  bool reached = false;  ///< whether the constraints hold now to the tolerance
  int iterations = 0;
  double moved = 0;           ///< largest change of a coordinate [m, rad]
  double moved_velocity = 0;  ///< largest change of a velocity [m/s, rad/s]
  double gap_min = infinity;  ///< afterwards [m]
  double joint_error = 0;     ///< afterwards [m, rad]
};

/// Assembly: moves x to the nearest state with psi_b = 0, psi_n >= 0 in the norm of M (its displacements d from where x was, as
/// positions and rotation vectors, make d^T M d stationary), then takes away the velocity that joints and closed contacts do not
/// allow (an impact without friction or restitution). Sequential quadratic programming: each step is the LCP of
///   min over s of (d + s)^T M (d + s),   psi_b + W_b^T s = 0,   psi_n + W_n^T s >= 0,
/// no longer than a third of a radian in any rotation. `tolerance` is relative to the largest violation at the start, or 1e-14 m
/// where that is less. Steps of at most 200.
[[nodiscard]] Projection project_onto_constraints(const Model& model, State& x, double tolerance = 1e-13);

}  // namespace perp
