#include "step/parts/contact_blocks.hpp"

#include <cmath>

#include "core/index.hpp"
#include "solve/blocks/ellipsoid.hpp"

namespace perp {
namespace {

/// Semi-axes of group 1 along t, o and of the torsion over the lever.
Vector3 sliding_axes(const ContactInstant& c, const MomentInstant& m, double lever) {
  return {c.mu, c.tangents == 2 ? m.mu_o : 0, m.torsion / lever};
}

Vector eigen(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

void ContactBlocks::add(BlockKind kind, double mu, double mu_o, double torsion, double rolling) {
  kinds_.push_back(kind);
  mu_.push_back(mu);
  mu_o_.push_back(mu_o);
  torsion_.push_back(torsion);
  rolling_.push_back(rolling);
  ellipses_ = ellipses_ || mu_o != mu;
  torsions_ = torsions_ || torsion > 0;
  rollings_ = rollings_ || rolling > 0;
}

void ContactBlocks::add_interval(int row, double bound) {
  rows.push_back(row);
  add(BlockKind::Interval, bound, bound, 0, 0);
}

void ContactBlocks::add_with_moments(int tangents, double mu, double mu_o, double torsion, double rolling) {
  const BlockKind kind = tangents == 1 ? rolling > 0 ? BlockKind::PlanarRolling : BlockKind::Planar
                         : torsion > 0 ? rolling > 0 ? BlockKind::TorsionalRolling : BlockKind::Torsional
                         : rolling > 0 ? BlockKind::Rolling
                                       : BlockKind::Cone;
  add(kind, mu, tangents == 1 ? mu : mu_o, torsion, rolling);
}

int ContactBlocks::add(const Instant& s, const ContactInstant& c, int row, bool slides, bool rolls) {
  const MomentInstant* m = s.moments_of(c);
  const bool sticks = c.tangents > 0 && !slides;
  const bool twists = m != nullptr && m->torsion > 0 && sticks,
             wheels = m != nullptr && m->rolling > 0 && !rolls;
  const std::size_t before = rows.size();
  rows.push_back(row);
  if (!sticks && !wheels) {
    add(BlockKind::HalfLine, 0, 0, 0, 0);
    return 1;
  }
  for (int t = 1; t <= c.tangents; ++t) rows.push_back(row + t);
  int moment = moment_row(c, row);
  if (twists) rows.push_back(moment);
  if (m != nullptr && m->torsion > 0) ++moment;
  for (int t = 0; wheels && t < c.tangents; ++t) rows.push_back(moment + t);
  const double mu = sticks ? c.mu : 0, mu_o = sticks && m != nullptr ? m->mu_o : mu;
  add_with_moments(c.tangents, mu, mu_o, twists ? m->torsion : 0, wheels ? m->rolling : 0);
  return static_cast<int>(rows.size() - before);
}

void ContactBlocks::give(FrictionProblem& problem) const {
  problem.kinds = kinds_;
  problem.mu = eigen(mu_);
  if (ellipses_) problem.mu_o = eigen(mu_o_);
  if (torsions_) problem.torsion = eigen(torsion_);
  if (rollings_) problem.rolling = eigen(rolling_);
}

Vector3 slip_of(const ContactInstant& c, const MomentInstant* m, const Vector3& u, const Vector3& omega,
                double lever) {
  Vector3 slip = Vector3::Zero();
  for (int t = 1; t <= c.tangents; ++t)
    if (m == nullptr || (t == 1 ? c.mu : m->mu_o) > 0) slip += u[t] * c.frame.col(t);
  if (m != nullptr && m->torsion > 0) slip += lever * omega[0] * c.frame.col(0);
  return slip;
}

Vector3 roll_of(const ContactInstant& c, const MomentInstant* m, const Vector3& omega, double lever) {
  Vector3 roll = Vector3::Zero();
  if (m == nullptr || !(m->rolling > 0)) return roll;
  for (int t = 3 - c.tangents; t <= 2; ++t) roll += lever * omega[t] * c.frame.col(t);
  return roll;
}

FrictionShare friction_share(const ContactInstant& c, const MomentInstant& m, const Vector3& slip,
                             const Vector3& roll, double lever) {
  FrictionShare share;
  const Vector3 d = c.frame.transpose() * slip;  // along n: of the torsion
  const Vector3 push = ellipsoid_support_gradient(sliding_axes(c, m, lever), {d.y(), d.z(), d.x()});
  share.force = -push.head<2>();
  share.moment.x() = -lever * push.z();
  share.moment.tail<2>() = -m.rolling * (c.frame.transpose() * roll).tail<2>();
  return share;
}

double sliding_pull(const ContactInstant& c, const MomentInstant& m, const Vector3& f, const Vector3& moment,
                    double lever) {
  return ellipsoid_gauge(sliding_axes(c, m, lever), {f.y(), f.z(), moment.x() / lever});
}

double rolling_pull(const MomentInstant& m, const Vector3& moment) {
  return m.rolling > 0 ? moment.tail<2>().norm() / m.rolling : 0;
}

Vector3 slip_against(const ContactInstant& c, const MomentInstant* m, const Vector3& f, const Vector3& moment,
                     double lever) {
  Vector3 axes(c.mu, c.mu, 0), against = Vector3::Zero();
  if (m != nullptr) axes = sliding_axes(c, *m, lever);
  const Vector3 p(f.y(), f.z(), moment.x() / lever);
  for (int k = 0; k < 3; ++k)
    if (axes[k] > 0) against -= p[k] / (axes[k] * axes[k]) * c.frame.col((k + 1) % 3);
  return against.normalized();
}

Vector3 roll_against(const ContactInstant& c, const MomentInstant* m, const Vector3& moment) {
  if (m == nullptr || !(m->rolling > 0)) return Vector3::Zero();
  return -(moment.y() * c.frame.col(1) + moment.z() * c.frame.col(2)).normalized();
}

}  // namespace perp
