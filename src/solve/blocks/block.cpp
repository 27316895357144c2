#include "solve/blocks/block.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

/// dh/dn and h(n) = -d/dn of half the squared distance of z from n E.
struct Pull {
  double value = 0, slope = 0;
};

Pull pull_of(const Vector3& axes, double n, const Vector3& z) {
  if (!(n > 0)) return {ellipsoid_support(axes, z), 0};
  const EllipsoidProjection at = project_on_ellipsoid(axes, n, z);
  if (at.inside) return {};
  double weight = 0, turn = 0;  // |e(t, n)| = 1 gives dt/dn
  for (int k = 0; k < 3; ++k) {
    const double square = axes(k) * axes(k), below = n * n * square + at.multiplier;
    if (!(square > 0)) continue;
    const double e = axes(k) * n * z(k) / below;
    weight += e * e / below;
    turn += e * e * square / below;
  }
  const double dt = (1 / n - 2 * n * turn) / weight;
  return {at.multiplier / n, dt / n - at.multiplier / (n * n)};
}

/// The normal entry of the projection onto K: the root of n - z_N - sum_g h_g(n) by Newton's method between brackets.
template <int R>
double projected_normal(const Block<R>& block, const Column<R>& z) {
  double high = z(0);
  for (const RowGroup& group : RowGroups<R>::all)
    high += ellipsoid_support(Block<R>::rows(block.axes, group), Block<R>::rows(z, group));
  if (!(high > 0)) return 0;  // in the polar cone
  double low = std::max(0.0, z(0)), n = low > 0 ? low : high;
  constexpr int most = 100;
  for (int step = 0; step < most; ++step) {
    double value = n - z(0), slope = 1;
    for (const RowGroup& group : RowGroups<R>::all) {
      const Pull pull = pull_of(Block<R>::rows(block.axes, group), n, Block<R>::rows(z, group));
      value -= pull.value;
      slope -= pull.slope;
    }
    (value < 0 ? low : high) = n;
    double next = n - value / slope;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (value == 0 || next == n || high - low <= 1e-16 * high) break;
    n = next;
  }
  return n;
}

template <int R>
void project_groups(const Block<R>& block, double size, const Column<R>& z, Column<R>& p) {
  for (const RowGroup& group : RowGroups<R>::all) {
    if (!block.has(group)) continue;
    const Vector3 point =
        project_on_ellipsoid(Block<R>::rows(block.axes, group), size, Block<R>::rows(z, group)).p;
    p.segment(group.first, group.size) = point.head(group.size);
  }
}

/// Onto the circular cone (N, T1, T2), in closed form.
Vector3 project_circular(double mu, const Vector3& z) {
  const double tangential = z.tail<2>().norm();
  if (tangential <= mu * z(0)) return z;
  if (mu * tangential <= -z(0)) return Vector3::Zero();
  const double normal = (z(0) + mu * tangential) / (1 + mu * mu);  // foot on the cone's side
  const double ratio = mu * normal / tangential;
  return {normal, ratio * z(1), ratio * z(2)};
}

/// Onto the half line and the disc of that size, with the derivative.
void alart_curnier_disc(double mu, bool planar, const Vector3& z, Vector3& p, Matrix3& P) {
  const double tangential = z.tail<2>().norm();
  const double radius = mu * z(0);
  if (tangential <= radius) {
    p.tail<2>() = z.tail<2>();
    P(1, 1) = 1;
    P(2, 2) = planar ? 0 : 1;
    return;
  }
  const Vector2 d = z.tail<2>() / tangential;
  p.tail<2>() = radius * d;
  P.block<2, 1>(1, 0) = mu * d;
  if (!planar)
    P.block<2, 2>(1, 1) = (radius / tangential) * (Eigen::Matrix2d::Identity() - d * d.transpose());
}

}  // namespace

template <int R>
Block<R> make_block(const FrictionProblem& problem, Eigen::Index i, const Column<R>& s, double sigma) {
  const BlockLayout& layout = layout_of(problem.kind(i));
  Block<R> block;
  block.contact = layout.contact;
  for (int k = 0; k < layout.rows; ++k) {
    const int place = layout.place[static_cast<size_t>(k)];
    if (place > 0)
      block.axes(place) = layout.contact ? semi_axis(problem, i, place) * (s(0) / s(place))
                                         : semi_axis(problem, i, place) / (s(place) * sigma);
  }
  if (block.axes.maxCoeff() > 0) block.radius = not_set;
  if constexpr (R == 3) {
    block.tangents = layout.place[static_cast<size_t>(layout.rows) - 1];
    if (block.tangents < 2 || block.axes(1) == block.axes(2)) block.radius = block.axes(1);
  }
  return block;
}

template <int R>
Block<R> make_block(const FrictionProblem& problem, Eigen::Index i) {
  return make_block<R>(problem, i, Column<R>::Ones(), 1);
}

