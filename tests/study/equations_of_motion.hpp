// Does a motion satisfy the model's equations? The residual of the instantaneous model (5)-(12) at one state of it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/QR>
#include <vector>

#include "perp/instant/instant.hpp"
#include "perp/study/scene.hpp"

namespace perp {

/// The largest violation of each part of the model at exact(t). Rates come from a central difference of order 8, so t must
/// be further than 4 delta from the start and from every switch. Which forces act is not part of a motion: they are those
/// of the friction law that explain M nu' - k best.
struct EquationsOfMotion {
  double newton_euler = 0;  ///< |M nu' - k - W c|, the seed's (5), for c that obeys (9)-(12) [N, N m]
  double kinematic = 0;     ///< |q' - G nu|, (6) [m/s, rad/s]
  double joints = 0;        ///< |psi_b|, (7) [m, rad]
  double overlap = 0;       ///< max(0, -psi_n), (8) [m]
  int touching = 0;         ///< contact points that are closed: those that may push
  int sliding = 0;          ///< of these
};

struct EquationsOfMotionOptions {
  double delta = 1e-3;           ///< [s] of the difference quotient
  double gap_tolerance = 1e-12;  ///< [m] a contact within it is closed
  double slip_tolerance = 1e-9;  ///< [m/s, rad/s] a contact or joint slower than this sticks
};

namespace equations_of_motion_detail {

/// Reactions of one kind along some columns of W, and the nearest admissible one to any vector.
struct Reaction {
  /// Moments: a push and behind it columns of torsion and rolling, a unit of which is what a unit of it bounds.
  enum Kind { Free, Push, Cone, Interval, Moments } kind = Free;
  int first = 0, size = 1;
  double limit =
      0;  // mu of the cone, c_max of the interval; of moments how many of the columns slide and twist

  void admit(Vector& c) const {
    auto r = c.segment(first, size);
    if (kind == Push || kind == Moments) r[0] = std::max(r[0], 0.0);
    if (kind == Interval) r[0] = std::clamp(r[0], -limit, limit);
    if (kind == Moments) {
      const auto within = [&](auto group) {
        if (const double length = group.norm(); length > r[0]) group *= r[0] / length;
      };
      const auto sliding = static_cast<Eigen::Index>(limit);
      within(r.segment(1, sliding));
      within(r.tail(size - 1 - sliding));
    }
    if (kind != Cone) return;
    const double n = r[0], f = r.tail(size - 1).norm();
    if (f <= limit * n) return;
    const double along = std::max((n + limit * f) / (1 + limit * limit), 0.0);  // onto the cone's surface
    r[0] = along;
    if (f > 0) r.tail(size - 1) *= limit * along / f;
  }
};

struct Reactions {
  std::vector<Vector> columns;
  std::vector<Reaction> sets;
  Vector known;  // forces that are given: of joints that slide

  void add(Reaction::Kind kind, double limit, std::vector<Vector> more) {
    sets.push_back({kind, static_cast<int>(columns.size()), static_cast<int>(more.size()), limit});
    columns.insert(columns.end(), more.begin(), more.end());
  }

