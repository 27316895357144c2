// The seed's time-stepping LCP, and Anitescu and Potra's variant of it.
#pragma once

#include <memory>
#include <vector>

#include "perp/instant/islands.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/solve/lcp.hpp"
#include "perp/step/stepper.hpp"

namespace perp {

struct Answer;
enum class Rebound : int;

/// Which linear problem a step solves. Both have the same velocities; they share `evaluate` alone.
enum class LcpForm {
  Condensed,  ///< joints eliminated as in (43)-(47): a standard LCP for each island
  Mixed       ///< (25), (28) kept as equations: one mixed LCP for the whole system. For studies; slow
};

struct LcpStepperOptions {
  int edges = 8;  ///< of the friction polygon at spatial contacts, >= 3
  LcpForm form = LcpForm::Condensed;
  bool close_joints =
      true;  ///< psi_b(q+, t+) = 0 in place of (28), so that loops do not drift; off: (28) as the seed has it
  bool whole_impacts =
      true;  ///< an impact's velocities from a problem of their own, without restitution too; off: (32) as the seed has it
  bool anitescu_potra = false;  ///< gap rows W_n^T nu+ + dPsi/dt >= 0, without psi_n/h: `lcp-ap`
  double tolerance = 1e-10;  ///< of the residuals, relative to the speeds that enter the step's equations [-]
  Reactions reactions =
      Reactions::Any;  ///< which are reported where contacts or joints are redundant; the motion is the same
};

/// A step of the seed's (25)-(38): M, W, k at the start of the step (t_l), impulses that satisfy at its end
///   M (nu+ - nu) = h k + W_n p_n + W_f p_f + W_b p_b                                    (25)
///   q+ = q ⊕ h nu+                                                                      (26)
///   psi_b/h + W_b^T nu+ + dpsi_b/dt = 0                                                 (28)
///   0 <= p_n ⟂ psi_n/h + W_n^T nu+ + dpsi_n/dt >= 0                                     (32)
/// and the polygon's maximum work principle (36)-(38) with surface velocities (erratum 30). Order 1. Linear gaps: on curved ones it
/// overlaps by h^2 v^2/(2R).
///
/// `lcp-ap` [AP97]: contacts that would close within the step get W_n^T nu+ + dpsi_n/dt >= 0 instead of (32): a solution always exists
/// (without joints), and nothing pushes an overlap out.
///
/// Restitution: where contacts with e > 0 close in the step with approach speed u_n- < 0, q+ is that of e = 0, and nu+ comes
/// from a second problem in which they have W_n^T nu+ + dpsi_n/dt >= -e u_n- and the other closed contacts >= 0. With
/// `whole_impacts` also where e = 0: (32) spreads an impact over two steps, and friction in two parts need not be that of the
/// whole, however small h is.
///
/// Joints: with `close_joints`, psi_b(q+, t+) = 0 with W_b of the start in place of (28), which is linear in nu+ and lets joints
/// drift by O(h^2) before it pulls them back. Where that has no solution (a linkage passing its change point), q+ is moved onto
/// psi_b = 0 at last, the shortest way in the norm of M: StepFigures::projection says how far. Redundant rows that agree are solved in the least-squares sense; those that do not fail the step,
/// named.
///
/// Contacts that cannot close within the step are left out and checked against its answer; one that would have
/// closed is added and the step solved again, so the answer is that of all contacts.
class LcpStepper : public Stepper {
 public:
  explicit LcpStepper(LcpStepperOptions options = {});
  ~LcpStepper() override;
  LcpStepper(LcpStepper&&) noexcept;
  LcpStepper& operator=(LcpStepper&&) noexcept;

  std::string_view name() const override { return options_.anitescu_potra ? "lcp-ap" : "lcp"; }
  int order() const override { return 1; }
  int edges() const override { return options_.edges; }
  bool knows_moments() const override { return true; }
  const LcpStepperOptions& options() const { return options_; }
  const StepAnswer* answer() const override;

  /// The LCP(F, f) of (39) of each island, in SI units, with z = (p_n, beta_u, beta_b, sigma_u, sigma_b): what a step from x
  /// would solve first. To look at; a step scales it.
  std::vector<Lcp> problems(const Model& model, const State& x, double h);

 private:
  struct Workspace;
  void advance(const Model& model, State& x, const StepRequest& request, StepReport& report) override;
  std::unique_ptr<Stepper> anew() const override;
  void begin(const Model& model, const State& x, const StepRequest& request, const Instant& s);
  bool solve_positions(const Model& model, const State& x, const Instant& s, const StepRequest& request,
                       StepReport& report);
  bool solve(const Model& model, const Instant& s, const StepRequest& request, Answer& answer,
             StepReport& report);
  void certify(const Instant& s, const Island& island, std::size_t number, Answer& answer);
  bool add_overlapping(const Instant& s, double h, const Answer& answer);
  void take_least(const Model& model, const Instant& s, double h, Answer& answer);
  bool whole_impacts() const { return options_.whole_impacts && !options_.anitescu_potra; }
  bool find_impact(const Model& model, const State& x, const Instant& s, double h);
  void set_rebound(const State& x, const Instant& s, Rebound law);

  LcpStepperOptions options_;
  std::unique_ptr<Workspace> work_;
};

}  // namespace perp
