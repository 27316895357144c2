// What an LcpStepper keeps from step to step.
#pragma once

#include "instant/body_loops.hpp"
#include "perp/solve/lemke.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/polygonal_lcp.hpp"
#include "solve/lcp/basis_pivots.hpp"
#include "step/certificate/certificate.hpp"
#include "step/certificate/closeness.hpp"
#include "step/certificate/pass_mark.hpp"
#include "step/impacts/impact_in_step.hpp"
#include "step/linearized/polygonal_sharing.hpp"
#include "step/parts/joint_projection.hpp"
#include "step/run/step_record.hpp"

namespace perp {

/// One island's problem and the solver that keeps its workspace.
struct IslandProblem {
  ReducedSystem reduced;
  PolygonalLcp polygonal;
  LemkeSolver lemke;
  LcpSolution solution;
  BasisPivots pivots;
  KeptBasis last[2];            // of the problem without and with restitution
  PolygonalSharing sharing;     // where reactions may be redundant
  KeptModes modes[2];           // as `last`
  Vector r, u;                  // impulses and velocities along the rows of `reduced`
  std::vector<double> lengths;  // that units of u are worth: of contacts, joint rows, joint frictions
  Vector row_lengths;

  /// What the rows of contacts and joint frictions miss at most [m/s].
  double residual(const Island& island, const Vector& gap_term) {
    row_lengths.setOnes(reduced.size());
    double worst = 0;
    for (std::size_t i = 0; i < island.contacts.size(); ++i) {
      const int row = reduced.rows_of(static_cast<int>(i));
      const double opening = gap_term[island.contacts[i]] + u[row];
      worst = std::max(worst, lengths[i] * std::abs(std::min(opening, reduced.diagonal[row] * r[row])));
    }
    const std::size_t before = island.contacts.size() + island.joint_rows.size();
    for (std::size_t i = 0; i < island.joint_frictions.size(); ++i)
      row_lengths[reduced.friction_row(static_cast<int>(i))] = lengths[before + i];
    return std::max(worst, polygonal.friction_residual(solution.z, u, row_lengths));
  }

  /// The largest sum of the sizes of what a row adds up [m/s].
  double size_of_terms(const Island& island, const Vector& gap_term) const {
    Vector sizes = reduced.W.cwiseAbs() * r.cwiseAbs() + reduced.diagonal.cwiseProduct(r.cwiseAbs()) +
                   reduced.q.cwiseAbs() + u.cwiseAbs();
    for (std::size_t i = 0; i < island.contacts.size(); ++i)
      sizes[reduced.rows_of(static_cast<int>(i))] += std::abs(gap_term[island.contacts[i]]);
    return sizes.lpNorm<Eigen::Infinity>();
  }
};

struct LcpStepper::Workspace {
  std::vector<Vector2> polygon;
  std::vector<Vector3> polytope;
  StartInstant start;
  Instant end;
  Vector load, nu_free, gained;    // k; nu + h M^-1 k; h M^-1 k
  Vector gap_term, joint_bias;     // beside W_n^T nu+ + dpsi_n/dt; psi_b/h + dpsi_b/dt
  std::vector<int> active, added;  // contacts that take part, ascending; scratch
  std::vector<int> points;         // of an island's contacts
  Islands islands;
  BodyLoops loops;
  std::vector<IslandProblem> problems;  // one an island, in their order
  Answer answer, rebound;               // without and with restitution
  State moved;
  JointProjection projection;
  StepSpeeds speeds;
  double fastest = 0;                    // of what they know of the step
  Instant widened;                       // the start, with contacts that came into being within the step
  const Instant* solved_from = nullptr;  // the start, or that
  Vector first_bias;                     // joint_bias of (28)
  StepAnswer step;
  Certificate certificate;

  void assemble(const Model& model, const Instant& s, std::size_t i, double h, bool scaled);
  bool solve_island(const Model& model, const Instant& s, std::size_t i, double h, bool second,
                    Answer& found);
  const Instant* add_appeared(const Instant& s, double h);
  bool islands_pass(const LcpStepperOptions& options, const Answer& found, StepReport& report);
  bool joints_pass(const Model& model, double h, const LcpStepperOptions& options, const Answer& found,
                   StepReport& report);
  std::vector<Reaction> reactions;
  EnergyBefore energy;

  // An impact: a second problem for the bodies that it reaches, the others keep the first one's answer.
  std::vector<char> struck;  // of a body; empty: of the first problem, in which all take part
  template <int N>
  bool reaches(const WrenchMap<N>& W) const {
    return (W.na > 0 && struck[static_cast<std::size_t>(W.a)] != 0) ||
           (W.nb > 0 && struck[static_cast<std::size_t>(W.b)] != 0);
  }
  bool takes_part(const Instant& s, const Island& island) const;
  void strike(const Instant& s, const Island& island);
  void keep_unstruck(const Model& model, const Instant& s);
};

}  // namespace perp
