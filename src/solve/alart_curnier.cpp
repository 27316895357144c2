#include "friction_maps.hpp"

namespace perp {

double AlartCurnierMap::evaluate(const Columns3& r, const Columns3& u) {
  F.resize(3, system.n);
  P.resize(system.n);
  Vector3 p;
  for (int i = 0; i < system.n; ++i) {
    alart_curnier_projection(system.kind[i], system.mu[i], r.col(i) - rho * u.col(i), p, P[i]);
    F.col(i) = r.col(i) - p;
  }
  return F.squaredNorm();
}

void AlartCurnierMap::jacobian(double eps, Blocks3& A, Blocks3& B) const {
  for (int i = 0; i < system.n; ++i) {
    A[i] = Matrix3::Identity() - (1 - rho * eps) * P[i];
    B[i] = rho * P[i];
  }
}

}  // namespace perp
