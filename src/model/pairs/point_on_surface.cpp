#include "model/pairs/point_on_surface.hpp"

#include <algorithm>
#include <Eigen/LU>

namespace perp {
namespace {

/// Of the surface's function, or differences of its gradient: central, of fourth order.
Matrix3 hessian(const ImplicitSurface& s, const Vector3& x) {
  if (s.hessian) return s.hessian(x);
  const double h = 1e-3 * s.size;
  Matrix3 H;
  for (int i = 0; i < 3; ++i) {
    const Vector3 e = h * Vector3::Unit(i);
    H.col(i) =
        (8 * (s.gradient(x + e) - s.gradient(x - e)) - (s.gradient(x + 2 * e) - s.gradient(x - 2 * e))) /
        (12 * h);
  }
  return 0.5 * (H + H.transpose());
}

/// Down (or up) to the surface along gradients.
bool descend(const ImplicitSurface& s, Vector3& x) {
  constexpr int most = 50;
  for (int k = 0; k < most; ++k) {
    const Vector3 g = s.gradient(x);
    const double slope = g.squaredNorm(), f = s.f(x);
    if (!(slope > 0) || !std::isfinite(f)) return false;
    Vector3 step = -f / slope * g;
    if (step.norm() > 0.5 * s.size) step *= 0.5 * s.size / step.norm();
    x += step;
    if (step.norm() < 1e-3 * s.size) return true;
  }
  return false;
}

/// Newton on the foot's conditions; false where it does not get there.
bool settle(const ImplicitSurface& s, const Vector3& c, Vector3& x) {
  constexpr int most = 60;
  constexpr double close =
      1e-13;  // of the size: of a foot's distance to the surface and from the normal through c
  const auto miss = [&](const Vector3& y) {
    const Vector3 g = s.gradient(y), d = c - y;
    return std::abs(s.f(y)) / g.norm() + (d - g * (g.dot(d) / g.squaredNorm())).norm();
  };
  double error = miss(x);
  for (int k = 0; k < most && error > 0.01 * close * s.size; ++k) {
    const Vector3 g = s.gradient(x), d = c - x;
    const double lambda = g.dot(d) / g.squaredNorm();
    Eigen::Matrix4d K = Eigen::Matrix4d::Zero();
    K.topLeftCorner<3, 3>() = Matrix3::Identity() + lambda * hessian(s, x);
    K.topRightCorner<3, 1>() = g;
    K.bottomLeftCorner<1, 3>() = g.transpose();
    Eigen::Vector4d r;
    r << d - lambda * g, -s.f(x);
    const Vector3 step = K.partialPivLu().solve(r).head<3>();
    if (!step.allFinite()) return false;
    bool better = false;
    for (double part = std::min(1.0, 0.5 * s.size / step.norm()); part > 1e-6 && !better; part *= 0.5)
      if (const double there = miss(x + part * step); there < error)
        x += part * step, error = there, better = true;
    if (!better) break;
  }
  return error <= close * (s.size + (c - x).norm());
}

Foot foot_at(const ImplicitSurface& s, const Vector3& c, const Vector3& x) {
  const Vector3 n = s.gradient(x).normalized();
  return {x, n, n.dot(c - x)};
}

/// How the surface bends at a foot: S = P H P/|∇f|, by which dn = S dx.
Matrix3 shape_operator(const ImplicitSurface& s, const Foot& foot) {
  const Matrix3 P = Matrix3::Identity() - foot.n * foot.n.transpose();
  return P * hessian(s, foot.x) * P / s.gradient(foot.x).norm();
}

/// Whether it is nearest among its neighbours: 1 + distance S is positive on the tangent plane.
bool is_nearest(const ImplicitSurface& s, const Foot& foot) {
  const Eigen::Matrix<double, 3, 2> E = contact_frame(foot.n).rightCols<2>();
  const Eigen::Matrix2d K =
      Eigen::Matrix2d::Identity() + foot.distance * E.transpose() * shape_operator(s, foot) * E;
  return K.trace() > 0 && K.determinant() > 0;
}

}  // namespace

int feet(const ImplicitSurface& surface, const Vector3& c, std::array<Foot, 2>& found) {
  const double same = 1e-6 * surface.size;
  int count = 0;
  const auto look = [&](Vector3 x) {
    if (!descend(surface, x) || !settle(surface, c, x)) return;
    const Foot foot = foot_at(surface, c, x);
    if (!is_nearest(surface, foot)) return;
    for (int i = 0; i < count; ++i)
      if ((found[static_cast<std::size_t>(i)].x - x).norm() < same) return;
    const auto nearer = [](const Foot& p, const Foot& q) {
      return std::abs(p.distance) < std::abs(q.distance);
    };
    if (count < 2)
      found[static_cast<std::size_t>(count++)] = foot;
    else if (nearer(foot, found[1]))
      found[1] = foot;
    if (count == 2 && nearer(found[1], found[0])) std::swap(found[0], found[1]);
  };
  look(c);
  const double around = count > 0 ? std::abs(found[0].distance) + 1e-3 * surface.size : 0.25 * surface.size;
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0}) look(c + sign * around * Vector3::Unit(i));
  if (count == 2 && std::abs(found[1].distance) > 1.5 * std::abs(found[0].distance) + same) count = 1;
  const Vector3 order(1, 1.41, 1.73);  // any direction that scenes do not use
  if (count == 2 && order.dot(found[1].x) < order.dot(found[0].x)) std::swap(found[0], found[1]);
  return count;
}

void PointOnSurface::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const Pose X_WS = X_WA * X_AS_;
  const Vector3 c = X_WB * centre_;
  std::array<Foot, 2> all;
  const int count = feet(surface_, X_WS.inverse() * c, all);
  out[0] = out[1] = {};
  if (count == 0) out[0].gap = not_set;
  for (int i = 0; i < count; ++i) {
    const Foot& foot = all[static_cast<std::size_t>(i)];
    out[static_cast<std::size_t>(i)] =
        Witness{X_WS.q * foot.n, X_WS * foot.x, c, foot.distance}.contact(0, radius_);
  }
}

/// The foot slides over the surface as the point moves past it: dx = (P + distance S)⁻¹ P dc on the tangent plane, in A's axes.
void PointOnSurface::differentiate(const Pose& X_WA, const Pose& X_WB,
                                   std::span<ContactDerivative> out) const {
  const Pose X_WS = X_WA * X_AS_;
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Moving c = B.point(X_WB * centre_);
  std::array<Foot, 2> all;
  const int count = feet(surface_, X_WS.inverse() * c.x, all);
  const Matrix3 R = X_WS.R();
  for (int i = 0; i < count; ++i) {
    const Foot& foot = all[static_cast<std::size_t>(i)];
    const Vector3 n = R * foot.n, x = X_WS * foot.x;
    const Eigen::Matrix<double, 3, 2> E = contact_frame(n).rightCols<2>();
    const Matrix3 S = R * shape_operator(surface_, foot) * R.transpose();
    const Eigen::Matrix2d K = Eigen::Matrix2d::Identity() + foot.distance * E.transpose() * S * E;
    const Columns past = c.d - A.point(c.x).d;  // of the point, to one fixed in A
    const Columns slides = E * K.inverse() * (E.transpose() * past);
    const Moving normal{n, A.direction(n).d + S * slides}, a{x, A.point(x).d + slides};
    MovingWitness{normal, a, c}.contact(0, radius_, out[static_cast<std::size_t>(i)]);
  }
}

}  // namespace perp
