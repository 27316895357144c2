#include "perp/model/gap.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

Pose moved(const Pose& X, const Twist& V, double s) { return {X.p + s * V.v, rotation(s * V.w) * X.q}; }

bool finite(const ContactPoint& c) {
  return std::isfinite(c.gap) && c.normal.allFinite() && c.point.allFinite() && std::isfinite(c.gap_t);
}

/// Unit twist k of the twelve (v, w) of A, then of B.
void unit_twist(int k, Twist& V_A, Twist& V_B) {
  Twist& V = k < 6 ? V_A : V_B;
  (k % 6 < 3 ? V.v : V.w)[k % 3] = 1;
}

}  // namespace

Gap Gap::patch(int points, Patch evaluate) {
  if (points < 1) refuse("Gap::patch", "points", points, "needs to be 1 at least");
  if (!evaluate) refuse("Gap::patch", "evaluate", "empty", "needs a function");
  return {points, std::move(evaluate)};
}

/// (8 (f(s) - f(-s)) - (f(2s) - f(-2s)))/(12 s), s a thousandth of the distance between point and body: truncation and
/// rounding both come to about 1e-13 of the derivative for a smooth gap.
void Gap::differences(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactDerivative> out) const {
  constexpr double fraction = 1e-3, weight[] = {8, -1};
  const std::size_t n = out.size();
  std::vector<ContactPoint> here(n), before(n), after(n);
  (*this)(X_WA, X_WB, t, here);
  double length = 1;
  for (const ContactPoint& c : here) {
    if (c.gap == infinity) continue;
    for (const Pose* X : {&X_WA, &X_WB})
      if (const double d = (c.point - X->p).norm(); d > 0) length = std::min(length, d);
  }
  // adds difference quotients of normal and point along one direction, by whatever `poses` moves
  const auto along = [&](double unit, auto&& at, auto&& add) {
    for (int k = 1; k <= 2; ++k) {
      const double s = k * fraction * unit;
      at(-s, before);
      at(s, after);
      for (std::size_t i = 0; i < n; ++i)
        if (here[i].gap != infinity && before[i].gap != infinity && after[i].gap != infinity)
          add(out[i], before[i], after[i], weight[k - 1] / (12 * fraction * unit));
    }
  };
  for (ContactDerivative& d : out) d = {};
  for (int k = 0; k < 12; ++k) {
    Twist V_A, V_B;
    unit_twist(k, V_A, V_B);
    along(
        k % 6 < 3 ? length : 1,
        [&](double s, std::span<ContactPoint> points) {
          (*this)(moved(X_WA, V_A, s), moved(X_WB, V_B, s), t, points);
        },
        [k](ContactDerivative& d, const ContactPoint& a, const ContactPoint& b, double w) {
          d.normal.col(k) += w * (b.normal - a.normal);
          d.point.col(k) += w * (b.point - a.point);
        });
  }
  along(
      1, [&](double s, std::span<ContactPoint> points) { (*this)(X_WA, X_WB, t + s, points); },
      [](ContactDerivative& d, const ContactPoint& a, const ContactPoint& b, double w) {
        d.normal_t += w * (b.normal - a.normal);
        d.point_t += w * (b.point - a.point);
        d.gap_tt += w * (b.gap_t - a.gap_t);
      });
}

Vector3 tangent_wish(const Vector3& normal, const Vector3& wish) {
  if ((wish - normal.dot(wish) * normal).squaredNorm() > 1e-12 * wish.squaredNorm()) return wish;
  return std::abs(normal.x()) > 0.9 ? Vector3::UnitY() : Vector3::UnitX();
}

Matrix3 contact_frame(const Vector3& normal, const Vector3& wish) {
  const Vector3 axis = tangent_wish(normal, wish);
  Matrix3 frame;
  frame.col(0) = normal;
  frame.col(1) = (axis - normal.dot(axis) * normal).normalized();
  frame.col(2) = normal.cross(frame.col(1));
  return frame;
}

GapCheck check_gap(const Gap& gap, const GapCheckOptions& options) {
  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double scale) {
    return Vector3(scale * Vector3::NullaryExpr([&] { return uniform(random); }));
  };
  const auto points = static_cast<std::size_t>(gap.points());
  std::vector<ContactPoint> here(points), before(points), after(points);
  std::vector<ContactDerivative> slopes(points);
  const double step = 1e-6 * options.length;

  GapCheck check;
  const auto take = [](double& error, double e) { error = std::isnan(e) ? infinity : std::max(error, e); };
  for (int sample = 0; sample < options.samples; ++sample) {
    const Pose X_WA = moved(options.X_WA, {vector(options.spread), vector(options.spread)}, 1);
    const Pose X_WB = moved(options.X_WB, {vector(options.spread), vector(options.spread)}, 1);
    const double t = options.t + options.spread * uniform(random);
    const Twist V_A{vector(1), vector(1 / options.length)}, V_B{vector(1), vector(1 / options.length)};
    gap(X_WA, X_WB, t, here);
    for (const ContactPoint& c : here) {
      if (c.gap == infinity) continue;
      check.finite = check.finite && finite(c);
      take(check.normal_length_error, std::abs(c.normal.norm() - 1));
    }

    // along the rates V_A, V_B, and along t alone
    const auto compare = [&](double along_V, double along_t, auto&& judge) {
      const auto at = [&](double s, std::vector<ContactPoint>& out) {
        gap(moved(X_WA, V_A, s * along_V), moved(X_WB, V_B, s * along_V), t + s * along_t, out);
      };
      at(-step, before);
      at(step, after);
      for (std::size_t i = 0; i < points; ++i)
        if (here[i].gap != infinity && before[i].gap != infinity && after[i].gap != infinity) judge(i);
    };
    const auto gap_rate = [&](std::size_t i) { return (after[i].gap - before[i].gap) / (2 * step); };
    compare(1, 0, [&](std::size_t i) {
      const ContactPoint& c = here[i];
      const double rate = c.normal.dot(V_B.at(c.point - X_WB.p) - V_A.at(c.point - X_WA.p));
      take(check.rate_error, std::abs(gap_rate(i) - rate));
    });
    compare(0, 1, [&](std::size_t i) { take(check.time_error, std::abs(gap_rate(i) - here[i].gap_t)); });
    if (!gap.has_derivatives()) continue;
    gap.differentiate(X_WA, X_WB, t, slopes);
    Eigen::Matrix<double, 12, 1> V;
    V << V_A.v, V_A.w, V_B.v, V_B.w;
    compare(1, 1, [&](std::size_t i) {
      const ContactDerivative& d = slopes[i];
      const auto miss = [&](const Vector3& b, const Vector3& a, const Vector3& promised) {
        take(check.derivative_error, ((b - a) / (2 * step) - promised).norm());
      };
      miss(after[i].normal, before[i].normal, d.normal * V + d.normal_t);
      miss(after[i].point, before[i].point, d.point * V + d.point_t);
    });
    compare(0, 1, [&](std::size_t i) {
      take(check.derivative_error,
           std::abs((after[i].gap_t - before[i].gap_t) / (2 * step) - slopes[i].gap_tt));
    });
  }
  check.passed = check.finite && check.normal_length_error <= 1e-12 &&
                 check.rate_error <= options.tolerance && check.time_error <= options.tolerance &&
                 check.derivative_error <= options.tolerance;
  return check;
}

}  // namespace perp
