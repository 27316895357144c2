#include <algorithm>
#include <cmath>

#include "cone.hpp"
#include "friction_stages.hpp"

namespace perp {
namespace {

// The second-order cone {x_0 >= |x_T|} and its Jordan algebra, x∘y = (x.y, x_0 y_T + y_0 x_T).
double determinant(const Vector3& x) {
  const double t = x.tail<2>().norm();
  return (x(0) - t) * (x(0) + t);
}

Vector3 product(const Vector3& x, const Vector3& y) {
  return {x.dot(y), x(0) * y(1) + y(0) * x(1), x(0) * y(2) + y(0) * x(2)};
}

/// z with λ∘z = c.
Vector3 divide(const Vector3& lambda, const Vector3& c) {
  const double det = determinant(lambda);
  const Vector2 l = lambda.tail<2>();
  const double z0 = (lambda(0) * c(0) - l.dot(c.tail<2>())) / det;
  const Vector2 zT = (c.tail<2>() - z0 * l) / lambda(0);
  return {z0, zT(0), zT(1)};
}

/// Largest t with x + t dx in the cone.
double distance_to_boundary(const Vector3& x, const Vector3& dx) {
  // (x0 + t dx0)^2 = |x_T + t dx_T|^2 in the metric J; c > 0 inside
  const double c = determinant(x);
  const double b = x(0) * dx(0) - x.tail<2>().dot(dx.tail<2>());
  const double a = dx(0) * dx(0) - dx.tail<2>().squaredNorm();
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

/// One block's scaling: V λ-maps both x and y to λ = V x = V^-1 y; N = V², N x = y.
struct Scaling {
  Matrix3 V, V_inverse, N;
  Vector3 lambda;
};

Scaling nesterov_todd(const Vector3& x, const Vector3& y) {
  const double det_x = determinant(x), det_y = determinant(y);
  const Vector3 x_bar = x / std::sqrt(det_x), y_bar = y / std::sqrt(det_y);
  const double gamma = std::sqrt((1 + x_bar.dot(y_bar)) / 2);
  const Vector3 w = (y_bar + Vector3(x_bar(0), -x_bar(1), -x_bar(2))) / (2 * gamma);
  const Vector3 v = Vector3(w(0) + 1, w(1), w(2)) / std::sqrt(2 * (w(0) + 1));
  const double beta = std::sqrt(std::sqrt(det_y / det_x));
  const Vector3 J(1, -1, -1);
  Scaling s;
  s.V = 2 * beta * v * v.transpose();
  s.V.diagonal() -= beta * J;
  const Vector3 Jv = J.cwiseProduct(v);
  s.V_inverse = 2 / beta * Jv * Jv.transpose();
  s.V_inverse.diagonal() -= J / beta;
  s.N = 2 * beta * beta * w * w.transpose();
  s.N.diagonal() -= beta * beta * J;
  s.lambda = s.V * x;
  return s;
}

}  // namespace

void interior_point(const ContactSystem& system, const InteriorPointOptions& options, double tolerance,
                    Budget& budget, Iterate& best) {
  const int n = system.n;
  const Vector3 e0(1, 0, 0);
  // x = P r, y = P^-1 û with P = diag(√mu, 1/√mu, 1/√mu): both in the unit cone
  Columns3 P(3, n), x(3, n), y(3, n), Wr(3, n), r(3, n);
  // An interval is a cone block whose x_0 is known to be its bound: row 0 says so, and the De Saxcé term is absent.
  std::vector<char> is_cone(n), is_interval(n);
  for (int i = 0; i < n; ++i) {
    const double mu = system.mu[i];
    is_interval[i] = system.kind[i] == BlockKind::Interval;
    is_cone[i] = system.kind[i] != BlockKind::HalfLine && mu > 0;
    const double root = std::sqrt(mu);
    P.col(i) = is_cone[i] && !is_interval[i] ? Vector3(root, 1 / root, 1 / root) : Vector3(1, 1, 1);
  }
  const double start = options.start * std::max(0.1, system.q.cwiseQuotient(P).cwiseAbs().maxCoeff());
  for (int i = 0; i < n; ++i) x.col(i) = y.col(i) = start * e0;

  std::vector<Scaling> scaling(n);
  Blocks3 A(n), B(n, Matrix3::Identity()), IG(n);
  Columns3 residual(3, n), c(3, n), rhs(3, n), dx(3, n), dy(3, n), dr, W_dr, dx_affine(3, n), dy_affine(3, n);
  Iterate point;
  for (int k = 0; k < options.most && !budget.spent(); ++k) {
    ++budget.iterations;
    r = x.cwiseQuotient(P);
    system.W->apply(r, Wr);
    double kappa = 0;
    for (int i = 0; i < n; ++i) kappa += x.col(i).dot(y.col(i));
    kappa /= n;
    point.r = r;
    for (int i = 0; i < n; ++i)
      if (!is_cone[i]) {
        point.r.col(i).tail<2>().setZero();
        if (is_interval[i]) point.r(0, i) = 0;
      } else if (is_interval[i]) {
        point.r(0, i) = 0;
      }
    evaluate(system, point);
    if (!std::isfinite(point.error)) return;
    if (point.error < best.error) best = point;
    if (kappa < 1e-11 || best.error < tolerance) return;

    // y = P^-1 (W r + q) + |y_T| e0, linearised: (I - G) dy = P^-1 W P^-1 dx + residual
    for (int i = 0; i < n; ++i) {
      residual.col(i) = (Wr.col(i) + system.q.col(i)).cwiseQuotient(P.col(i)) - y.col(i);
      Matrix3& ig = IG[i];
      ig.setIdentity();
      if (is_cone[i]) {
        const double slip = system.associated ? 0 : y.col(i).tail<2>().norm();
        if (is_interval[i]) {
          residual(0, i) = 0;
        } else {
          residual(0, i) += slip;
        }
        if (slip > 0 && !is_interval[i])
          ig.block<1, 2>(0, 1) = -options.damping * y.col(i).tail<2>().transpose() / slip;
        scaling[i] = nesterov_todd(x.col(i), y.col(i));
      } else {
        residual.col(i).tail<2>().setZero();
        Scaling& s = scaling[i];
        const double N = y(0, i) / x(0, i), V = std::sqrt(N);
        s.N = Vector3(N, 1, 1).asDiagonal();
        s.V = Vector3(V, 1, 1).asDiagonal();
        s.V_inverse = Vector3(1 / V, 1, 1).asDiagonal();
        s.lambda = Vector3(V * x(0, i), 0, 0);
      }
      // in r: (P (I-G) N P + W) dr = P ((I-G) V (λ\c) - residual)
      A[i] = P.col(i).asDiagonal() * (ig * scaling[i].N) * P.col(i).asDiagonal();
      if (is_cone[i]) {
        B[i].setIdentity();
      } else {
        B[i] = e0 * e0.transpose();
      }
      if (is_interval[i] && is_cone[i]) {
        A[i].row(0) = e0.transpose();
        B[i].row(0).setZero();
      }
    }
    if (!system.W->factor(A, B)) return;

    const auto direction = [&]() {
      for (int i = 0; i < n; ++i) {
        const Vector3 target =
            is_cone[i] ? divide(scaling[i].lambda, c.col(i)) : Vector3(c(0, i) / scaling[i].lambda(0), 0, 0);
        dy.col(i) = scaling[i].V * target;
        rhs.col(i) = P.col(i).cwiseProduct(IG[i] * dy.col(i) - residual.col(i));
        if (is_interval[i] && is_cone[i]) rhs(0, i) = system.mu[i] - x(0, i);
      }
      if (!system.W->solve(rhs, dr, W_dr)) return false;
      for (int i = 0; i < n; ++i) {
        dx.col(i) = P.col(i).cwiseProduct(dr.col(i));
        dy.col(i) -= scaling[i].N * dx.col(i);
      }
      return true;
    };
    const auto longest_step = [&]() {
      double t = infinity;
      for (int i = 0; i < n; ++i) {
        if (is_cone[i]) {
          t = std::min(
              {t, distance_to_boundary(x.col(i), dx.col(i)), distance_to_boundary(y.col(i), dy.col(i))});
        } else {
          if (dx(0, i) < 0) t = std::min(t, -x(0, i) / dx(0, i));
          if (dy(0, i) < 0) t = std::min(t, -y(0, i) / dy(0, i));
        }
      }
      return t;
    };

    for (int i = 0; i < n; ++i)
      c.col(i) = is_cone[i] ? Vector3(-product(scaling[i].lambda, scaling[i].lambda))
                            : Vector3(-scaling[i].lambda(0) * scaling[i].lambda(0), 0, 0);
    if (!direction()) return;
    const double affine = std::min(1.0, longest_step());
    const double sigma = std::pow(1 - affine, 3);
    dx_affine = dx;
    dy_affine = dy;
    for (int i = 0; i < n; ++i) {
      const Vector3 a = scaling[i].V * dx_affine.col(i), b = scaling[i].V_inverse * dy_affine.col(i);
      if (is_cone[i]) {
        c.col(i) += sigma * kappa * e0 - product(a, b);
      } else {
        c(0, i) += sigma * kappa - a(0) * b(0);
      }
    }
    if (!direction()) return;
    const double t = std::min(1.0, 0.99 * longest_step());
    x += t * dx;
    y += t * dy;
  }
}

}  // namespace perp
