// Motion between events by extrapolated contact steps, of order 4, 6, 8 or to a tolerance; events located to round-off.
#pragma once

#include "perp/step/impact.hpp"
#include "perp/step/trajectory.hpp"

namespace perp {

struct ExtrapolatedOptions {
  /// 2, 4, 6, ..., 16: of steps of the size that simulate() is asked for, cut at events and loads that jump. 0: order and steps are chosen
  /// by the tolerance.
  int order = 0;
  double rtol = 1e-10;    ///< of the local error, relative to each coordinate and velocity; in [1e-15, 1e-2]
  double atol = not_set;  ///< and absolute [m, rad, m/s, rad/s]; rtol if not set
  Restitution restitution = Restitution::Newton;
  ImpactOrder impacts = ImpactOrder::Simultaneous;
  double look = not_set;              ///< as EventDrivenOptions::look [s]
  long max_evaluations = 10'000'000;  ///< of substeps in a run, which ends there with a report
};

/// Between events every contact is open, sticks or slips. There a step is made of columns of 2, 4, 6, ... substeps, each a contact step in
/// these modes: half-explicit, its impulses those with which velocities at its end obey joints and contacts, one linear system. Errors have
/// an expansion in h^2, and a column takes away one term: order 2 K of K columns, in positions, orientations (as rotation vectors from those
/// of the first column) and velocities. A substep keeps nothing of another column's.
///
/// Events are EventDriven's and located as there, by steps whose length is the unknown: no state is interpolated. Where modes cannot be agreed
/// on, a step with circular cones and e = 0 leads across, and events say so (EventKind::Zeno). It needs no SUNDIALS.
/// doc/methods/extrapolated.md has the details.
class Extrapolated : public AdaptiveStepper {
 public:
  /// Throws std::invalid_argument for an order that is odd, negative or above 16, and tolerances out of range.
  explicit Extrapolated(ExtrapolatedOptions options = {});

  std::string_view name() const override { return "extrapolated"; }
  int order() const override { return options_.order; }
  bool knows_moments() const override { return true; }
  double tolerance() const override { return options_.rtol; }
  bool chooses() const override { return options_.order == 0; }
  const ExtrapolatedOptions& options() const { return options_; }

  StepReport run(const Model& model, Trajectory& run, const RunRequest& request) override;

 private:
  void advance(const Model& model, State& x, const StepRequest& request, StepReport& report) override;

  ExtrapolatedOptions options_;
};

}  // namespace perp
