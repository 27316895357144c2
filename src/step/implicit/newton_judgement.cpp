// How well a guess solves a step: residuals, and which islands pass.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "solve/friction/cone.hpp"
#include "step/certificate/closeness.hpp"
#include "step/implicit/nonsmooth_newton.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
namespace {

/// F = p - projection(p - rho u/w) and P. A contact that touches without a load, z_n within `rounding` [m/s] of zero, counts as
/// closed in P: so a stack that begins to carry closes all of its joints at once, not one in an iteration. With `rounding` < 0 it
/// does not.
void alart_curnier(const Reaction& r, double rounding, LinearizedReaction& row) {
  const Vector3 z = r.p - row.rho / r.w * r.u;
  Vector3 projected;
  if (r.law == Law::Equality) {
    projected = {z.x(), 0, 0};
    row.P = Vector3(1, 0, 0).asDiagonal();
  } else {
    alart_curnier_projection(kind_of(r.law), r.mu, z, projected, row.P);
    if (r.law != Law::Interval && z.x() <= 0 && r.w * z.x() >= -row.rho * rounding) {
      const double slip = z.tail<2>().norm();
      const bool sticks = r.w * slip <= row.rho * rounding;
      const Vector3 touching = sticks ? Vector3(1, 0, 0) : Vector3(1e-8 * slip, z.y(), z.z());
      Vector3 unused;
      alart_curnier_projection(kind_of(r.law), r.mu, touching, unused, row.P);
    }
  }
  row.F = r.p - projected;
}

/// The same of a contact with moments, whose rows the second, `moments`, has.
void alart_curnier(const Reaction& r, const Reaction& m, double rounding, LinearizedReaction& row,
                   LinearizedReaction& moments, Matrix6& P) {
  const Vector6 z = whole(r.p, m.p) - row.rho / r.w * whole(r.u, m.u);
  const SemiAxes axes = semi_axes_of(r, m);
  Vector6 projected;
  project_with_moments(axes, z, projected, P);
  if (z[0] <= 0 && r.w * z[0] >= -row.rho * rounding) {
    const double slip = z.tail<5>().norm();
    Vector6 touching = z, unused;
    touching[0] = 1e-8 * slip;
    if (r.w * slip <= row.rho * rounding) touching = Vector6::Unit(0);
    project_with_moments(axes, touching, unused, P);
  }
  row.F = r.p - projected.head<3>();
  moments.F = m.p - projected.tail<3>();
  row.P = P.topLeftCorner<3, 3>();
  moments.P = P.bottomRightCorner<3, 3>();
}

}  // namespace

/// F and P of reaction i by the map of that rho; those of a contact's moments come with the contact's.
void NonsmoothNewton::linearise(std::size_t i, const std::vector<Reaction>& reactions, double rho,
                                double rounding) {
  const Reaction& r = reactions[i];
  rows_[i].rho = rho;
  rows_[i].whole = nullptr;
  if (!r.has_moments) return alart_curnier(r, rounding, rows_[i]);
  rows_[i + 1].rho = rho;
  rows_[i + 1].whole = nullptr;
  Matrix6& P = with_moments_[i];
  alart_curnier(r, reactions[i + 1], rounding, rows_[i], rows_[i + 1], P);
  rows_[i].whole = &P;
}

double StepResiduals::largest() const { return std::max({momentum, normal, tangential, joints}); }

/// Of a body's velocities, angular ones by its radius of gyration [m/s].
double NonsmoothNewton::size_of(const Body& b, std::size_t body, const Vector& nu) const {
  if (b.nv == 0) return 0;
  const int linear = b.kind == BodyKind::Generalized ? b.nv
                     : b.kind == BodyKind::Planar    ? 2
                                                     : std::min(b.nv, 3);
  const double along = nu.segment(b.v0, linear).lpNorm<Eigen::Infinity>();
  return std::max(along, radius_[body] * nu.segment(b.v0 + linear, b.nv - linear).lpNorm<Eigen::Infinity>());
}

