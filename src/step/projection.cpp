// Newton's method onto the constraints: each step is a frictionless LCP step of unit length from rest.
#include <algorithm>
#include <cmath>

#include "perp/instant/reduced_system.hpp"
#include "perp/solve/lcp.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

/// The d of least M-norm with joint_bias + W_b^T d = 0 and 0 <= p ⟂ gap + W_n^T d >= 0 for the contacts in `active`, from
/// d = start; false if there is none. Contacts count with their normals only.
bool shortest_move(const Model& model, Instant s, std::span<const int> active, const Vector& gap,
                   const Vector& joint_bias, const Vector& start, Vector& d) {
  for (ContactInstant& c : s.contacts) {
    c.tangents = 0;
    c.bias.setZero();
  }
  s.joint_frictions.clear();
  Islands islands;
  islands.find(model, s, active);
  Vector impulse = Vector::Zero(model.nv()),
         reactions = Vector::Zero(static_cast<Eigen::Index>(s.joint_rows.size()));
  for (const Island& island : islands.get()) {
    ReducedSystem reduced;
    reduced.assemble(model, s, island, start, joint_bias);
    Lcp lcp{reduced.W, reduced.q};
    for (std::size_t i = 0; i < island.contacts.size(); ++i)
      lcp.b[static_cast<int>(i)] += gap[island.contacts[i]];
    const LcpSolution solution = solve_lcp(lcp);
    if (!solution.solved()) return false;
    reduced.add_impulses(s, island, solution.z, impulse, reactions);
  }
  solve_mass(model, impulse, d);
  d += start;
  return true;
}

double violation(const Instant& s) { return std::max(s.joint_error(), std::max(0.0, -s.gap_min())); }

}  // namespace

Projection project_onto_constraints(const Model& model, State& x, double tolerance) {
  model.check("project_onto_constraints", x);
  Instant s;
  evaluate(model, x, s);
  const Vector q0 = x.q;
  Projection result;
  const double accepted = std::max(tolerance * violation(s), 1e-14);

  Vector d, joint_bias, gap;
  std::vector<int> active;
  const auto read = [&] {
    joint_bias.resize(static_cast<Eigen::Index>(s.joint_rows.size()));
    for (std::size_t i = 0; i < s.joint_rows.size(); ++i)
      joint_bias[static_cast<int>(i)] = s.joint_rows[i].psi_b;
    gap.resize(static_cast<Eigen::Index>(s.contacts.size()));
    active.clear();
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
      gap[static_cast<int>(i)] = s.contacts[i].psi_n;
      active.push_back(static_cast<int>(i));
    }
  };
  while (s.fault.empty() && violation(s) > accepted && result.iterations < 50) {
    read();
    if (!shortest_move(model, s, active, gap, joint_bias, Vector::Zero(model.nv()), d)) break;
    move(model, d, 1, x.q);
    evaluate(model, x, s);
    ++result.iterations;
  }
  result.gap_min = s.gap_min();
  result.joint_error = s.joint_error();
  result.moved = model.nq() == 0 ? 0 : (x.q - q0).cwiseAbs().maxCoeff();
  result.reached = s.fault.empty() && violation(s) <= accepted;
  if (!result.reached) return result;

  // velocities: closed contacts do not approach, joints do not part
  read();
  active.clear();
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    if (s.contacts[i].psi_n <= accepted) active.push_back(static_cast<int>(i));
    gap[static_cast<int>(i)] = s.contacts[i].bias.x();
  }
  for (std::size_t i = 0; i < s.joint_rows.size(); ++i)
    joint_bias[static_cast<int>(i)] = s.joint_rows[i].psi_b_t;
  result.reached = shortest_move(model, s, active, gap, joint_bias, x.nu, d);
  if (result.reached) x.nu = d;
  return result;
}

}  // namespace perp
