#include "model/pairs/smooth_distance.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>

#include "perp/model/gap.hpp"

#ifdef PERP_HAS_NLOPT
#include <nlopt.h>
#endif

namespace perp {
namespace {

using Matrix2 = Eigen::Matrix2d;

constexpr double nearest_to_axis = 1e-12;  // of a direction's components, in curvatures [-]

/// ‖(x, y)‖_q, x and y >= 0, with its derivatives.
struct PlaneNorm {
  double value, x, y, xx, xy, yy;

  PlaneNorm(double q, double first, double second) {
    const double largest = std::max(first, second);
    const double p = std::pow(first / largest, q), r = std::pow(second / largest, q);
    value = largest * std::pow(p + r, 1 / q);
    const double u = std::max(first / value, nearest_to_axis), v = std::max(second / value, nearest_to_axis);
    x = first > 0 ? std::pow(first / value, q - 1) : 0;
    y = second > 0 ? std::pow(second / value, q - 1) : 0;
    const double bend = (q - 1) / value;
    xx = bend * std::pow(u, q - 2) * std::pow(v, q);
    xy = -bend * std::pow(u, q - 1) * std::pow(v, q - 1);
    yy = bend * std::pow(v, q - 2) * std::pow(u, q);
  }
};

/// In the solid's own axes.
void support_superquadric(const SmoothSolid& s, const Vector3& m, double& value, Vector3& point, Matrix3& H) {
  const auto dual = [](double e) { return 2 / (2 - e); };
  const Vector3 scaled = s.semi_axes.cwiseProduct(m);
  const double least = nearest_to_axis * scaled.norm();
  const double x = std::abs(scaled.x()), y = std::abs(scaled.y()), z = std::abs(scaled.z());
  const PlaneNorm in(dual(s.exponents.y()), std::max(x, std::hypot(x, y) > 0 ? 0.0 : least), y);
  const PlaneNorm out(dual(s.exponents.x()), in.value, z);
  value = out.value;
  const auto sign = [](double v) { return v < 0 ? -1.0 : 1.0; };
  const Vector3 signs(sign(m.x()), sign(m.y()), sign(m.z())), S = signs.cwiseProduct(s.semi_axes);
  point = S.cwiseProduct(Vector3(out.x * in.x, out.x * in.y, out.y));
  const Vector3 g(in.x, in.y, 0);
  H = out.xx * g * g.transpose();
  H.topLeftCorner<2, 2>() += out.x * (Matrix2() << in.xx, in.xy, in.xy, in.yy).finished();
  H.col(2) += out.xy * g;
  H.row(2) += out.xy * g.transpose();
  H(2, 2) += out.yy;
  H = S.asDiagonal() * H * S.asDiagonal();
}

}  // namespace

SmoothSolid SmoothSolid::ellipsoid(const Vector3& semi_axes, const Pose& X) {
  SmoothSolid s;
  s.R = X.R();
  s.D = s.R * semi_axes.cwiseAbs2().asDiagonal() * s.R.transpose();
  s.centre = X.p;
  s.semi_axes = semi_axes;
  return s;
}

SmoothSolid SmoothSolid::sphere(double radius, const Pose& X) {
  SmoothSolid s;
  s.centre = X.p;
  s.radius = radius;
  return s;
}

SmoothSolid SmoothSolid::make_superquadric(const Vector3& semi_axes, const Vector2& exponents,
                                           const Pose& X) {
  SmoothSolid s;
  s.superquadric = true;
  s.R = X.R();
  s.centre = X.p;
  s.semi_axes = semi_axes;
  s.exponents = exponents;
  return s;
}

double SmoothSolid::extent() const {
  return radius + (superquadric ? semi_axes.norm() : semi_axes.maxCoeff());
}

SmoothSolid SmoothSolid::turned(const Matrix3& R_WB) const {
  SmoothSolid s = *this;
  s.R = R_WB * R;
  s.D = R_WB * D * R_WB.transpose();
  return s;
}

Support::Support(const SmoothSolid& solid, const Vector3& n) {
  if (solid.superquadric) {
    support_superquadric(solid, solid.R.transpose() * n, value, point, H);
    point = solid.R * point;
    H = solid.R * H * solid.R.transpose();
    return;
  }
  const Vector3 Dn = solid.D * n;
  value = std::sqrt(n.dot(Dn));
  if (!(value > 0)) return;
  point = Dn / value;
  H = solid.D / value - Dn * Dn.transpose() / (value * value * value);
}

namespace {

struct Problem {
  const SmoothSolid &a, &b;
  Vector3 d;
  double size;

