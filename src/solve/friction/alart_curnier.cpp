#include "solve/friction/friction_maps.hpp"

namespace perp {

template <int R>
double AlartCurnierMap<R>::evaluate(const Columns<R>& r, const Columns<R>& u) {
  F.resize(R, system.n);
  P.resize(system.n);
  Column<R> p;
  for (int i = 0; i < system.n; ++i) {
    alart_curnier_projection<R>(system.block[i], r.col(i) - rho * u.col(i), p, P[i]);
    F.col(i) = r.col(i) - p;
  }
  return F.squaredNorm();
}

template <int R>
void AlartCurnierMap<R>::jacobian(double eps, Squares<R>& A, Squares<R>& B) const {
  for (int i = 0; i < system.n; ++i) {
    A[i] = Square<R>::Identity() - (1 - rho * eps) * P[i];
    B[i] = rho * P[i];
  }
}

template struct AlartCurnierMap<3>;
template struct AlartCurnierMap<6>;

}  // namespace perp
