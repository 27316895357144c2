// The nearest state that the constraints allow: each step is a frictionless LCP step of unit length.
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
  solve_mass(model, s, impulse, d);
  d += start;
  return true;
}

/// M^-1 of the gradient of d^T M d / 2 at q, d the displacement from q0 as nu's coordinates have it: positions, and rotation
/// vectors phi, whose derivative by a turning of the body is J_r(phi)^-1 = 1 + phi x/2 + c phi x phi x.
Vector pull(const Model& model, const Vector& q0, const Vector& q) {
  Vector back = Vector::Zero(model.nv());
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    if (b.kind == BodyKind::Generalized) {
      back.segment(b.v0, b.nv) = q.segment(b.q0, b.nq) - q0.segment(b.q0, b.nq);
      continue;
    }
    back.segment<3>(b.v0) = q.segment<3>(b.q0) - q0.segment<3>(b.q0);
    if (b.kind != BodyKind::Spatial) continue;
    const auto orientation = [&](const Vector& x) {
      return Quaternion(x[b.q0 + 3], x[b.q0 + 4], x[b.q0 + 5], x[b.q0 + 6]);
    };
    const Vector3 phi = rotation_vector(orientation(q0).conjugate() * orientation(q));
    const double angle = phi.norm();
    const double c = angle < 1e-3 ? 1.0 / 12 : 1 / (angle * angle) - 0.5 / (angle * std::tan(angle / 2));
    const Matrix3 J_r = Matrix3::Identity() + 0.5 * skew(phi) + c * skew(phi) * skew(phi);
    back.segment<3>(b.v0 + 3) = b.J_inverse * (J_r.transpose() * (b.J * phi));
  }
  return back;
}

/// The largest part of the way d that turns no body by more than a third of a radian.
double part_of(const Model& model, const Vector& d) {
  constexpr double most = 1.0 / 3;  // [rad]
  double turn = 0;
  for (const Body& b : model.bodies()) {
    if (b.kind == BodyKind::Spatial) turn = std::max(turn, d.segment<3>(b.v0 + 3).norm());
    if (b.kind == BodyKind::Planar) turn = std::max(turn, std::abs(d[b.v0 + 2]));
  }
  return turn > most ? most / turn : 1;
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
  // on the constraints to the tolerance, and no way along them is left that leads nearer: to the root of rounding, where
  // d^T M d is flat
  constexpr double flat = 1e-8;
  double way = violation(s) > accepted ? infinity : 0;
  while (s.fault.empty() && (violation(s) > accepted || way > flat * (x.q - q0).norm()) &&
         result.iterations < 200) {
    read();
    if (!shortest_move(model, s, active, gap, joint_bias, -pull(model, q0, x.q), d)) break;
    const double part = part_of(model, d);
    move(model, d, part, x.q);
    model.follow_turns(x);
    evaluate(model, x, s);
    way = part * d.norm();
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
  if (!result.reached) return result;
  result.moved_velocity = model.nv() == 0 ? 0 : (d - x.nu).cwiseAbs().maxCoeff();
  x.nu = d;
  return result;
}

}  // namespace perp
