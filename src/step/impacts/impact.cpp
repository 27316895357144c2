#include "perp/step/impact.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/reduced_system.hpp"
#include "perp/solve/friction_solver.hpp"
#include "solve/friction/even_friction.hpp"
#include "step/impacts/impact_sequence.hpp"
#include "step/modes/modes.hpp"
#include "step/parts/contact_blocks.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
namespace {

bool contains(const std::vector<int>& points, int point) {
  return std::find(points.begin(), points.end(), point) != points.end();
}

/// The touching contacts' velocities as a function of their impulses, u = W r + q.
struct Touching {
  Instant s;
  Island island;
  ReducedSystem reduced;
  FrictionProblem problem;  // W and q at the velocities before
  Vector approach;          // u_n- of each contact
  double speed = 0;         // what speeds are measured by
  double length = 0;        // and lengths

  Touching(const Model& model, const State& x, const ImpactOptions& options) {
    evaluate(model, x, s);
    if (!s.fault.empty()) refuse("solve_impact", "x", "a state", s.fault);
    const Scales scales = scales_of(model, x, s);
    speed = scales.speed;
    length = scales.length;
    s.joint_frictions.clear();
    island.joint_rows.resize(s.joint_rows.size());
    std::iota(island.joint_rows.begin(), island.joint_rows.end(), 0);
    Vector joint_bias(static_cast<Eigen::Index>(s.joint_rows.size()));
    for (std::size_t i = 0; i < s.joint_rows.size(); ++i)
      joint_bias[static_cast<Eigen::Index>(i)] = s.joint_rows[i].psi_b_t;
    std::vector<double> normal;
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
      const ContactInstant& c = s.contacts[i];
      if (c.psi_n > (std::isnan(options.small_gap) ? scales.small_gap() : options.small_gap)) continue;
      if (!options.only.empty() && !contains(options.only, c.point)) continue;
      island.contacts.push_back(static_cast<int>(i));
      normal.push_back(c.velocity(x.nu).x());
    }
    reduced.assemble(model, s, island, x.nu, joint_bias);
    problem.W = reduced.W;
    problem.q = reduced.q;
    ContactBlocks blocks;
    for (std::size_t i = 0; i < island.contacts.size(); ++i)
      (void)blocks.add(s, s.contacts[at(island.contacts[i])], normal_row(i));
    blocks.give(problem);
    approach = Eigen::Map<Vector>(normal.data(), static_cast<Eigen::Index>(normal.size()));
  }

  int normal_row(std::size_t i) const { return reduced.rows_of(static_cast<int>(i)); }
  const ContactInstant& contact(std::size_t i) const { return s.contacts[at(island.contacts[i])]; }

  /// Whether nothing that touches approaches at nu, and joints hold: of contacts that joints hold still W says no more than rounding.
  bool parts(const Vector& nu) const {
    constexpr double most = 1e-6;  // of the speeds
    return std::all_of(island.contacts.begin(), island.contacts.end(),
                       [&](int i) { return s.contacts[at(i)].velocity(nu).x() >= -most * speed; }) &&
           std::all_of(s.joint_rows.begin(), s.joint_rows.end(), [&](const JointRowInstant& row) {
             const double arm = row.world.linear.isZero(0) ? length : 1;
             return arm * std::abs(row.velocity(nu)) <= most * speed;
           });
  }

  /// nu+, and the joints' reactions to r.
  Vector velocity(const Model& model, const State& x, const Vector& r, Vector& reactions) const {
    Vector impulse = Vector::Zero(model.nv()), change;
    reactions.setZero(static_cast<Eigen::Index>(s.joint_rows.size()));
    reduced.add_impulses(s, island, r, impulse, reactions);
    solve_mass(model, s, impulse, change);
    return x.nu + change;
  }
};

/// Where contacts are redundant, those that all methods take: an impact at contacts that give a little, all alike.
FrictionSolution solve_evenly(const Model& model, const Touching& touching, const FrictionProblem& problem) {
  Matrix C;
  Vector k;
  touching.reduced.compliance(model, touching.s, touching.island, C, k);
  return perp::solve_evenly(problem, C, k);
}

/// r of the law u_n+ >= -e u_n-; `e` of each contact.
FrictionSolution newton(const Model& model, const Touching& touching, const Vector& e) {
  FrictionProblem problem = touching.problem;
  for (std::size_t i = 0; i < touching.island.contacts.size(); ++i)
    problem.q[touching.normal_row(i)] +=
        e[static_cast<Eigen::Index>(i)] * std::min(touching.approach[static_cast<Eigen::Index>(i)], 0.0);
  return solve_evenly(model, touching, problem);
}

/// Compression to u_n = 0, then normal impulses e times as large with the friction that they allow; what would then still
/// approach is stopped.
FrictionSolution poisson(const Model& model, const Touching& touching, const Vector& e) {
  FrictionSolution compression = solve_evenly(model, touching, touching.problem);
  if (!compression.solved()) return compression;
  FrictionProblem second = touching.problem;
  second.q = compression.u;
  Matrix W = second.W.dense();
  for (std::size_t i = 0; i < touching.island.contacts.size(); ++i) {
    // rows of the normals say r_n - e p_n = 0: normal impulses are given
    const int row = touching.normal_row(i);
    W.row(row).setZero();
    W(row, row) = touching.problem.W.dense()(row, row);
    second.q[row] = -W(row, row) * e[static_cast<Eigen::Index>(i)] * compression.r[row];
  }
  second.W = W;
  const FrictionSolution decompression = solve_friction(second);
  if (!decompression.solved()) return decompression;
  FrictionProblem rest = touching.problem;
  rest.q = compression.u + touching.problem.W.dense() * decompression.r;
  FrictionSolution last = solve_friction(rest);
  last.r += compression.r + decompression.r;
  return last;
}

