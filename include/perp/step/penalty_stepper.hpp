// The compared other: contacts as stiff springs and dampers, friction regularised.
#pragma once

#include <memory>

#include "perp/step/stepper.hpp"

namespace perp {

struct PenaltyOptions {
  double stiffness = not_set;  ///< of every contact point [N/m] > 0; if not set (h/2)^-2/w_n of each, below
  double damping = not_set;    ///< of every contact point [N s/m] >= 0; if not set that of its restitution e
  double slip_speed =
      not_set;  ///< below it friction is viscous [m/s] > 0; if not set what loads give in a step
  bool explicit_forces = false;  ///< forces of the start of the step, in place of those of its end
};

/// A step of first order on the regularised model
///   p_n = h max(0, k d - c u_n) where the overlap d > 0,      p_f = -mu p_n u_f / max(|u_f|, v_s),
/// joint friction likewise, joints by (28) as in `lcp`. Implicit: d = -(psi_n + h u_n+), u = u+, with psi_n and the directions W of the
/// start, the damper of a contact that closes within the step for the part in which it is closed; one semismooth Newton on nu+ and the joints' impulses. Explicit: d = -psi_n, u = u of the start; then q+ = q ⊕ h nu+.
///
/// It tends to the model with rigid contacts as k grows and v_s falls, at h k^-1/2 small for each; it never holds a load still: what sticks
/// creeps at v_s |F|/(mu N). Where not set, k = 4/(h^2 w_n) with w_n the inverse mass at the point, which an explicit step follows;
/// c = 2 z sqrt(k/w_n), z = -ln e/sqrt(pi^2 + ln^2 e) the damping ratio that bounces with e alone on a rigid plane; v_s = h a, a the largest
/// acceleration of a contact point by loads.
/// Fails, and says so, where an explicit step cannot follow k and c (h^2 k w + 2 h c w > 4), Newton does not converge, or energy comes from nothing.
/// Residuals normal and friction are of these laws, as speeds. Energies: what springs of contacts store counts as taken by impacts.
class PenaltyStepper : public Stepper {
 public:
  explicit PenaltyStepper(PenaltyOptions options = {});
  ~PenaltyStepper() override;

  std::string_view name() const override { return "penalty"; }
  int order() const override { return 1; }
  const PenaltyOptions& options() const { return options_; }

 private:
  struct Workspace;
  void advance(const Model& model, State& x, const StepRequest& request, StepReport& report) override;
  std::unique_ptr<Stepper> anew() const override;

  PenaltyOptions options_;
  std::unique_ptr<Workspace> work_;
};

}  // namespace perp
