// What a step's answer says of its own equations: residuals of the model's five parts, and where its energy went.
#pragma once

#include "perp/step/stepper.hpp"
#include "step/certificate/step_energy.hpp"
#include "step/implicit/nonsmooth_newton.hpp"

namespace perp {

/// The certificate: keeps its workspace, so that it allocates nothing from step to step.
class Certificate {
 public:
  /// Residuals and energies of `report` for the step from x to `moved`, whose instants are `start` and `end`; `energy` is that at x.
  /// Returns the work of all impulses of bodies that an impact within the step changes [J]: it only takes, if nothing is wrong.
  /// They come from x, x+, the impulses and velocities of `answer` and the model, from nothing that a solver said of itself.
  double certify(const Model& model, const Instant& start, const State& x, double energy, const Instant& end,
                 const State& moved, const StepAnswer& answer, StepReport& report);

 private:
  void whole(const Model& model, const Instant& start, const State& x, const Instant& end, const State& moved,
             const StepAnswer& answer, Residuals& e, StepEnergy& works);
  void halves(const Model& model, const Instant& start, const State& x, const Instant& end,
              const State& moved, const StepAnswer& answer, Residuals& e, StepEnergy& works);

  Vector impulse_, R_, f_start_, f_end_, nu_, momentum_, kick_, nu_after_;
  Instant scratch_;
  State scratch_state_;
};

/// The contact of a point, null where the instant does not have it.
[[nodiscard]] const ContactInstant* contact_at(const Instant& s, int point);

/// Least size of w F, F = p - projection of p - u/w onto the disc of radius `bound` [m/s].
[[nodiscard]] double disc_residual(const Vector2& p, const Vector2& u, double bound, double w);

/// The same on the polygon of those vertices in that disc, or on the disc, whichever is less: a friction impulse that sticks may lie
/// between both.
[[nodiscard]] double polygon_residual(const Vector2& p, const Vector2& u, double bound, double w,
                                      std::span<const Vector2> polygon);

/// How far q_end is from q ⊕ h nu [m, rad].
[[nodiscard]] double kinematic_residual(const Model& model, const Vector& q, const Vector& nu, double h,
                                        const Vector& q_end);

}  // namespace perp
