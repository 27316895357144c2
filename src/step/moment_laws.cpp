#include "step/moment_laws.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "step/closeness.hpp"
#include "step/nonsmooth_newton.hpp"

namespace perp {

SemiAxes semi_axes_of(const Reaction& contact, const Reaction& moments) {
  const bool t = contact.law == Law::Planar || contact.law == Law::Cone, o = contact.law == Law::Cone;
  return {{t ? contact.mu : 0, o ? moments.mu_o : 0, moments.torsion / moments.lever},
          moments.rolling / moments.lever};
}

namespace {

/// lambda >= 0 with sum a_i² z_i²/(a_i² + lambda)² = radius², for z outside. 1/|.| of the left side is concave and nearly linear, so that
/// Newton's method on it comes from below without a search [CGT00, section 7.3].
double multiplier(const Vector3& a, double radius, const Vector3& z) {
  constexpr int most = 100;
  double lambda = 0;
  for (int k = 0; k < most; ++k) {
    double square = 0, slope = 0;
    for (int i = 0; i < 3; ++i) {
      if (!(a[i] > 0)) continue;
      const double d = a[i] * a[i] + lambda, x = a[i] * z[i] / d;
      square += x * x;
      slope += x * x / d;
    }
    const double size = std::sqrt(square);
    const double next = lambda + (size - radius) / radius * square / slope;
    if (!(next > lambda) || !std::isfinite(next)) break;
    lambda = next;
  }
  return lambda;
}

}  // namespace

Vector3 project_on_ellipsoid(const Vector3& a, double radius, const Vector3& z, Matrix3* by_z,
                             Vector3* by_radius) {
  Vector3 x = Vector3::Zero();
  if (by_z != nullptr) by_z->setZero();
  if (by_radius != nullptr) by_radius->setZero();
  double size = 0;
  for (int i = 0; i < 3; ++i)
    if (a[i] > 0) size = std::hypot(size, z[i] / a[i]);
  if (size <= radius) {
    for (int i = 0; i < 3; ++i)
      if (a[i] > 0) {
        x[i] = z[i];
        if (by_z != nullptr) (*by_z)(i, i) = 1;
      }
    return x;
  }
  if (!(radius > 0)) return x;
  const double lambda = multiplier(a, radius, z);
  Vector3 shrink = Vector3::Zero(), v = x, w = x;  // v the ellipsoid's normal at x, w = D v
  for (int i = 0; i < 3; ++i) {
    if (!(a[i] > 0)) continue;
    const double square = a[i] * a[i];
    shrink[i] = square / (square + lambda);
    x[i] = shrink[i] * z[i];
    v[i] = x[i] / square;
    w[i] = shrink[i] * v[i];
  }
  const double across = v.dot(w);
  if (by_z != nullptr) *by_z = Matrix3(shrink.asDiagonal()) - w * w.transpose() / across;
  if (by_radius != nullptr) *by_radius = w * (radius / across);
  return x;
}

void project_with_moments(const SemiAxes& axes, const Vector6& z, Vector6& p, Matrix6& P) {
  p.setZero();
  P.setZero();
  if (z[0] <= 0) return;
  p[0] = z[0];
  P(0, 0) = 1;
  Matrix3 by_z;
  Vector3 by_radius;
  p.segment<3>(1) = project_on_ellipsoid(axes.sliding, z[0], z.segment<3>(1), &by_z, &by_radius);
  P.block<3, 3>(1, 1) = by_z;
  P.block<3, 1>(1, 0) = by_radius;
  const Vector3 disc(axes.rolling, axes.rolling, 0), rolling(z[4], z[5], 0);
  p.tail<2>() = project_on_ellipsoid(disc, z[0], rolling, &by_z, &by_radius).head<2>();
  P.block<2, 2>(4, 4) = by_z.topLeftCorner<2, 2>();
  P.block<2, 1>(4, 0) = by_radius.head<2>();
}

Vector3 sliding_friction(const SemiAxes& axes, const Vector3& u) {
  const Vector3 scaled = axes.sliding.cwiseProduct(u);
  const double size = scaled.norm();
  return size > 0 ? Vector3(axes.sliding.cwiseProduct(scaled) / size) : Vector3::Zero();
}

Vector2 rolling_friction(const SemiAxes& axes, const Vector2& u) {
  const double size = u.norm();
  return size > 0 ? Vector2(axes.rolling / size * u) : Vector2::Zero();
}

namespace {

/// Size of a group's impulses, in units of its bound: 1 on it where p_n = 1.
double filling(const Vector3& a, const Vector3& p) {
  double size = 0;
  for (int i = 0; i < 3; ++i)
    if (a[i] > 0) size = std::hypot(size, p[i] / a[i]);
  return size;
}

bool moves_on_bound(const Vector3& a, const Vector3& p, const Vector3& u, double p_n, double speed) {
  Vector3 moving = u;
  for (int i = 0; i < 3; ++i)
    if (!(a[i] > 0)) moving[i] = 0;
  return !closeness::sticks(moving.norm(), speed) && closeness::on_bound(filling(a, p), std::max(p_n, 0.0));
}

}  // namespace

bool slides(const Reaction& contact, const Reaction& moments, double speed) {
  const SemiAxes axes = semi_axes_of(contact, moments);
  if (axes.sliding.isZero(0)) return true;  // as a contact without friction does
  return moves_on_bound(axes.sliding, {contact.p.y(), contact.p.z(), moments.p.x()},
                        {contact.u.y(), contact.u.z(), moments.u.x()}, contact.p.x(), speed);
}

bool rolls(const Reaction& contact, const Reaction& moments, double speed) {
  const double rolling = semi_axes_of(contact, moments).rolling;
  return moves_on_bound({rolling, rolling, 0}, {moments.p.y(), moments.p.z(), 0},
                        {moments.u.y(), moments.u.z(), 0}, contact.p.x(), speed);
}

void place_moments(const MomentInstant& m, Reaction& r) {
  r.W = m.W;
  r.W.A *= r.lever;
  r.W.B *= r.lever;
  r.mu_o = m.mu_o;
  r.torsion = m.torsion;
  r.rolling = m.rolling;
}

double lever_of(const Model& model, const Instant& s, const ContactInstant& c, const MomentInstant& m) {
  if (!(m.torsion > 0 || m.rolling > 0)) return 1;  // no rows to weigh
  const auto per_row = [&](const WrenchMap<3>& W) {
    const double mean = inverse_mass(model, s, W, Law::Moments);
    int rows = 0;
    for (int j = 0; j < 3; ++j) rows += W.A.col(j).isZero(0) && W.B.col(j).isZero(0) ? 0 : 1;
    return mean * 3 / std::max(rows, 1);
  };
  return std::sqrt(per_row(c.W) / per_row(m.W));
}

void need_no_moments(std::string_view method, const Model& model) {
  const Contact* contact = model.contact_with_moments();
  if (contact == nullptr) return;
  const std::string where = "contact '" + contact->name + "'",
                    why = "is not known to " + std::string(method) + "; ncp, ncp-start and ncp2 know it";
  if (contact->torsion > 0) refuse(where, "torsion", contact->torsion, why);
  if (contact->rolling > 0) refuse(where, "rolling", contact->rolling, why);
  refuse(where, "friction_axes", "given", why);
}

std::array<double, 2> MomentLaw::residuals(const Vector3& u, const Vector3& omega) const {
  const double bound = std::max(p.x(), 0.0), roll = m.rolling / lever;
  const auto miss = [&](const Vector3& axes, const Vector3& impulse, const Vector3& velocity) {
    return w * (impulse - project_on_ellipsoid(axes, bound, impulse - velocity / w)).norm();
  };
  return {miss(sliding_axes(), sliding(p, p_m.x() / lever), sliding(u, omega.x() * lever)),
          miss({roll, roll, 0}, {p_m.y() / lever, p_m.z() / lever, 0},
               {omega.y() * lever, omega.z() * lever, 0})};
}

std::array<double, 2> MomentLaw::tied(const Vector3& u, const Vector3& omega) const {
  const SemiAxes axes{sliding_axes(), m.rolling / lever};
  const Vector3 slide = sliding_friction(axes, sliding(u, omega.x() * lever));
  const Vector2 roll = rolling_friction(axes, lever * omega.tail<2>());
  const auto miss = [&](const auto& push, const auto& impulse) {
    return push.isZero(0) ? infinity : w * (impulse + p.x() * push).norm();
  };
  return {miss(slide, sliding(p, p_m.x() / lever)), miss(roll, Vector2(p_m.tail<2>() / lever))};
}

}  // namespace perp
