#include "step/events/row_quadrature.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "step/certificate/step_energy.hpp"

namespace perp {
// Lobatto's points on [0, 1], the weights, integrals up to each point of the polynomials that are 1 at one point, and their slopes.
const std::array<double, RowQuadrature::points> RowQuadrature::place = {0, 0.17267316464601143, 0.5,
                                                                        0.82732683535398857, 1};
const std::array<double, RowQuadrature::points> RowQuadrature::weight = {1.0 / 20, 49.0 / 180, 16.0 / 45,
                                                                         49.0 / 180, 1.0 / 20};
const std::array<std::array<double, RowQuadrature::points>, RowQuadrature::points> RowQuadrature::integral = {
    {{0, 0, 0, 0, 0},
     {0.067728432186156898, 0.11974476934341168, -0.021735721866558114, 0.010635824225415492,
      -0.0037001392424145306},
     {0.040625, 0.30318418332304278, 8.0 / 45, -0.030961961100820556, 0.009375},
     {0.053700139242414531, 0.26158639799680673, 0.37729127742211367, 0.15247745287881054,
      -0.017728432186156898},
     {1.0 / 20, 49.0 / 180, 16.0 / 45, 49.0 / 180, 1.0 / 20}}};
const std::array<std::array<double, RowQuadrature::points>, RowQuadrature::points> RowQuadrature::slope = {
    {{-10, 13.51300497744848, -16.0 / 3, 2.8203283558848533, -1},
     {-2.4819805060619657, 0, 3.4914862437758781, -1.5275252316519467, 0.51801949393803428},
     {0.75, -2.6731691553909067, 0, 2.6731691553909067, -0.75},
     {-0.51801949393803428, 1.5275252316519467, -3.4914862437758781, 0, 2.4819805060619657},
     {1, -2.8203283558848533, 16.0 / 3, -13.51300497744848, 10}}};

bool RowQuadrature::read(ModeDynamics& dynamics, Node& node) {
  if (!dynamics.evaluate(node.x)) return false;
  const Instant& s = dynamics.instant();
  const Vector& nu = node.x.nu;
  node.nu_dot = dynamics.nu_dot;
  dynamics.kinematic_map(node.x, node.q_dot);
  node.normal.clear();
  node.force.clear();
  node.moment.clear();
  Power power;
  const auto& closed = dynamics.modes().contacts;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    const ContactInstant& c = s.contacts[at(s.contact_of_point[at(closed[i].point)])];
    const Vector3& f = dynamics.force[i];
    power.friction += f.tail<2>().dot(c.velocity(nu).tail<2>());
    power.surface -= f.dot(c.bias);
    node.normal.push_back(f.x());
    node.force.push_back(c.frame * f);
    if (s.moments.empty()) continue;
    const Vector3& tau = dynamics.moment[i];
    node.moment.push_back(c.frame * tau);
    if (const MomentInstant* m = s.moments_of(c)) {
      power.friction += tau.dot(m->velocity(nu));
      power.surface -= tau.dot(m->bias);
    }
  }
  const auto rows = static_cast<Eigen::Index>(s.joint_rows.size());
  node.joint_reaction = dynamics.multipliers().head(rows);
  node.joint_friction = dynamics.joint_force;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const JointRowInstant& row = s.joint_rows[static_cast<std::size_t>(i)];
    (row.prescribed ? power.motor : power.surface) -= node.joint_reaction[i] * row.psi_b_t;
  }
  for (Eigen::Index i = 0; i < node.joint_friction.size(); ++i) {
    const JointRowInstant& row = s.joint_frictions[static_cast<std::size_t>(i)];
    power.friction += node.joint_friction[i] * row.velocity(nu);
    power.surface -= node.joint_friction[i] * row.psi_b_t;
  }
  if (s.k_load.size() > 0) power.load += s.k_load.dot(nu);
  if (s.k_motor.size() > 0) power.motor += s.k_motor.dot(nu);
  power.surface += power_of_moving_springs(dynamics.model(), s);
  node.M.clear();
  for (const Instant::GeneralizedMass& mass : s.masses) {
    const Body& b = dynamics.model().bodies()[at(mass.body)];
    power.load += nu.segment(b.v0, b.nv).dot(s.k.segment(b.v0, b.nv));
    node.M.push_back(mass.M);
  }
  node.power = power;
  return true;
}

