#include "step/parts/moment_laws.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/instant/friction_polygon.hpp"
#include "solve/blocks/ellipsoid.hpp"
#include "step/certificate/closeness.hpp"
#include "step/implicit/nonsmooth_newton.hpp"

namespace perp {

SemiAxes semi_axes_of(const Reaction& contact, const Reaction& moments) {
  const bool t = contact.law == Law::Planar || contact.law == Law::Cone, o = contact.law == Law::Cone;
  return {{t ? contact.mu : 0, o ? moments.mu_o : 0, moments.torsion / moments.lever},
          moments.rolling / moments.lever};
}

void project_with_moments(const SemiAxes& axes, const Vector6& z, Vector6& p, Matrix6& P) {
  p.setZero();
  P.setZero();
  if (z[0] <= 0) return;
  p[0] = z[0];
  P(0, 0) = 1;
  const Vector3 sliding = z.segment<3>(1), rolling(z[4], z[5], 0), disc(axes.rolling, axes.rolling, 0);
  const EllipsoidProjection slid = project_on_ellipsoid(axes.sliding, z[0], sliding),
                            rolled = project_on_ellipsoid(disc, z[0], rolling);
  const EllipsoidSlope by_sliding = differentiate(slid, axes.sliding, z[0], sliding),
                       by_rolling = differentiate(rolled, disc, z[0], rolling);
  p.segment<3>(1) = slid.p;
  P.block<3, 3>(1, 1) = by_sliding.dz;
  P.block<3, 1>(1, 0) = by_sliding.ds;
  p.tail<2>() = rolled.p.head<2>();
  P.block<2, 2>(4, 4) = by_rolling.dz.topLeftCorner<2, 2>();
  P.block<2, 1>(4, 0) = by_rolling.ds.head<2>();
}

namespace {

bool moves_on_bound(const Vector3& a, const Vector3& p, const Vector3& u, double p_n, double speed) {
  Vector3 moving = u;
  for (int i = 0; i < 3; ++i)
    if (!(a[i] > 0)) moving[i] = 0;
  return !closeness::sticks(moving.norm(), speed) &&
         closeness::on_bound(ellipsoid_gauge(a, p), std::max(p_n, 0.0));
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
                    why = "is not known to " + std::string(method) +
                          ": ncp, ncp-start, ncp2, event and extrapolated know it";
  if (contact->torsion > 0) refuse(where, "torsion", contact->torsion, why);
  if (contact->rolling > 0) refuse(where, "rolling", contact->rolling, why);
  refuse(where, "friction_axes", "given", why);
}

std::array<double, 2> MomentLaw::residuals(const Vector3& u, const Vector3& omega) const {
  const double bound = std::max(p.x(), 0.0), roll = m.rolling / lever;
  const auto miss = [&](const Vector3& axes, const Vector3& impulse, const Vector3& velocity) {
    return w * (impulse - project_on_ellipsoid(axes, bound, impulse - velocity / w).p).norm();
  };
  return {miss(sliding_axes(), sliding(p, p_m.x() / lever), sliding(u, omega.x() * lever)),
          miss({roll, roll, 0}, {p_m.y() / lever, p_m.z() / lever, 0},
               {omega.y() * lever, omega.z() * lever, 0})};
}

std::array<double, 2> MomentLaw::residuals(const Vector3& u, const Vector3& omega, int edges) const {
  if (c.tangents < 2) return residuals(u, omega);
  const double bound = std::max(p.x(), 0.0), roll = m.rolling / lever;
  const auto miss = [&](const Vector3& axes, const Vector3& impulse, const Vector3& velocity, auto gauge,
                        auto support) {
    const double largest = axes.maxCoeff();
    Vector3 over = Vector3::Zero();  // the impulse in semi-axes
    double aside = 0;                // and what is along none
    for (int k = 0; k < 3; ++k) {
      if (axes[k] > 0)
        over[k] = impulse[k] / axes[k];
      else
        aside = std::max(aside, std::abs(impulse[k]));
    }
    const double outside = w * std::max(aside, largest * std::max(0.0, gauge(over) - bound));
    if (!(largest > 0) || bound == 0) return outside;
    // work that another impulse would take beyond this one's, over p_n; no more than what changing it would change
    const double missed = support(Vector3(-axes.cwiseProduct(velocity))) + impulse.dot(velocity) / bound;
    return std::max(outside, std::min(std::abs(missed) / largest, 2 * w * bound * largest));
  };
  const auto flat = [&](const Vector3& x) -> Vector2 { return x.head<2>(); };
  return {
      miss(
          sliding_axes(), sliding(p, p_m.x() / lever), sliding(u, omega.x() * lever),
          [&](const Vector3& x) { return polytope_gauge(edges, x); },
          [&](const Vector3& y) { return polytope_support(edges, y); }),
      miss(
          {roll, roll, 0}, {p_m.y() / lever, p_m.z() / lever, 0}, {omega.y() * lever, omega.z() * lever, 0},
          [&](const Vector3& x) { return polygon_gauge(edges, flat(x)); },
          [&](const Vector3& y) { return polygon_support(edges, flat(y)); })};
}

std::array<double, 2> MomentLaw::tied(const Vector3& u, const Vector3& omega) const {
  const SemiAxes axes{sliding_axes(), m.rolling / lever};
  const Vector3 slide = ellipsoid_support_gradient(axes.sliding, sliding(u, omega.x() * lever));
  const Vector2 roll = rolling_friction(axes.rolling, omega.tail<2>());
  const auto miss = [&](const auto& push, const auto& impulse) {
    return push.isZero(0) ? infinity : w * (impulse + p.x() * push).norm();
  };
  return {miss(slide, sliding(p, p_m.x() / lever)), miss(roll, Vector2(p_m.tail<2>() / lever))};
}

}  // namespace perp
