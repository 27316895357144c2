#include <algorithm>
#include <cmath>

#include "solve/friction/friction_maps.hpp"

namespace perp {
namespace {

/// The arrow matrix L_x of the Jordan product, L_x y = x∘y.
template <int R>
Square<R> arrow(const Column<R>& x) {
  Square<R> L = x(0) * Square<R>::Identity();
  L.row(0) = x.transpose();
  L.col(0) = x;
  return L;
}

/// phi(x, y) and its derivatives; where x² + y² is on the cone's boundary its small eigenvalue is lifted.
template <int R>
Column<R> fischer_burmeister(const Column<R>& x, const Column<R>& y, Square<R>& dx, Square<R>& dy) {
  constexpr int tangents = R - 1;
  const double w_0 = x.squaredNorm() + y.squaredNorm();
  const Column<tangents> w_T = 2 * (x(0) * x.template tail<tangents>() + y(0) * y.template tail<tangents>());
  const double size = w_T.norm();
  const double high = std::sqrt(w_0 + size);
  const double low = std::max(std::sqrt(std::max(0.0, w_0 - size)), 1e-12 * high + 1e-150);
  Column<R> root = Column<R>::Zero();
  root(0) = (high + low) / 2;
  if (size > 0) root.template tail<tangents>() = (high - low) / (2 * size) * w_T;
  const Square<R> inverse = arrow(root).inverse();
  dx = Square<R>::Identity() - inverse * arrow(x);
  dy = Square<R>::Identity() - inverse * arrow(y);
  return x + y - root;
}

/// One normal row alone; the others have no reaction.
template <int R>
void half_line(const Column<R>& r, const Column<R>& u, Eigen::Ref<Column<R>> F, Square<R>& dr,
               Square<R>& du) {
  const double a = r(0), b = u(0), root = std::max(std::hypot(a, b), 1e-150);
  F = r;
  F(0) = a + b - root;
  dr.setIdentity();
  dr(0, 0) = 1 - a / root;
  du.setZero();
  du(0, 0) = 1 - b / root;
}

/// The cone over one ellipsoid.
template <int R>
void cone(const Block<R>& block, const Column<R>& r, const Column<R>& u, Eigen::Ref<Column<R>> F,
          Square<R>& dr, Square<R>& du) {
  const Column<R> P = cone_scaling(block);
  const Column<R> u_hat = augmented_velocity(block, u);
  F = fischer_burmeister<R>(P.cwiseProduct(r), u_hat.cwiseQuotient(P), dr, du);
  dr *= P.asDiagonal();
  du *= P.cwiseInverse().asDiagonal();
  const Column<R> slope = slip_gradient(block, u);  // û = u + |diag(axes) u| e_N
  const Column<R> column = du.col(0);
  for (int k = 1; k < R; ++k) {
    if (slope(k) != 0) du.col(k) += slope(k) * column;
    if (block.axes(k) > 0) continue;
    F(k) = r(k);  // a row without a reaction
    dr.row(k).setZero();
    dr(k, k) = 1;
    du.row(k).setZero();
  }
}

}  // namespace

template <int R>
double FischerBurmeisterMap<R>::evaluate(const Columns<R>& r, const Columns<R>& u) {
  F.resize(R, system.n);
  dF_dr.resize(system.n);
  dF_du.resize(system.n);
  for (int i = 0; i < system.n; ++i) {
    const Block<R>& block = system.block[i];
    Square<R>&dr = dF_dr[i], &du = dF_du[i];
    if (!block.contact || block.groups() > 1) {
      Column<R> p;
      Square<R> P;
      alart_curnier_projection<R>(block, r.col(i) - u.col(i), p, P);
      F.col(i) = r.col(i) - p;
      dr = Square<R>::Identity() - P;
      du = P;
    } else if (block.frictionless()) {
      half_line<R>(r.col(i), u.col(i), F.col(i), dr, du);
    } else {
      cone<R>(block, r.col(i), u.col(i), F.col(i), dr, du);
    }
  }
  return F.squaredNorm();
}

template <int R>
void FischerBurmeisterMap<R>::jacobian(double eps, Squares<R>& A, Squares<R>& B) const {
  for (int i = 0; i < system.n; ++i) {
    A[i] = dF_dr[i] + eps * dF_du[i];
    B[i] = dF_du[i];
  }
}

template struct FischerBurmeisterMap<3>;
template struct FischerBurmeisterMap<6>;

}  // namespace perp