/// Impulses though no contact approaches: those that a slight approach at sliding contacts needs, as it goes to nothing.
FrictionSolution jam(const Model& model, const Touching& touching) {
  const auto approaching = [&](double slight) {
    FrictionProblem problem = touching.problem;
    for (std::size_t i = 0; i < touching.island.contacts.size(); ++i)
      problem.q[touching.normal_row(i)] -= slight * touching.speed;
    return solve_evenly(model, touching, problem);
  };
  constexpr double slight = 1e-6;  // of the speeds; impulses are linear in it but where sliding turns
  const FrictionSolution far = approaching(slight);
  FrictionSolution near = approaching(slight / 2);
  if (!far.solved() || !near.solved() || !((far.r - near.r).norm() <= 1e-3 * near.r.norm())) {
    near.status = FrictionStatus::BestFound;
    return near;
  }
  near.r = 2 * near.r - far.r;
  return near;
}

/// What r is at each contact.
std::vector<ImpactContact> contacts_of(const Model& model, const Touching& touching, const Vector& r,
                                       const Vector& nu, const Vector& nu_after) {
  std::vector<ImpactContact> contacts;
  for (std::size_t i = 0; i < touching.island.contacts.size(); ++i) {
    const ContactInstant& c = touching.contact(i);
    const int row = touching.normal_row(i);
    const Vector3 mean = 0.5 * (c.velocity(nu) + c.velocity(nu_after));
    Vector3 p = Vector3::Zero(), p_m = Vector3::Zero();
    p.head(1 + c.tangents) = r.segment(row, 1 + c.tangents);
    double friction = p.tail<2>().dot(mean.tail<2>());
    bool at_bound = p.tail<2>().norm() >= c.mu * p.x() * (1 - 1e-9);
    if (const MomentInstant* m = touching.s.moments_of(c); m != nullptr) {
      for (int k = 0; k < m->rows(c.tangents); ++k)
        p_m[m->columns(c.tangents)[at(k)]] = r[moment_row(c, row) + k];
      friction += 0.5 * p_m.dot(m->velocity(nu) + m->velocity(nu_after));
      at_bound = sliding_pull(c, *m, p, p_m, lever_of(model, touching.s, c, *m)) >= p.x() * (1 - 1e-9);
    }
    contacts.push_back({.contact = c.contact,
                        .point = c.point,
                        .impulse = c.frame * p,
                        .moment = c.frame * p_m,
                        .p_n = p.x(),
                        .approach = touching.approach[static_cast<Eigen::Index>(i)],
                        .rebound = c.velocity(nu_after).x(),
                        .friction = friction,
                        .mode = !(p.x() > 0)                  ? ContactMode::Open
                                : c.tangents == 0 || at_bound ? ContactMode::Slip
                                                              : ContactMode::Stick});
  }
  return contacts;
}

Impact at_once(const Model& model, const State& x, const ImpactOptions& options) {
  const Touching touching(model, x, options);
  const auto count = static_cast<Eigen::Index>(touching.island.contacts.size());
  Vector e = Vector::Zero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ContactInstant& c = touching.contact(at(i));
    if (!contains(options.inelastic, c.point)) e[i] = c.e;
  }

  Impact impact;
  impact.nu = x.nu;
  Vector r = Vector::Zero(touching.problem.rows());
  const double before = model.kinetic_energy(x);
  State after = x;
  const auto take = [&](const FrictionSolution& solution) {
    if (!solution.solved()) return false;
    r = solution.r;
    impact.residual = solution.residual;
    after.nu = touching.velocity(model, x, r, impact.joint_reactions);
    impact.solved = after.nu.allFinite() && touching.parts(after.nu);
    return impact.solved;
  };
  // what prescribed bodies do adds energy by right
  const bool rheonomic =
      std::any_of(touching.island.contacts.begin(), touching.island.contacts.end(),
                  [&](int i) { return touching.s.contacts[at(i)].bias != Vector3::Zero(); });
  const auto dissipates = [&] { return rheonomic || model.kinetic_energy(after) <= before * (1 + 1e-12); };
  if (count == 0) {
    after.nu = touching.velocity(model, x, r, impact.joint_reactions);
    impact.solved = true;
    impact.residual = 0;
  } else if (options.without_collision) {
    (void)take(jam(model, touching));
  } else {
    if (options.restitution == Restitution::Newton) (void)take(newton(model, touching, e));
    if (!impact.solved || !dissipates()) (void)take(poisson(model, touching, e));
    if (!impact.solved || !dissipates()) (void)take(newton(model, touching, Vector::Zero(count)));
  }
  if (!impact.solved) return impact;

  impact.nu = after.nu;
  impact.energy = model.kinetic_energy(after) - before;
  impact.contacts = contacts_of(model, touching, r, x.nu, impact.nu);
  return impact;
}

}  // namespace

std::string_view name_of(ImpactOrder order) {
  return order == ImpactOrder::Sequential ? "sequential" : "simultaneous";
}

ImpactOrder impact_order_named(std::string_view name) {
  for (const ImpactOrder order : {ImpactOrder::Simultaneous, ImpactOrder::Sequential})
    if (name == name_of(order)) return order;
  refuse("impacts", "order", name, "needs to be simultaneous or sequential");
}

Impact solve_impact(const Model& model, const State& x, const ImpactOptions& options) {
  model.check("solve_impact", x);
  return options.order == ImpactOrder::Sequential && !options.without_collision
             ? solve_in_sequence(model, x, options)
             : at_once(model, x, options);
}

}  // namespace perp
