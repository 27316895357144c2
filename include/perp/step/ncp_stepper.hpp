// The fully implicit step: nonlinear gaps and joints, exact friction cones, everything at the end of the step.
#pragma once

#include <memory>
#include <vector>

#include "perp/solve/friction_solver.hpp"
#include "perp/step/stepper.hpp"

namespace perp {

/// Where the directions of impulses are taken.
enum class Directions {
  End,   ///< W(q+): the paper's footnote 4
  Start  ///< W(q_l), with psi(q+) >= 0 kept
};

struct NcpStepperOptions {
  Directions directions = Directions::End;
  double tolerance = 1e-10;  ///< of the residuals, relative to the speeds that enter the step's equations [-]
  Reactions reactions =
      Reactions::Any;  ///< which are reported where contacts or joints are redundant; the motion is the same
};

/// How Newton's method went in the last step: to look at.
struct NewtonHistory {
  std::vector<double> residuals;  ///< [m/s] before each iteration, and after the last
};

/// A step of the seed's fully implicit variant [T03, footnote 4], an NCP in nu+ and the impulses:
///   M (nu+ - nu) = h k(q+, nu+, t+) + W(q+) p                                  (25) at the end
///   q+ = q ⊕ h nu+                                                              (26)
///   psi_b(q+, t+) = 0                                                           (28) nonlinear
///   0 <= p_n ⟂ psi_n(q+, t+) >= 0                                               (32) nonlinear
///   |p_f| <= mu p_n, maximum work against W_f(q+)ᵀ nu+ + surface velocity       (12), (36)-(38), circular cones
/// and joint friction as in `lcp`. Order 1. With Directions::Start the W are those of q_l.
///
/// One semismooth Newton on the whole; the report's `solver` is newton, or friction-chain or ipopt where those stood in. The first
/// guess is the last step's impulses if the step goes on from it: answers depend on the steps before by rounding (and, of
/// redundant contacts, which reactions are found).
///
/// Restitution: q+ is that of e = 0; contacts with e > 0 that closed with u_n- < 0 then get u_n+ >= -e u_n- at velocity level.
/// Contacts that cannot close within the step are left out and checked against its answer.
class NcpStepper : public Stepper {
 public:
  explicit NcpStepper(NcpStepperOptions options = {});
  ~NcpStepper() override;
  NcpStepper(NcpStepper&&) noexcept;
  NcpStepper& operator=(NcpStepper&&) noexcept;

  std::string_view name() const override {
    return options_.directions == Directions::End ? "ncp" : "ncp-start";
  }
  int order() const override { return 1; }
  bool knows_moments() const override { return true; }
  const NcpStepperOptions& options() const { return options_; }
  const StepAnswer* answer() const override;
  const NewtonHistory& history() const;

 private:
  struct Workspace;
  void advance(const Model& model, State& x, const StepRequest& request, StepReport& report) override;
  std::unique_ptr<Stepper> anew() const override;

  NcpStepperOptions options_;
  std::unique_ptr<Workspace> work_;
};

}  // namespace perp