/// Residuals, merits and F, P at the guess evaluated last; false if they are not finite.
bool NonsmoothNewton::judge(const Model& model, const Options& options, const Vector& nu,
                            const std::vector<Reaction>& reactions, NewtonOutcome& outcome) {
  for (Island& island : islands_) {
    island.residuals = {};
    island.merit = island.size = 0;
    island.near = island.good = true;
  }
  doubts_.clear();
  double fastest = 0;
  for (std::size_t i = 0; i < model.bodies().size(); ++i)
    fastest = std::max(fastest, size_of(model.bodies()[i], i, nu));
  const double speed_rounding = 16 * closeness::eps * fastest;
  rows_.resize(reactions.size());
  misses_.resize(reactions.size());
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    LinearizedReaction& row = rows_[i];
    const double touching = i < left_open_.size() && left_open_[i] != 0 ? -1 : r.rounding + speed_rounding;
    Island& island = islands_[island_number(r)];
    if (r.law != Law::Moments) {
      linearise(i, reactions, 1, touching);
      misses_[i] = r.w * row.F.cwiseAbs();
      if (r.has_moments) misses_[i + 1] = r.w * rows_[i + 1].F.cwiseAbs();
      if (island.map > 0 && r.law != Law::Equality) linearise(i, reactions, steps_rho[island.map], touching);
    }
    const Vector3& miss = misses_[i];
    StepResiduals& e = island.residuals;
    if (r.law == Law::Equality)
      e.joints = std::max(e.joints, r.length * std::abs(r.u.x()));
    else if (r.law == Law::Moments)
      e.tangential = std::max(e.tangential, r.length * miss.x());
    else
      e.normal = std::max(e.normal, r.length * miss.x());
    e.tangential = std::max({e.tangential, r.length * miss.y(), r.length * miss.z()});
    const double worst = r.law == Law::Equality ? std::abs(r.u.x()) : miss.maxCoeff();
    judge_miss(
        island, options,
        {.miss = r.length * worst, .rounding = r.length * r.rounding, .reaction = static_cast<int>(i)});
    island.size = std::max(island.size, r.length * r.w * r.p.cwiseAbs().maxCoeff());
    if (r.u.x() < Reaction::no_point)
      island.size = std::max(island.size, r.length * r.u.cwiseAbs().maxCoeff());
    island.merit += r.w * row.F.squaredNorm();
  }
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv == 0) continue;
    Eigen::Matrix<double, 6, 1> y = Eigen::Matrix<double, 6, 1>::Zero();
    solve_mass(model, *instant_, static_cast<int>(i), R_.data() + b.v0, y.data());
    const auto R = R_.segment(b.v0, b.nv);
    const double energy = R.dot(y.head(b.nv));
    Island& island = islands_[at(island_[i])];
    StepResiduals& e = island.residuals;
    island.merit += energy;
    const double miss =
        b.kind == BodyKind::Generalized ? y.cwiseAbs().maxCoeff() : std::sqrt(std::abs(energy) / b.mass);
    judge_miss(island, options, {.miss = miss, .body = static_cast<int>(i)});
    e.momentum = std::max(e.momentum, miss);
    e.impulse = std::max(e.impulse, R.cwiseAbs().maxCoeff());
    island.size = std::max(island.size, size_of(b, i, nu));
  }
  settle_doubts(model, options, nu, reactions);
  return sum_up(outcome);
}

/// What all islands leave; false if it is not finite.
bool NonsmoothNewton::sum_up(NewtonOutcome& outcome) {
  StepResiduals& all = outcome.residuals;
  all = {};
  outcome.converged = std::all_of(islands_.begin(), islands_.end(),
                                  [](const Island& island) { return std::isfinite(island.merit); });
  if (!outcome.converged) {
    all.momentum = not_set;
    return false;
  }
  for (Island& island : islands_) {
    const StepResiduals& e = island.residuals;
    constexpr double eps = 16 * closeness::eps;
    island.floor = eps * island.size + island.rounding;
    outcome.converged = outcome.converged && island.good;
    all.momentum = std::max(all.momentum, e.momentum);
    all.impulse = std::max(all.impulse, e.impulse);
    all.normal = std::max(all.normal, e.normal);
    all.tangential = std::max(all.tangential, e.tangential);
    all.joints = std::max(all.joints, e.joints);
    all.speed = std::max(all.speed, island.speed);
  }
  return true;
}

