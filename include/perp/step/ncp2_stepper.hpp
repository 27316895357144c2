// The second-order step: a nonsmooth RATTLE with exact cones and a free rotation that keeps angular momentum.
#pragma once

#include <memory>

#include "perp/step/ncp_stepper.hpp"

namespace perp {

struct Ncp2StepperOptions {
  double tolerance = 1e-10;  ///< of the residuals, relative to the speeds that enter the step's equations [-]
  Reactions reactions =
      Reactions::Any;  ///< which are reported where contacts or joints are redundant; as for NcpStepper
};

/// Two stages [BCEL24], each an NCP with circular cones. The first moves q, with W_f at half weight from each end,
///   M nu_½ = T(nu_½) (M nu_l + h/2 f(q_l, nu_½, t_l) + W(q_l) p_1),      q+ = q_l ⊕ h nu_½
///   0 <= p_1n ⟂ psi_n(q+, t+) >= 0,   psi_b(q+, t+) = 0
///   |p_1f| <= mu p_1n, maximum work against (W_f(q_l) + W_f(q+))ᵀ nu_½/2 + (surface velocities)
/// the second finds nu+ at q+, over the contacts that the first closed,
///   M nu+ = T(nu_½) M nu_½ + h/2 f(q+, nu_½, t+) + W(q+) p_2
///   0 <= p_2n ⟂ u_n+ + e u_n- >= 0,   W_b(q+)ᵀ nu+ + dpsi_b/dt = 0
/// and friction: a contact that slid at nu_½ keeps -mu p_2n u_½/|u_½|, unless that would turn its slip round; one that stuck or
/// arrived has the cone at nu+. f are the loads without gyroscopic terms: T carries a body's angular momentum through half its turn,
/// exp(-h w_½/2) in body axes, so that free rotation keeps |L| to rounding. Order 2 in smooth motion and
/// through changes between slip and stick; 1 in the step of an impact.
///
/// p = p_1 + p_2. Restitution needs u_n-, the approach speed at the start. Redundant contacts and joints as in `ncp`.
class Ncp2Stepper : public Stepper {
 public:
  explicit Ncp2Stepper(Ncp2StepperOptions options = {});
  ~Ncp2Stepper() override;
  Ncp2Stepper(Ncp2Stepper&&) noexcept;
  Ncp2Stepper& operator=(Ncp2Stepper&&) noexcept;

  std::string_view name() const override { return "ncp2"; }
  int order() const override { return 2; }
  bool knows_moments() const override { return true; }
  bool halves() const override { return true; }
  const Ncp2StepperOptions& options() const { return options_; }
  const StepAnswer* answer() const override;
  const NewtonHistory& history() const;  ///< of the first stage

 private:
  struct Workspace;
  void advance(const Model& model, State& x, const StepRequest& request, StepReport& report) override;
  std::unique_ptr<Stepper> anew() const override;

  Ncp2StepperOptions options_;
  std::unique_ptr<Workspace> work_;
};

}  // namespace perp
