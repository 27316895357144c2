// Semismooth Newton on a step's equations, with stand-ins for when it stalls.
#pragma once

#include <array>
#include <string_view>

#include "instant/body_loops.hpp"
#include "step/certificate/pass_mark.hpp"
#include "step/implicit/step_problem.hpp"
#include "step/linearized/linearized_step.hpp"

namespace perp {

/// How well a guess satisfies (1), (2), as velocities.
struct StepResiduals {
  double momentum =
      0;  ///< √(Rᵀ M^-1 R/m) of a body [m/s]; max |M^-1 R| of a generalized one [of its velocities]
  double impulse = 0;     ///< max |R - sum W p| [N s, N m s]
  double normal = 0;      ///< |w (p - projection)| of contacts, along n, times what a unit is worth [m/s]
  double tangential = 0;  ///< and along t, o; of joint frictions [m/s]
  double joints = 0;      ///< |u| of equalities [m/s]
  double speed = 0;       ///< that they are measured by: the largest that StepSpeeds knows [m/s]
  double largest() const;
};

struct NewtonOutcome {
  bool converged = false;  ///< every body and reaction misses no more than its island's pass mark
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
/// A miss of a body or a reaction passes, as a speed, if it is at most
///   tolerance s + rounding of psi/h + min(2e-10 (largest speed that enters), 1e-6 s),   s the speed of its island (StepSpeeds):
/// the answer's own velocities and impulses are worth 1e-6 of that at most.
///
/// Where bodies and reactions close loops, reactions may be redundant: Newton's linear steps then take the limit of rows that give a
/// little, all alike, and first, while the residual is large, give more: doc/methods/redundant.md.
///
/// If it stalls: Josephy and Newton's method, the linearised problem with its exact cones solved by solve_friction's chain;
/// then the same by Ipopt.
class NonsmoothNewton {
 public:
  struct Options {
    const StepSpeeds& speeds;
    double tolerance = 1e-10;      ///< relative to the speeds of the step
    int most = 40;                 ///< iterations of Newton
    const State* start = nullptr;  ///< of the step, if its positions move with nu
    double h = 0;                  ///< of the step [s]
    bool stiff =
        false;  ///< loads depend on the state: its velocities are a first guess too, where what loads give is no use
  };

  /// Solves for nu and the reactions' p, from their values on entry; leaves u and W at the answer. Residuals and merits are
  /// measured by M of `instant`.
  void solve(const Model& model, const Instant& instant, StepProblem& problem, const Options& options,
             Vector& nu, std::vector<Reaction>& reactions, NewtonOutcome& outcome);

 private:
  static constexpr double steps_rho[] = {1, 0.1, 10};
  static constexpr int maps = 3;
  static constexpr int most_idle = 4;       // iterations of a guess that is near and gets no better
  static constexpr std::size_t memory = 8;  // merits that the search may fall back on
  struct Island {
    StepResiduals residuals;
    double merit = 0;  // [J]
    std::array<double, memory> merits{};
    double t = 1;            // of the search
    bool near = false;       // what all in it miss is less than algebra may leave: the search takes it
    bool good = false;       // all in it pass
    double speed = 0;        // that it is measured by [m/s]
    double size = 0;         // largest speed that enters, the answer's among them [m/s]
    double rounding = 0;     // largest of its reactions' [m/s]
    double floor = 0;        // of residuals, by rounding [m/s]
    int map = 0;             // in use: which of the steps rho
    double best = infinity;  // residual met, and how many iterations have not halved it
    int stalled = 0;
    bool loops = false;      // reactions may be redundant
    double give = 0;         // of a compliance of 1, and of its reactions' w, the means [1/kg]
    bool limit = false;      // the step in hand is to the limit of rows that give
    int uneven = 0;          // more iterations that may be spent on that
    bool best_good = false;  // whether that guess passes
    bool at_best = false;    // the guess evaluated last is that one
    bool at_rounding() const { return good && residuals.largest() <= floor; }
    bool polished() const { return near && !good && uneven == 0; }  // what is left is mended without the rule
    bool done() const {
      return (at_rounding() || (good && stalled > 0) || (near && stalled > most_idle)) && uneven == 0;
    }
  };

  /// A miss that passes if rounding of what is added up is that large.
  struct Doubt {
    double miss = 0, rounding = 0;  // [m/s]
    int body = -1, reaction = -1;
  };

  bool begin(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
             std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  void find_islands(const Model& model, const Options& options, const std::vector<Reaction>& reactions);
  bool sum_up(NewtonOutcome& outcome);
  void linearise(std::size_t i, const std::vector<Reaction>& reactions, double rho, double rounding);
  void judge_miss(Island& island, const Options& options, const Doubt& miss);
  void add_sizes_of_loads(const Model& model, const Options& options, Vector& sizes) const;
  void settle_doubts(const Model& model, const Options& options, const Vector& nu,
                     const std::vector<Reaction>& reactions);
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
  // Redundant reactions: even_sharing.cpp
  bool has_loops() const;
  bool newton_in_loops(const Model& model, StepProblem& problem, const Options& options,
                       const std::vector<Vector3>& p, Vector& nu, std::vector<Reaction>& reactions,
                       NewtonOutcome& outcome);
  bool newton_without_give(const Model& model, StepProblem& problem, const Options& options,
                           const Vector& guess, const std::vector<Vector3>& p, Vector& nu,
                           std::vector<Reaction>& reactions, NewtonOutcome& outcome);
  bool take(const Model& model, StepProblem& problem, const Options& options, const Vector& guess,
            const std::vector<Vector3>& p, Vector& nu, std::vector<Reaction>& reactions,
            NewtonOutcome& outcome);
  void start_again(bool even);
  void find_loops(const Model& model, const std::vector<Reaction>& reactions);
  void give_evenly(std::size_t i, const std::vector<Reaction>& reactions, double eps);
  void take_even(const Model& model, StepProblem& problem, const Options& options, Vector& nu,
                 std::vector<Reaction>& reactions, NewtonOutcome& outcome);

  int root(int body);
  double size_of(const Body& b, std::size_t body, const Vector& nu) const;

  const Instant* instant_ = nullptr;  // of the solve in hand
  Vector R_, nu_, nu_best_;           // R_ of (1) with sum W p taken off
  std::vector<Vector3> p_, p_best_;
  std::vector<Coupling> K_;
  std::vector<LinearizedReaction> rows_;
  std::vector<Vector3> misses_;        // of rho = 1 [m/s]
  std::vector<Matrix6> with_moments_;  // of contacts with moments, whose rows point there; empty without any
  LinearizedStep linearized_;
  std::vector<Island> islands_;
  std::vector<Doubt> doubts_;
  Vector terms_;
  std::vector<char> improved_;        // islands that a pass is about
  std::vector<int> parent_, island_;  // of bodies
  BodyLoops loops_;
  bool even_ = false;  // linear steps lead to the limit of rows that give
  Vector nu_guess_, nu_limit_;
  std::vector<Vector3> limit_;
  std::vector<double> compliance_;  // of reactions, where islands have loops
  std::vector<char> left_open_;     // of these: contacts that the last linear step left without a load
  std::vector<double> radius_;      // of gyration: what a body's angular velocity is worth [m]
};

/// A joint row's W as one column of three.
WrenchMap<3> three_columns(const WrenchMap<1>& W, int column);

/// w of a reaction.
double inverse_mass(const Model& model, const Instant& instant, const WrenchMap<3>& W, Law law);

}  // namespace perp
