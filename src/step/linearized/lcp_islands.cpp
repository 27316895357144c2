// The problems of a linear step's islands, and what solves them.
#include <algorithm>

#include "core/index.hpp"
#include "step/linearized/lcp_workspace.hpp"
#include "step/linearized/mixed_form.hpp"
#include "step/parts/contact_blocks.hpp"

namespace perp {
namespace {

/// Unknowns up to which Lemke's path costs no more than a factorisation.
constexpr int few_unknowns = 60;

}  // namespace

void LcpStepper::Workspace::assemble(const Model& model, const Instant& s, std::size_t i, double h,
                                     bool scaled) {
  IslandProblem& problem = problems[i];
  const Island& island = islands.get()[i];
  problem.reduced.assemble(model, s, island, nu_free, joint_bias);
  problem.polygonal.assemble(problem.reduced, s, island,
                             {.polygon = polygon, .polytope = polytope, .gap_term = gap_term, .h = h},
                             scaled);
}

/// Solves island i's problem for the gap terms in force; where its reactions may be redundant, by the one rule for these. False if there
/// is no answer.
bool LcpStepper::Workspace::solve_island(const Model& model, const Instant& s, std::size_t i, double h,
                                         bool second, Answer& found) {
  IslandProblem& problem = problems[i];
  const Island& island = islands.get()[i];
  LcpSolution& solution = problem.solution;
  points.clear();
  for (const int c : island.contacts) points.push_back(s.contacts[at(c)].point);
  const PolygonalTerms terms{.polygon = polygon, .polytope = polytope, .gap_term = gap_term, .h = h};
  problem.reduced.assemble(model, s, island, nu_free, joint_bias);
  const bool twists =
      std::ranges::any_of(island.contacts, [&](int c) { return s.contacts[at(c)].moments >= 0; });
  const bool redundant = problem.reduced.size() > 0 && !twists && loops.in(model, s, island);
  problem.polygonal.list_unknowns(problem.reduced, s, island, terms, true);
  problem.r.resize(problem.reduced.size());
  KeptModes& modes = problem.modes[second ? 1 : 0];
  const PolygonalSharing::Problem shared{model, problem.reduced,   s,      island,
                                         terms, problem.polygonal, points, problem.lemke};
  if (redundant && problem.sharing.again(shared, modes, solution.z, problem.r)) {
    found.solver = solution.stage = "basis";
    solution.status = LcpStatus::Solved;
    ++found.iterations;
    return true;
  }

  problem.polygonal.fill(problem.reduced, island, terms);
  const Lcp& lcp = problem.polygonal.lcp();
  KeptBasis& last = problem.last[second ? 1 : 0];
  const bool large = lcp.b.size() > few_unknowns;
  int pivots = 0;
  if (!large || last.of != points || !problem.pivots.solve(lcp.A, lcp.b, last.basic, solution)) {
    problem.lemke.solve(lcp.A, lcp.b, solution);
    pivots = solution.pivots;
    last.basic.clear();
    if (large && solution.solved()) last.keep(points, solution.z);
    if (!solution.solved()) solution = solve_lcp(lcp);
  }
  found.solver = solution.stage;
  found.iterations += solution.pivots + (solution.stage == "lemke" ? 0 : pivots);
  if (!solution.solved() && solution.status != LcpStatus::Inaccurate) return false;
  problem.polygonal.read_impulses(solution.z, problem.r);
  if (redundant) problem.sharing.share(shared, modes, solution.z, problem.r);
  return true;
}

/// Solves the islands' problems for the gap terms in force; false, with report.message, if one has no answer.
bool LcpStepper::solve(const Model& model, const Instant& s, const StepRequest& request, Answer& answer,
                       StepReport& report) {
  Workspace& w = *work_;
  w.islands.find(model, s, w.active);
  const auto islands = w.islands.get();
  if (w.problems.size() < islands.size()) w.problems.resize(islands.size());
  answer.clear(s, w.nu_free);
  if (options_.form == LcpForm::Mixed)
    return solve_mixed(model, s, w.polygon, w.active, w.nu_free, w.gap_term, w.joint_bias, request.h, answer,
                       report.message);

  const bool rebound = &answer == &w.rebound;
  if (rebound) w.keep_unstruck(model, s);
  for (std::size_t i = 0; i < islands.size(); ++i) {
    if (!w.takes_part(s, islands[i])) continue;
    IslandProblem& problem = w.problems[i];
    if (!w.solve_island(model, s, i, request.h, rebound, answer)) {
      report.message = "the LCP of an island of " + std::to_string(islands[i].contacts.size()) +
                       " contacts was not solved: " + std::string(name_of(problem.solution.status));
      return false;
    }
    problem.reduced.add_impulses(s, islands[i], problem.r, answer.impulse, answer.reactions);
  }

  // nu+ from the Newton-Euler equation (25)
  solve_mass(model, s, answer.impulse, answer.nu);
  answer.nu += w.nu_free;
  for (std::size_t i = 0; i < islands.size(); ++i)
    if (w.takes_part(s, islands[i])) certify(s, islands[i], i, answer);
  return true;
}

/// The impulses of an island into `answer`, what speeds enter its problem, and which contacts slip.
void LcpStepper::certify(const Instant& s, const Island& island, std::size_t number, Answer& answer) {
  Workspace& w = *work_;
  IslandProblem& problem = w.problems[number];
  const Vector& z = problem.solution.z;
  problem.u.resize(problem.reduced.size());
  for (std::size_t i = 0; i < island.contacts.size(); ++i) {
    const int index = island.contacts[i], row = problem.reduced.rows_of(static_cast<int>(i));
    const ContactInstant& c = s.contacts[at(index)];
    const int rows = 1 + c.tangents;
    const Vector3 u = c.velocity(answer.nu);
    problem.u.segment(row, rows) = u.head(rows);
    answer.p.col(index).head(rows) = problem.r.segment(row, rows);
    if (const MomentInstant* m = s.moments_of(c); m != nullptr) {
      const Vector3 omega = m->velocity(answer.nu);
      const auto columns = m->columns(c.tangents);
      for (int k = 0, from = moment_row(c, row); k < m->rows(c.tangents); ++k) {
        problem.u[from + k] = omega[columns[at(k)]];
        answer.moments(columns[at(k)], index) = problem.r[from + k];
      }
    }
    const double gap = w.gap_term[index], p_n = problem.r[row];
    answer.w[index] = problem.reduced.diagonal[row];
    answer.speed_scale = std::max({answer.speed_scale, std::abs(gap), problem.reduced.diagonal[row] * p_n,
                                   c.velocity(w.nu_free).cwiseAbs().maxCoeff()});
  }
  for (std::size_t i = 0; i < island.joint_frictions.size(); ++i) {
    const int index = island.joint_frictions[i], row = problem.reduced.friction_row(static_cast<int>(i));
    problem.u[row] = s.joint_frictions[at(index)].velocity(answer.nu);
    answer.joint_friction[index] = problem.r[row];
    answer.speed_scale =
        std::max(answer.speed_scale, std::abs(s.joint_frictions[at(index)].velocity(w.nu_free)));
  }
  for (const int row : island.joint_rows)  // a hinge may turn only because its rows pull
    answer.speed_scale = std::max({answer.speed_scale, std::abs(w.joint_bias[row]),
                                   std::abs(s.joint_rows[at(row)].velocity(w.nu_free))});
  for (std::size_t i = 0; i < island.contacts.size(); ++i)
    answer.slips[at(island.contacts[i])] =
        static_cast<char>(problem.polygonal.slips(static_cast<int>(i), z, answer.speed_scale));
}

}  // namespace perp