void NonsmoothNewton::judge_miss(Island& island, const Options& options, const Doubt& miss) {
  const double mark = options.tolerance * island.speed + miss.rounding;
  if (miss.miss <= mark) return;
  if (miss.miss <= mark + closeness::most_rounding * island.speed || (miss.body >= 0 && options.h > 0))
    doubts_.push_back(miss);
  else
    island.near = island.good = false;
}

namespace {

/// Sizes of what adds up to a body's momentum: |W| |p| of its reactions.
void add_sizes_of_impulses(const std::vector<Reaction>& reactions, Vector& sizes) {
  for (const Reaction& r : reactions) {
    const Vector3 p = r.p.cwiseAbs();
    sizes.segment(r.W.va, r.W.na) += (r.W.A.cwiseAbs() * p).head(r.W.na);
    sizes.segment(r.W.vb, r.W.nb) += (r.W.B.cwiseAbs() * p).head(r.W.nb);
  }
}

/// Of what adds up to a row of u, and but for equalities of p, the largest sum of sizes [m/s].
double size_of_terms(const Reaction& r, const Vector& nu) {
  const Vector3 u = (r.W.A.transpose().cwiseAbs().leftCols(r.W.na) * nu.segment(r.W.va, r.W.na).cwiseAbs() +
                     r.W.B.transpose().cwiseAbs().leftCols(r.W.nb) * nu.segment(r.W.vb, r.W.nb).cwiseAbs());
  const double of_u = u.maxCoeff() + (r.u.x() < Reaction::no_point ? r.u.cwiseAbs().maxCoeff() : 0);
  return r.length * (of_u + (r.law == Law::Equality ? 0 : r.w * r.p.cwiseAbs().maxCoeff()));
}

}  // namespace

/// What positions, known to their last digit, are worth in (1): stiff springs tell one from the next.
void NonsmoothNewton::add_sizes_of_loads(const Model& model, const Options& options, Vector& sizes) const {
  Eigen::Matrix<double, 6, 1> reach;
  for (const Coupling& c : K_) {
    const Body &row = model.bodies()[at(c.row)], &column = model.bodies()[at(c.column)];
    const int linear = column.kind == BodyKind::Generalized ? column.nv
                       : column.kind == BodyKind::Planar    ? 2
                                                            : 3;
    for (int i = 0; i < column.nv; ++i) reach[i] = i < linear ? std::abs(options.start->q[column.q0 + i]) : 1;
    sizes.segment(row.v0, row.nv) +=
        c.value.topLeftCorner(row.nv, column.nv).cwiseAbs() * reach.head(column.nv) / options.h;
  }
}

/// Misses above the tolerance pass where rounding of what adds up to them leaves as much; they are near where algebra of terms as large as the
/// island's does.
void NonsmoothNewton::settle_doubts(const Model& model, const Options& options, const Vector& nu,
                                    const std::vector<Reaction>& reactions) {
  if (doubts_.empty()) return;
  Vector of_positions = Vector::Zero(model.nv()), of_impulses = of_positions;
  if (options.h > 0) add_sizes_of_loads(model, options, of_positions);
  add_sizes_of_impulses(reactions, of_impulses);
  for (const Doubt& d : doubts_) {
    Island& island =
        d.body >= 0 ? islands_[at(island_[at(d.body)])] : islands_[island_number(reactions[at(d.reaction)])];
    double mark = options.tolerance * island.speed + d.rounding, of_terms = 0;
    if (d.body >= 0) {
      const Body& b = model.bodies()[at(d.body)];
      Vector y = Vector::Zero(model.nv());
      const auto speed = [&](const Vector& f) {
        solve_mass(model, *instant_, d.body, f.data() + b.v0, y.data() + b.v0);
        return speed_of(b, f, y);
      };
      of_terms = speed(of_impulses) + size_of(b, at(d.body), nu);
      if (options.h > 0)
        mark += std::min(closeness::terms * closeness::eps * speed(of_positions),
                         options.tolerance * reach_of(b, *options.start) / options.h);
    } else {
      of_terms = size_of_terms(reactions[at(d.reaction)], nu);
    }
    const double most = closeness::most_rounding * island.speed;
    if (!(d.miss <= mark + std::min(closeness::of_terms * island.size, most)))
      island.near = island.good = false;
    if (!(d.miss <= mark + std::min(closeness::of_sum * of_terms, most))) island.good = false;
  }
}

}  // namespace perp