template <int R>
Column<R> augmented_velocity(const Block<R>& block, const Column<R>& u) {
  Column<R> u_hat = u;
  if (!block.contact || block.frictionless()) return u_hat;
  if constexpr (R == 3) {
    if (block.is_disc()) {
      u_hat(0) = u(0) + block.radius * u.template tail<2>().norm();
      return u_hat;
    }
  }
  for (const RowGroup& group : RowGroups<R>::all)
    u_hat(0) += ellipsoid_support(Block<R>::rows(block.axes, group), Block<R>::rows(u, group));
  return u_hat;
}

template <int R>
int Block<R>::groups() const {
  int count = 0;
  for (const RowGroup& group : RowGroups<R>::all) count += has(group) ? 1 : 0;
  return count;
}

template <int R>
Column<R> slip_gradient(const Block<R>& block, const Column<R>& u) {
  Column<R> slope = Column<R>::Zero();
  if (!block.contact || block.frictionless()) return slope;
  if constexpr (R == 3) {
    if (block.is_disc()) {
      const double slip = u.template tail<2>().norm();
      if (slip > 0) slope.template tail<2>() = block.radius * u.template tail<2>() / slip;
      return slope;
    }
  }
  for (const RowGroup& group : RowGroups<R>::all)
    slope.segment(group.first, group.size) =
        ellipsoid_support_gradient(Block<R>::rows(block.axes, group), Block<R>::rows(u, group))
            .head(group.size);
  return slope;
}

template <int R>
Column<R> cone_scaling(const Block<R>& block) {
  const double longest = block.axes.maxCoeff(), root = std::sqrt(longest);
  Column<R> P = Column<R>::Constant(1 / root);
  P(0) = root;
  if (block.is_disc()) return P;
  for (int k = 1; k < R; ++k)
    if (block.axes(k) > 0) P(k) = root / block.axes(k);
  return P;
}

template <int R>
Column<R> project_block(const Block<R>& block, const Column<R>& z) {
  Column<R> p = Column<R>::Zero();
  if (!block.contact) {
    if (block.planar())
      p(1) = std::clamp(z(1), -block.radius, block.radius);
    else
      project_groups(block, 1, z, p);
  } else if (block.frictionless()) {
    p(0) = std::max(0.0, z(0));
  } else {
    if constexpr (R == 3)
      if (block.is_disc()) return project_circular(block.radius, z);
    p(0) = projected_normal(block, z);
    if (p(0) > 0) project_groups(block, p(0), z, p);
  }
  return p;
}

template <int R>
void alart_curnier_projection(const Block<R>& block, const Column<R>& z, Column<R>& p, Square<R>& P) {
  p.setZero();
  P.setZero();
  if (block.contact) {
    if (z(0) <= 0) return;
    p(0) = z(0);
    P(0, 0) = 1;
    if constexpr (R == 3) {
      if (block.tangents == 0) return;
      if (block.is_disc() || block.frictionless()) {
        alart_curnier_disc(block.radius, block.planar(), z, p, P);
        return;
      }
    }
  } else if (block.planar()) {
    p(1) = std::clamp(z(1), -block.radius, block.radius);
    P(1, 1) = std::abs(z(1)) < block.radius ? 1 : 0;
    return;
  }
  const double size = block.contact ? z(0) : 1;
  for (const RowGroup& group : RowGroups<R>::all) {
    if (!block.has(group)) continue;
    const Vector3 axes = Block<R>::rows(block.axes, group), z_g = Block<R>::rows(z, group);
    const EllipsoidProjection at = project_on_ellipsoid(axes, size, z_g);
    const EllipsoidSlope slope = differentiate(at, axes, size, z_g);
    p.segment(group.first, group.size) = at.p.head(group.size);
    P.block(group.first, group.first, group.size, group.size) =
        slope.dz.topLeftCorner(group.size, group.size);
    if (block.contact) P.block(group.first, 0, group.size, 1) = slope.ds.head(group.size);
  }
}

template struct Block<3>;
template struct Block<6>;
template Vector3 slip_gradient<3>(const Block<3>&, const Vector3&);
template Column<6> slip_gradient<6>(const Block<6>&, const Column<6>&);
template Vector3 cone_scaling<3>(const Block<3>&);
template Column<6> cone_scaling<6>(const Block<6>&);
template Block<3> make_block<3>(const FrictionProblem&, Eigen::Index, const Vector3&, double);
template Block<6> make_block<6>(const FrictionProblem&, Eigen::Index, const Column<6>&, double);
template Block<3> make_block<3>(const FrictionProblem&, Eigen::Index);
template Block<6> make_block<6>(const FrictionProblem&, Eigen::Index);
template Vector3 augmented_velocity<3>(const Block<3>&, const Vector3&);
template Column<6> augmented_velocity<6>(const Block<6>&, const Column<6>&);
template Vector3 project_block<3>(const Block<3>&, const Vector3&);
template Column<6> project_block<6>(const Block<6>&, const Column<6>&);
template void alart_curnier_projection<3>(const Block<3>&, const Vector3&, Vector3&, Matrix3&);
template void alart_curnier_projection<6>(const Block<6>&, const Column<6>&, Column<6>&, Square<6>&);

}  // namespace perp