  double value(const Vector3& n) const { return n.dot(d) - Support(a, n).value - Support(b, n).value; }
  /// P (b - a).
  Vector3 slope(const Vector3& n) const {
    const Vector3 between = d - Support(a, n).point - Support(b, n).point;
    return between - n.dot(between) * n;
  }
  SmoothDistance at(const Vector3& n) const {
    return {.n = n, .value = value(n), .residual = slope(n).norm() / size};
  }
};

/// Newton's direction uphill: where F is not concave along a tangent, as if it were.
Eigen::Vector2d uphill(const Matrix2& K, const Eigen::Vector2d& slope) {
  const Eigen::SelfAdjointEigenSolver<Matrix2> eigen(K);
  const double least = 1e-12 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  const Eigen::Vector2d curvature = eigen.eigenvalues().cwiseAbs().cwiseMax(least);
  return eigen.eigenvectors() * (eigen.eigenvectors().transpose() * slope).cwiseQuotient(curvature);
}

/// The local maximum of F uphill from n. Near it F cannot tell any more which of two directions is better, and the slope has to.
Vector3 climb(const Problem& p, Vector3 n, int most) {
  constexpr double rounding = 4e-16;
  double F = p.value(n), steep = p.slope(n).norm();
  for (int k = 0; k < most && steep > rounding * p.size; ++k) {
    const Support a(p.a, n), b(p.b, n);
    const Eigen::Matrix<double, 3, 2> E = contact_frame(n).rightCols<2>();
    const Eigen::Vector2d slope = E.transpose() * (p.d - a.point - b.point);
    const Matrix2 K = E.transpose() * (a.H + b.H) * E + F * Matrix2::Identity();
    const Vector3 step = E * uphill(K, slope);
    if (!step.allFinite()) break;
    bool better = false;
    for (double part = std::min(1.0, 1.0 / step.norm()); part > 1e-10 && !better; part *= 0.5) {
      const Vector3 tried = (n + part * step).normalized();
      const double there = p.value(tried), steep_there = p.slope(tried).norm();
      better = there > F + rounding * p.size || (there >= F - 4 * rounding * p.size && steep_there < steep);
      if (better) n = tried, F = there, steep = steep_there;
    }
    if (!better) break;
  }
  return n;
}

#ifdef PERP_HAS_NLOPT
double minus_F(unsigned, const double* x, double* gradient, void* data) {
  const Problem& p = *static_cast<const Problem*>(data);
  const Vector3 v(x[0], x[1], x[2]);
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length)) return HUGE_VAL;
  const Vector3 n = v / length;
  if (gradient != nullptr) Eigen::Map<Vector3>{gradient} = -p.slope(n) / (length * p.size);
  return -p.value(n) / p.size;
}

Vector3 by_nlopt(Problem p, const Vector3& from) {
  const nlopt_opt opt = nlopt_create(NLOPT_LD_SLSQP, 3);
  if (opt == nullptr) return from;
  Vector3 x = from;
  double f = 0;
  nlopt_set_min_objective(opt, minus_F, &p);
  nlopt_set_maxeval(opt, 500);
  nlopt_set_xtol_rel(opt, 1e-16);
  (void)nlopt_optimize(opt, x.data(), &f);  // whatever it says: the residual judges where it ended
  nlopt_destroy(opt);
  return x.norm() > 0 && x.allFinite() ? x.normalized() : from;
}
#endif

}  // namespace

SmoothDistance smooth_distance(const SmoothSolid& a, const SmoothSolid& b, const Vector3& d,
                               const SmoothDistanceOptions& options) {
  const Problem p{a, b, d, d.norm() + a.extent() + b.extent()};
  const auto from = [&](const Vector3& n) { return p.at(climb(p, n, options.newton_steps)); };
  SmoothDistance best = from(d.norm() > 0 ? d.normalized() : Vector3(Vector3::UnitZ()));
  const auto look = [&](const SmoothDistance& other) {
    constexpr double rounding = 4e-16;
    const bool further = other.value > best.value + rounding * p.size;
    const bool as_far = other.value >= best.value - rounding * p.size;
    if (further || (as_far && other.residual < best.residual)) best = other;
  };
  if (best.value < 0)
    for (const Matrix3* R : {&a.R, &b.R})
      for (int k = 0; k < 3; ++k)
        for (const double sign : {1.0, -1.0}) look(from(sign * R->col(k)));
#ifdef PERP_HAS_NLOPT
  if (!(best.residual <= options.tolerance)) {
    SmoothDistance further = from(by_nlopt(p, best.n));
    further.by_nlopt = true;
    look(further);
  }
#endif
  return best;
}

}  // namespace perp
