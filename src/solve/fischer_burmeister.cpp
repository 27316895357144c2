#include <algorithm>
#include <cmath>

#include "friction_maps.hpp"

namespace perp {
namespace {

/// The arrow matrix L_x of the Jordan product, L_x y = x∘y.
Matrix3 arrow(const Vector3& x) {
  Matrix3 L = x(0) * Matrix3::Identity();
  L.row(0) = x.transpose();
  L.col(0) = x;
  return L;
}

/// phi(x, y) and its derivatives; where x² + y² is on the cone's boundary its small eigenvalue is lifted.
Vector3 fischer_burmeister(const Vector3& x, const Vector3& y, Matrix3& dx, Matrix3& dy) {
  const double w_0 = x.squaredNorm() + y.squaredNorm();
  const Vector2 w_T = 2 * (x(0) * x.tail<2>() + y(0) * y.tail<2>());
  const double size = w_T.norm();
  const double high = std::sqrt(w_0 + size);
  const double low = std::max(std::sqrt(std::max(0.0, w_0 - size)), 1e-12 * high + 1e-150);
  Vector3 root((high + low) / 2, 0, 0);
  if (size > 0) root.tail<2>() = (high - low) / (2 * size) * w_T;
  const Matrix3 inverse = arrow(root).inverse();
  dx = Matrix3::Identity() - inverse * arrow(x);
  dy = Matrix3::Identity() - inverse * arrow(y);
  return x + y - root;
}

}  // namespace

double FischerBurmeisterMap::evaluate(const Columns3& r, const Columns3& u) {
  F.resize(3, system.n);
  dF_dr.resize(system.n);
  dF_du.resize(system.n);
  for (int i = 0; i < system.n; ++i) {
    const BlockKind kind = system.kind[i];
    const double mu = system.mu[i];
    Matrix3 &dr = dF_dr[i], &du = dF_du[i];
    if (kind == BlockKind::Interval) {
      Vector3 p;
      Matrix3 P;
      alart_curnier_projection(kind, mu, r.col(i) - u.col(i), p, P);
      F.col(i) = r.col(i) - p;
      dr = Matrix3::Identity() - P;
      du = P;
      continue;
    }
    if (kind == BlockKind::HalfLine || mu == 0) {
      const double a = r(0, i), b = u(0, i), root = std::max(std::hypot(a, b), 1e-150);
      F.col(i) = Vector3(a + b - root, r(1, i), r(2, i));
      dr = Vector3(1 - a / root, 1, 1).asDiagonal();
      du = Vector3(1 - b / root, 0, 0).asDiagonal();
      continue;
    }
    const Vector3 P(std::sqrt(mu), 1 / std::sqrt(mu), 1 / std::sqrt(mu));
    const Vector3 u_hat = augmented_velocity(kind, mu, u.col(i));
    F.col(i) = fischer_burmeister(P.cwiseProduct(r.col(i)), u_hat.cwiseQuotient(P), dr, du);
    dr *= P.asDiagonal();
    du *= P.cwiseInverse().asDiagonal();
    const double slip = u.col(i).tail<2>().norm();  // û = u + mu |u_T| e_N
    if (slip > 0) {
      const Vector3 column = du.col(0);
      du.col(1) += mu * u(1, i) / slip * column;
      du.col(2) += mu * u(2, i) / slip * column;
    }
    if (kind == BlockKind::Planar) {
      F(2, i) = r(2, i);
      dr.row(2) = Vector3(0, 0, 1).transpose();
      du.row(2).setZero();
    }
  }
  return F.squaredNorm();
}

void FischerBurmeisterMap::jacobian(double eps, Blocks3& A, Blocks3& B) const {
  for (int i = 0; i < system.n; ++i) {
    A[i] = dF_dr[i] + eps * dF_du[i];
    B[i] = dF_du[i];
  }
}

}  // namespace perp
