// The second-order cone {x_0 >= |x_T|} of D rows: its Jordan algebra and Nesterov and Todd's scaling.
#pragma once

#include <algorithm>
#include <cmath>

#include "solve/blocks/block.hpp"

namespace perp {

template <int D>
double determinant(const Column<D>& x) {
  const double t = x.template tail<D - 1>().norm();
  return (x(0) - t) * (x(0) + t);
}

/// x∘y = (x.y, x_0 y_T + y_0 x_T).
template <int D>
Column<D> product(const Column<D>& x, const Column<D>& y) {
  Column<D> z;
  z(0) = x.dot(y);
  for (int k = 1; k < D; ++k) z(k) = x(0) * y(k) + y(0) * x(k);
  return z;
}

/// z with λ∘z = c.
template <int D>
Column<D> divide(const Column<D>& lambda, const Column<D>& c) {
  const double det = determinant(lambda);
  const Column<D - 1> l = lambda.template tail<D - 1>();
  Column<D> z;
  z(0) = (lambda(0) * c(0) - l.dot(c.template tail<D - 1>())) / det;
  z.template tail<D - 1>() = (c.template tail<D - 1>() - z(0) * l) / lambda(0);
  return z;
}

/// Largest t with x + t dx in the cone.
template <int D>
double distance_to_boundary(const Column<D>& x, const Column<D>& dx) {
  // (x0 + t dx0)^2 = |x_T + t dx_T|^2 in the metric J; c > 0 inside
  const double c = determinant(x);
  const double b = x(0) * dx(0) - x.template tail<D - 1>().dot(dx.template tail<D - 1>());
  const double a = dx(0) * dx(0) - dx.template tail<D - 1>().squaredNorm();
  double t = infinity;
  const double discriminant = b * b - a * c;
  if (a < 0) {
    t = c / (std::sqrt(std::max(0.0, discriminant)) - b);  // the positive root, (-b - sqrt)/a rewritten
  } else if (b < 0 && discriminant >= 0) {
    t = c / (-b + std::sqrt(discriminant));
  }
  if (dx(0) < 0) t = std::min(t, -x(0) / dx(0));
  return t;
}

/// One cone's scaling: V maps both x and y to λ = V x = V^-1 y; N = V², N x = y.
template <int D>
struct Scaling {
  Square<D> V, V_inverse, N;
  Column<D> lambda;
};

template <int D>
Scaling<D> nesterov_todd(const Column<D>& x, const Column<D>& y) {
  const double det_x = determinant(x), det_y = determinant(y);
  const Column<D> x_bar = x / std::sqrt(det_x), y_bar = y / std::sqrt(det_y);
  const double gamma = std::sqrt((1 + x_bar.dot(y_bar)) / 2);
  Column<D> J = Column<D>::Constant(-1);
  J(0) = 1;
  const Column<D> w = (y_bar + J.cwiseProduct(x_bar)) / (2 * gamma);
  Column<D> v = w;
  v(0) += 1;
  v /= std::sqrt(2 * (w(0) + 1));
  const double beta = std::sqrt(std::sqrt(det_y / det_x));
  Scaling<D> s;
  s.V = 2 * beta * v * v.transpose();
  s.V.diagonal() -= beta * J;
  const Column<D> Jv = J.cwiseProduct(v);
  s.V_inverse = 2 / beta * Jv * Jv.transpose();
  s.V_inverse.diagonal() -= J / beta;
  s.N = 2 * beta * beta * w * w.transpose();
  s.N.diagonal() -= beta * beta * J;
  s.lambda = s.V * x;
  return s;
}

/// The same of the half line, in row 0; the others are left alone.
template <int D>
Scaling<D> half_line_scaling(double x, double y) {
  const double N = y / x, V = std::sqrt(N);
  Scaling<D> s;
  s.N.setIdentity();
  s.V.setIdentity();
  s.V_inverse.setIdentity();
  s.N(0, 0) = N;
  s.V(0, 0) = V;
  s.V_inverse(0, 0) = 1 / V;
  s.lambda.setZero();
  s.lambda(0) = V * x;
  return s;
}

}  // namespace perp
