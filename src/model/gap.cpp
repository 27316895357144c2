#include "perp/model/gap.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "perp/core/errors.hpp"

namespace perp {

Gap Gap::patch(int points, Patch evaluate) {
  if (points < 1) refuse("Gap::patch", "points", points, "needs to be 1 at least");
  if (!evaluate) refuse("Gap::patch", "evaluate", "empty", "needs a function");
  return {points, std::move(evaluate)};
}

Matrix3 contact_frame(const Vector3& normal, const Vector3& wish) {
  Vector3 direction = wish - normal.dot(wish) * normal;
  if (direction.squaredNorm() <= 1e-12 * wish.squaredNorm()) {
    const Vector3 axis = std::abs(normal.x()) > 0.9 ? Vector3::UnitY() : Vector3::UnitX();
    direction = axis - normal.dot(axis) * normal;
  }
  Matrix3 frame;
  frame.col(0) = normal;
  frame.col(1) = direction.normalized();
  frame.col(2) = normal.cross(frame.col(1));
  return frame;
}

namespace {

Pose moved(const Pose& X, const Twist& V, double s) { return {X.p + s * V.v, rotation(s * V.w) * X.q}; }

bool finite(const ContactPoint& c) {
  return std::isfinite(c.gap) && c.normal.allFinite() && c.point.allFinite() && std::isfinite(c.gap_t);
}

}  // namespace

GapCheck check_gap(const Gap& gap, const GapCheckOptions& options) {
  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double scale) {
    return Vector3(scale * Vector3::NullaryExpr([&] { return uniform(random); }));
  };
  const auto points = static_cast<std::size_t>(gap.points());
  std::vector<ContactPoint> here(points), before(points), after(points);
  const double step = 1e-6 * options.length;

  GapCheck check;
  for (int sample = 0; sample < options.samples; ++sample) {
    const Pose X_WA = moved(options.X_WA, {vector(options.spread), vector(options.spread)}, 1);
    const Pose X_WB = moved(options.X_WB, {vector(options.spread), vector(options.spread)}, 1);
    const double t = options.t + options.spread * uniform(random);
    const Twist V_A{vector(1), vector(1 / options.length)}, V_B{vector(1), vector(1 / options.length)};
    gap(X_WA, X_WB, t, here);

    // along the rates V_A, V_B, and along t alone
    const auto compare = [&](const Pose& A0, const Pose& B0, double t0, const Pose& A1, const Pose& B1,
                             double t1, auto&& promised, double& error) {
      gap(A0, B0, t0, before);
      gap(A1, B1, t1, after);
      for (std::size_t i = 0; i < points; ++i) {
        if (here[i].gap == infinity || before[i].gap == infinity || after[i].gap == infinity) continue;
        const double difference = (after[i].gap - before[i].gap) / (2 * step);
        const double e = std::abs(difference - promised(here[i]));
        error = std::isnan(e) ? infinity : std::max(error, e);
      }
    };
    for (const ContactPoint& c : here) {
      if (c.gap == infinity) continue;
      check.finite = check.finite && finite(c);
      check.normal_length_error = std::max(check.normal_length_error, std::abs(c.normal.norm() - 1));
    }
    compare(
        moved(X_WA, V_A, -step), moved(X_WB, V_B, -step), t, moved(X_WA, V_A, step), moved(X_WB, V_B, step),
        t,
        [&](const ContactPoint& c) {
          return c.normal.dot(V_B.at(c.point - X_WB.p) - V_A.at(c.point - X_WA.p));
        },
        check.rate_error);
    compare(
        X_WA, X_WB, t - step, X_WA, X_WB, t + step, [](const ContactPoint& c) { return c.gap_t; },
        check.time_error);
  }
  check.passed = check.finite && check.normal_length_error <= 1e-12 &&
                 check.rate_error <= options.tolerance && check.time_error <= options.tolerance;
  return check;
}

}  // namespace perp
