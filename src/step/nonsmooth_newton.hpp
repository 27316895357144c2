// Semismooth Newton on a step's equations, with stand-ins for when it stalls.
#pragma once

#include <array>
#include <string_view>

#include "step/linearized_step.hpp"
#include "step/step_problem.hpp"

namespace perp {

/// How well a guess satisfies (1), (2), as velocities.
struct StepResiduals {
  double momentum =
      0;  ///< √(Rᵀ M^-1 R/m) of a body [m/s]; max |M^-1 R| of a generalized one [of its velocities]
  double impulse = 0;     ///< max |R - sum W p| [N s, N m s]
  double normal = 0;      ///< |w (p - projection)| of contacts, along n [m/s]
  double tangential = 0;  ///< and along t, o; of joint frictions [m/s, rad/s]
  double joints = 0;      ///< |u| of equalities [m/s, rad/s]
  double speed = 0;       ///< largest speed that enters [m/s]
  double largest() const;
};

struct NewtonOutcome {
  bool converged = false;  ///< residuals.largest() <= tolerance * speed + rounding, in every island
  StepResiduals residuals;
  int iterations = 0;
  std::string_view solver = "none";  ///< newton, friction-chain, ipopt; none if nothing was to be done
  std::vector<double> history;  ///< residuals.largest() before each iteration of Newton, and after the last
};

/// Alart and Curnier's map F = p - projection(p - rho u/w) with the bodies' velocities as unknowns, linearised and solved by
/// LinearizedStep; eps there falls with the residual to rounding. The search is nonmonotone on an
/// energy, apart for each island (bodies tied by reactions or couplings); an island that stalls goes on from its best guess with
/// another rho. Residuals are those of rho = 1.
///
/// If it stalls: Josephy and Newton's method, the linearised problem with its exact cones solved by solve_friction's chain;
/// then the same by Ipopt.
class NonsmoothNewton {
 public:
  struct Options {
    double tolerance = 1e-10;  ///< relative to the speeds of the step
    double rounding = 0;       ///< of u, absolute [m/s]: what psi/h cannot go below
    int most = 40;             ///< iterations of Newton
  };

  /// Solves for nu and the reactions' p, from their values on entry; leaves u and W at the answer. Residuals and merits are
  /// measured by M of `instant`.
  void solve(const Model& model, const Instant& instant, StepProblem& problem, const Options& options,
             Vector& nu, std::vector<Reaction>& reactions, NewtonOutcome& outcome);

 private:
  static constexpr std::size_t memory = 8;  // merits that the search may fall back on
  struct Island {
    StepResiduals residuals;
    double merit = 0;  // [J]
    std::array<double, memory> merits{};
    double t = 1;  // of the search
    bool good = false;
    double floor = 0;        // of residuals, by rounding [m/s]
    int map = 0;             // in use: which of the steps rho
    double best = infinity;  // residual met, and how many iterations have not halved it
    int stalled = 0;
    bool at_rounding() const { return good && residuals.largest() <= floor; }
  };

  void find_islands(const Model& model, const std::vector<Reaction>& reactions);
  bool evaluate(const Model& model, StepProblem& problem, const Options& options, const Vector& nu,
                std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  bool judge(const Model& model, const Options& options, const Vector& nu,
             const std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  void regularise(const std::vector<Reaction>& reactions);
  std::size_t island_number(const Reaction& r) const;
  void keep_best(const Model& model, const Vector& nu, const std::vector<Reaction>& reactions);
  bool change_maps(const Model& model, Vector& nu, std::vector<Reaction>& reactions);
  bool search(const Model& model, StepProblem& problem, const Options& options, std::size_t iteration,
              Vector& nu, std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  bool newton(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
              std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  bool josephy_newton(const Model& model, StepProblem& problem, const Options& options, bool ipopt,
                      Vector& nu, std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  int root(int body);

  // Redundant reactions: even_sharing.cpp
  Vector3 give(const Reaction& r, std::size_t i) const;
  bool may_be_redundant(const Model& model, const std::vector<Reaction>& reactions);
  void set_give(const Model& model, const std::vector<Reaction>& reactions);
  void take_even_share(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
                       std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  bool even_step(const Model& model, std::vector<Reaction>& reactions, double& largest);
  bool solve_afresh(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
                    std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  bool soften(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
              std::vector<Reaction>& reactions, NewtonOutcome& outcome);

  const Instant* instant_ = nullptr;  // of the solve in hand
  Vector R_, nu_, nu_best_;           // R_ of (1) with sum W p taken off
  std::vector<Vector3> p_, p_best_;
  std::vector<Coupling> K_;
  std::vector<LinearizedReaction> rows_;
  LinearizedStep linearized_;
  std::vector<Island> islands_;
  std::vector<char> improved_;        // islands that a pass is about
  std::vector<int> parent_, island_;  // of bodies
  bool gives_ = false;                // rows give now: u + eps c (p - reference) in the place of u
  std::vector<double> give_;          // eps c of each reaction [1/kg]
  std::vector<Vector3> reference_, dp_;
  Vector dnu_;
};

/// A joint row's W as one column of three.
WrenchMap<3> three_columns(const WrenchMap<1>& W, int column);

/// w of a reaction.
double inverse_mass(const Model& model, const Instant& instant, const WrenchMap<3>& W, Law law);

}  // namespace perp
