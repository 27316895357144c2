#include "cone.hpp"

#include <algorithm>
#include <cmath>

namespace perp {

Vector3 project_block(BlockKind kind, double mu, const Vector3& z) {
  switch (kind) {
    case BlockKind::HalfLine:
      return {std::max(0.0, z(0)), 0, 0};
    case BlockKind::Interval:
      return {0, std::clamp(z(1), -mu, mu), 0};
    case BlockKind::Planar:
    case BlockKind::Cone:
      break;
  }
  const double tangential = z.tail<2>().norm();
  if (tangential <= mu * z(0)) return z;
  if (mu * tangential <= -z(0)) return Vector3::Zero();
  const double normal = (z(0) + mu * tangential) / (1 + mu * mu);  // foot on the cone's side
  const double ratio = mu * normal / tangential;
  return {normal, ratio * z(1), ratio * z(2)};
}

void alart_curnier_projection(BlockKind kind, double mu, const Vector3& z, Vector3& p, Matrix3& P) {
  p.setZero();
  P.setZero();
  if (kind == BlockKind::Interval) {
    p(1) = std::clamp(z(1), -mu, mu);
    P(1, 1) = std::abs(z(1)) < mu ? 1 : 0;
    return;
  }
  if (z(0) <= 0) return;
  p(0) = z(0);
  P(0, 0) = 1;
  if (kind == BlockKind::HalfLine) return;
  const double tangential = z.tail<2>().norm();
  const double radius = mu * z(0);
  const bool planar = kind == BlockKind::Planar;
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

double natural_map(const ContactSystem& system, const Columns3& r, const Columns3& u) {
  double sum = 0;
  for (int i = 0; i < system.n; ++i) {
    const double slip_factor = system.associated ? 0 : system.mu[i];
    const Vector3 u_hat = augmented_velocity(system.kind[i], slip_factor, u.col(i));
    sum += (r.col(i) - project_block(system.kind[i], system.mu[i], r.col(i) - u_hat)).squaredNorm();
  }
  return std::sqrt(sum);
}

}  // namespace perp