  /// min |W c - force| over admissible c, by alternating projections from the least-squares solution.
  double misfit(const Vector& force) const {
    const Vector target = force - known;
    if (columns.empty()) return target.lpNorm<Eigen::Infinity>();
    Matrix W(target.size(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t i = 0; i < columns.size(); ++i) W.col(static_cast<Eigen::Index>(i)) = columns[i];
    const Eigen::CompleteOrthogonalDecomposition<Matrix> pseudo_inverse(W);
    Vector c = pseudo_inverse.solve(target);
    double best = infinity;
    for (int i = 0; i < 500; ++i) {
      for (const Reaction& set : sets) set.admit(c);
      const Vector rest = target - W * c;
      if (!(rest.lpNorm<Eigen::Infinity>() < best)) break;
      best = rest.lpNorm<Eigen::Infinity>();
      c += pseudo_inverse.solve(rest);
    }
    return best;
  }
};

template <class Map>
Vector column(const Map& W, int direction, Eigen::Index nv) {
  typename Map::Columns unit = Map::Columns::Zero();
  unit[direction] = 1;
  Vector out = Vector::Zero(nv);
  W.add_impulse(unit, out);
  return out;
}

/// G(q) nu, the seed's (6).
inline Vector rate_of_q(const Model& model, const State& x) {
  Vector rate = Vector::Zero(model.nq());
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    rate.segment<3>(b.q0) = x.nu.segment<3>(b.v0);
    if (b.kind != BodyKind::Spatial) continue;
    const Vector3 w = x.nu.segment<3>(b.v0 + 3);
    const Quaternion q(x.q[b.q0 + 3], x.q[b.q0 + 4], x.q[b.q0 + 5], x.q[b.q0 + 6]);
    const Quaternion half = q * Quaternion(0, w.x() / 2, w.y() / 2, w.z() / 2);
    rate.segment<4>(b.q0 + 3) << half.w(), half.x(), half.y(), half.z();
  }
  return rate;
}

/// A contact with torsion or rolling: what is at rest may act as its bound allows, what moves acts as -p_n A² u/|A u|.
inline void add_with_moments(const ContactInstant& contact, const MomentInstant& m, const Vector& nu,
                             std::vector<Vector> columns, double slow, Reactions& reactions) {
  const Vector3 u = contact.velocity(nu), w = m.velocity(nu);
  const std::array<double, 5> axes{contact.mu, m.mu_o, m.torsion, m.rolling, m.rolling},
      speeds{u.y(), u.z(), w.x(), w.y(), w.z()};
  std::vector<Vector> all{columns[0]}, groups[2];
  for (std::size_t i = 0; i < 5; ++i) {
    const int row = static_cast<int>(i);
    const bool used = axes[i] > 0 && !(contact.tangents == 1 && (i == 1 || i == 3));
    const Vector along = i < 2 ? column(contact.W, row + 1, nu.size()) : column(m.W, row - 2, nu.size());
    if (used) groups[i < 3 ? 0 : 1].push_back(axes[i] * along);
  }
  int sliding = 0;
  for (const int group : {0, 1}) {
    double size = 0, fastest = 0;
    for (std::size_t i = group == 0 ? 0 : 3; i < (group == 0 ? 3U : 5U); ++i) {
      size = std::hypot(size, axes[i] * speeds[i]);
      fastest = std::max(fastest, axes[i] > 0 ? std::abs(speeds[i]) : 0);
    }
    if (fastest <= slow) {
      all.insert(all.end(), groups[group].begin(), groups[group].end());
      if (group == 0) sliding = static_cast<int>(groups[0].size());
      continue;
    }
    std::size_t k = 0;
    for (std::size_t i = group == 0 ? 0 : 3; i < (group == 0 ? 3U : 5U); ++i)
      if (axes[i] > 0 && !(contact.tangents == 1 && (i == 1 || i == 3)))
        all[0] -= axes[i] * speeds[i] / size * groups[group][k++];
  }
  reactions.add(Reaction::Moments, sliding, all);
}

}  // namespace equations_of_motion_detail

[[nodiscard]] inline EquationsOfMotion equations_of_motion(const Scene& scene, double t,
                                                           const EquationsOfMotionOptions& options = {}) {
  using namespace equations_of_motion_detail;
  const Model& model = scene.model;
  const State x = scene.exact(t);
  Vector q_rate = Vector::Zero(model.nq()), acceleration = Vector::Zero(model.nv());
  constexpr std::array<double, 4> weights{4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  for (int i = 1; i <= 4; ++i) {
    const double weight = weights[static_cast<std::size_t>(i - 1)] / options.delta;
    const State after = scene.exact(t + i * options.delta), before = scene.exact(t - i * options.delta);
    q_rate += weight * (after.q - before.q);
    acceleration += weight * (after.nu - before.nu);
  }
  Instant instant;
  evaluate(model, x, instant);
  Vector force(model.nv());
  multiply_mass(model, instant, acceleration, force);
  force -= instant.k;

  EquationsOfMotion result;
  result.kinematic = (q_rate - rate_of_q(model, x)).lpNorm<Eigen::Infinity>();
  Reactions reactions;
  reactions.known = Vector::Zero(model.nv());
  for (const JointRowInstant& row : instant.joint_rows) {
    result.joints = std::max(result.joints, std::abs(row.psi_b));
    reactions.add(Reaction::Free, 0, {column(row.W, 0, model.nv())});
  }
  for (const JointRowInstant& row : instant.joint_frictions) {
    const double speed = row.velocity(x.nu);
    const Vector along = column(row.W, 0, model.nv());
    if (std::abs(speed) > options.slip_tolerance)
      reactions.known -= std::copysign(row.friction, speed) * along;
    else
      reactions.add(Reaction::Interval, row.friction, {along});
  }
  for (const ContactInstant& contact : instant.contacts) {
    result.overlap = std::max(result.overlap, -contact.psi_n);
    if (std::abs(contact.psi_n) > options.gap_tolerance) continue;
    ++result.touching;
    std::vector<Vector> columns;
    for (int i = 0; i <= contact.tangents; ++i) columns.push_back(column(contact.W, i, model.nv()));
    const Vector slip = contact.velocity(x.nu).segment(1, contact.tangents);
    if (const MomentInstant* m = instant.moments_of(contact)) {
      add_with_moments(contact, *m, x.nu, columns, options.slip_tolerance, reactions);
      continue;
    }
    if (contact.tangents == 0) {
      reactions.add(Reaction::Push, 0, columns);
    } else if (slip.norm() <= options.slip_tolerance) {
      reactions.add(Reaction::Cone, contact.mu, columns);
    } else {
      ++result.sliding;
      for (int i = 0; i < contact.tangents; ++i)
        columns[0] -= contact.mu * slip[i] / slip.norm() * columns[static_cast<std::size_t>(i) + 1];
      reactions.add(Reaction::Push, 0, {columns[0]});
    }
  }
  result.newton_euler = reactions.misfit(force);
  return result;
}

}  // namespace perp
