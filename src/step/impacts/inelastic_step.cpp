#include "step/impacts/inelastic_step.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "perp/instant/reduced_system.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/step/simulate.hpp"
#include "solve/friction/even_friction.hpp"
#include "step/certificate/certificate.hpp"
#include "step/parts/contact_blocks.hpp"
#include "step/parts/free_rotation.hpp"
#include "step/parts/moment_laws.hpp"
#include "step/run/step_record.hpp"

namespace perp {

bool inelastic_step(const Model& model, State& x, double h, StepReport& report) {
  Instant s;
  evaluate(model, x, s);
  if (!s.fault.empty()) return false;
  Vector nu_free, load = s.k;
  implicit_gyroscopic(model, x, h, load);
  solve_mass(model, s, load, nu_free);
  nu_free = x.nu + h * nu_free;

  Island island;
  island.joint_rows.resize(s.joint_rows.size());
  std::iota(island.joint_rows.begin(), island.joint_rows.end(), 0);
  island.joint_frictions.resize(s.joint_frictions.size());
  std::iota(island.joint_frictions.begin(), island.joint_frictions.end(), 0);
  Vector joint_bias(static_cast<Eigen::Index>(s.joint_rows.size()));
  for (std::size_t i = 0; i < s.joint_rows.size(); ++i)
    joint_bias[static_cast<Eigen::Index>(i)] = s.joint_rows[i].psi_b_t;

  State moved = x;
  ReducedSystem reduced;
  Vector r, impulse, reactions(joint_bias.size()), k;
  Matrix C;
  std::vector<char> taken(s.contacts.size(), 0);
  for (bool added = true; added;) {
    added = false;
    const Vector& nu = island.contacts.empty() ? nu_free : moved.nu;
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
      if (taken[i] != 0 || s.contacts[i].psi_n + h * s.contacts[i].velocity(nu).x() > 0) continue;
      taken[i] = 1;
      added = true;
      island.contacts.insert(std::upper_bound(island.contacts.begin(), island.contacts.end(), int(i)),
                             int(i));
    }
    if (!added && r.size() > 0) break;
    reduced.assemble(model, s, island, nu_free, joint_bias);
    FrictionProblem problem;
    problem.W = reduced.W;
    problem.q = reduced.q;
    ContactBlocks blocks;
    for (std::size_t i = 0; i < island.contacts.size(); ++i) {
      const ContactInstant& c = s.contacts[static_cast<std::size_t>(island.contacts[i])];
      const int row = reduced.rows_of(static_cast<int>(i));
      (void)blocks.add(s, c, row);
      // the projection takes overlaps away, without adding velocity
      problem.q[row] += std::max(c.psi_n, 0.0) / h;
    }
    for (std::size_t i = 0; i < s.joint_frictions.size(); ++i)
      blocks.add_interval(reduced.friction_row(static_cast<int>(i)), h * s.joint_frictions[i].friction);
    blocks.give(problem);
    r.setZero(reduced.size());
    if (problem.rows() > 0) {
      reduced.compliance(model, s, island, C, k);
      const FrictionSolution solution = solve_evenly(problem, C, k);
      if (!solution.solved()) return false;
      r = solution.r;
      report.iterations += solution.iterations;
    }
    impulse.setZero(model.nv());
    reduced.add_impulses(s, island, r, impulse, reactions);
    solve_mass(model, s, impulse, moved.nu);
    moved.nu += nu_free;
  }
  move(model, moved.nu, h, moved.q);
  moved.t = x.t + h;
  model.follow_turns(moved);
  StepAnswer answer;
  answer.h = h;
  answer.nu_q = moved.nu;
  answer.q_moved = moved.q;
  answer.joint_bias = joint_bias;
  if (!moved.q.allFinite() || !moved.nu.allFinite()) return false;
  const Projection projection = project_onto_constraints(model, moved);
  if (!projection.reached) return false;
  report.projection = projection.moved;

  for (std::size_t i = 0; i < island.contacts.size(); ++i) {
    const ContactInstant& c = s.contacts[static_cast<std::size_t>(island.contacts[i])];
    const int row = reduced.rows_of(static_cast<int>(i));
    Vector3 p = Vector3::Zero();
    p.head(1 + c.tangents) = r.segment(row, 1 + c.tangents);
    answer.first.push_back({.source = c.point, .p = p, .gap = std::max(c.psi_n, 0.0) / h});
    const MomentInstant* m = s.moments_of(c);
    Vector3 p_m = Vector3::Zero();
    double lever = 1;
    if (m != nullptr) {
      for (int j = 0; j < m->rows(c.tangents); ++j)
        p_m[m->columns(c.tangents)[static_cast<std::size_t>(j)]] = r[moment_row(c, row) + j];
      lever = lever_of(model, s, c, *m);
      answer.first.push_back({.of = Reaction::Of::Moments, .source = c.point, .p = p_m, .lever = lever});
    }
    if (!(p.x() > 0)) continue;
    const bool sticks =
        c.tangents > 0 && (m == nullptr ? p.tail<2>().norm() < c.mu * p.x() * (1 - 1e-9)
                                        : sliding_pull(c, *m, p, p_m, lever) < p.x() * (1 - 1e-9));
    report.contacts.push_back(contact_row(c, p, sticks ? ContactMode::Stick : ContactMode::Slip));
    report.contacts.back().moment = c.frame * p_m;
    report.contacts.back().gap = 0;
    report.contacts.back().force = c.frame * p / h;
  }
  begin_joints(model, report);
  for (std::size_t i = 0; i < s.joint_rows.size(); ++i) {
    const double p = reactions[static_cast<Eigen::Index>(i)];
    answer.first.push_back({.of = Reaction::Of::JointRow, .source = static_cast<int>(i), .p = {p, 0, 0}});
    add_joint_reaction(s.joint_rows[i], p, report);
  }
  for (std::size_t i = 0; i < s.joint_frictions.size(); ++i) {
    const double p = r[reduced.friction_row(static_cast<int>(i))], most = h * s.joint_frictions[i].friction;
    answer.first.push_back(
        {.of = Reaction::Of::JointFriction, .source = static_cast<int>(i), .p = {p, 0, 0}});
    add_joint_friction(s.joint_frictions[i], p,
                       std::abs(p) < most * (1 - 1e-9) ? ContactMode::Stick : ContactMode::Slip, report);
  }
  Instant end;
  evaluate(model, moved, end);
  end_joints(end, moved.nu, report);
  report.h = h;
  (void)Certificate().certify(model, s, x, model.energy(x), end, moved, answer, report);
  x = moved;
  return true;
}

}  // namespace perp