bool RowQuadrature::integrate(ModeDynamics& dynamics, const State& a, const State& b, double tolerance) {
  constexpr int most_rounds = 8;
  constexpr double least_gain =
      0.8;  // of the change from round to round: where they gain less, rounding is what is left
  momentum_residual = kinematic_residual = not_set;
  h_ = b.t - a.t;
  const long evaluations = dynamics.evaluations;
  const bool fine = [&] {
    nodes_[0].x = a;
    nodes_[points - 1].x = b;
    if (!read(dynamics, nodes_[0]) || !read(dynamics, nodes_[points - 1])) return false;
    const Node &first = nodes_[0], &last = nodes_[points - 1];
    for (std::size_t j = 1; j + 1 < points; ++j) {  // from the cubic through both ends
      const double s = place[j], r = 1 - s;
      const double from_a = r * r * (1 + 2 * s), from_b = s * s * (1 + 2 * r);
      State& x = nodes_[j].x;
      x = a;
      x.t = a.t + s * h_;
      x.q = from_a * a.q + from_b * b.q + h_ * s * r * (r * first.q_dot - s * last.q_dot);
      x.nu = from_a * a.nu + from_b * b.nu + h_ * s * r * (r * first.nu_dot - s * last.nu_dot);
    }
    State found = b, before = b;
    double change = infinity;
    const double speed = std::max(a.nu.lpNorm<Eigen::Infinity>(), b.nu.lpNorm<Eigen::Infinity>());
    for (int round = 0; round < most_rounds; ++round) {
      for (std::size_t j = 1; j + 1 < points; ++j) {
        for (const Body& body : dynamics.model().bodies())
          if (body.kind == BodyKind::Spatial) nodes_[j].x.q.segment<4>(body.q0 + 3).normalize();
        if (!read(dynamics, nodes_[j])) return false;
      }
      before = found;
      for (std::size_t j = 1; j < points; ++j) {
        State& x = j + 1 == points ? found : nodes_[j].x;
        x.q = a.q;
        x.nu = a.nu;
        for (std::size_t k = 0; k < points; ++k) {
          x.q += h_ * integral[j][k] * nodes_[k].q_dot;
          x.nu += h_ * integral[j][k] * nodes_[k].nu_dot;
        }
      }
      const double last_change = change;
      change = (found.nu - before.nu).lpNorm<Eigen::Infinity>() +
               (found.q - before.q).lpNorm<Eigen::Infinity>() / h_;
      if (change <= tolerance * speed || change > least_gain * last_change) break;
    }
    if (!dynamics.evaluate(b)) return false;
    judge(dynamics, b, found);
    return true;
  }();
  if (!fine) (void)dynamics.evaluate(b);
  dynamics.evaluations = evaluations;
  return fine;
}

void RowQuadrature::judge(const ModeDynamics& dynamics, const State& b, const State& found) {
  const Model& model = dynamics.model();
  Vector momentum;
  multiply_mass(model, dynamics.instant(), Vector(b.nu - found.nu), momentum);
  momentum_residual = momentum.size() > 0 ? momentum.lpNorm<Eigen::Infinity>() : 0;
  kinematic_residual = 0;
  for (const Body& body : model.bodies()) {
    if (body.nv == 0) continue;
    const int n = body.kind == BodyKind::Generalized ? body.nq : 3;
    const double moved = (b.q - found.q).segment(body.q0, n).lpNorm<Eigen::Infinity>();
    kinematic_residual = std::max(kinematic_residual, moved);
    if (body.kind != BodyKind::Spatial) continue;
    const auto orientation = [&](const Vector& q) {
      return Quaternion(q[body.q0 + 3], q[body.q0 + 4], q[body.q0 + 5], q[body.q0 + 6]);
    };
    const Quaternion off = orientation(found.q).normalized().conjugate() * orientation(b.q);
    kinematic_residual = std::max({kinematic_residual, 2 * off.vec().lpNorm<Eigen::Infinity>(),
                                   std::abs(orientation(b.q).squaredNorm() - 1)});
  }
}

RowSums RowQuadrature::sums(const Model& model) const {
  RowSums row;
  row.known = true;
  for (std::size_t i = 0; i < nodes_[0].normal.size(); ++i) {
    row.normal.push_back(sum([i](const Node& n) { return n.normal[i]; }));
    row.impulse.emplace_back(sum([i](const Node& n) { return n.force[i]; }));
  }
  for (std::size_t i = 0; i < nodes_[0].moment.size(); ++i)
    row.moment.emplace_back(sum([i](const Node& n) { return n.moment[i]; }));
  row.joint_reaction = sum([](const Node& n) { return n.joint_reaction; });
  row.joint_friction = sum([](const Node& n) { return n.joint_friction; });
  row.friction = sum([](const Node& n) { return n.power.friction; });
  row.load = sum([](const Node& n) { return n.power.load; }) + generalized_work(model);
  row.motor = sum([](const Node& n) { return n.power.motor; });
  row.surface = sum([](const Node& n) { return n.power.surface; });
  row.momentum_residual = momentum_residual;
  row.kinematic_residual = kinematic_residual;
  return row;
}

double RowQuadrature::generalized_work(const Model& model) const {
  double work = 0;
  std::size_t i = 0;
  for (const Body& b : model.bodies()) {
    if (b.kind != BodyKind::Generalized) continue;
    for (std::size_t j = 0; j < points; ++j) {  // nu^T M' nu/2
      const Vector nu = nodes_[j].x.nu.segment(b.v0, b.nv);
      for (std::size_t k = 0; k < points; ++k)
        work += 0.5 * weight[j] * slope[j][k] * nu.dot(nodes_[k].M[i] * nu);
    }
    ++i;
    if (!b.system.potential) continue;
    const auto V = [&](const Node& node) { return b.system.potential(node.x.q.segment(b.q0, b.nq)); };
    work += V(nodes_[points - 1]) - V(nodes_[0]);
  }
  return work;
}

}  // namespace perp
