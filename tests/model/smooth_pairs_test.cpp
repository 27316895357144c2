// Smooth convex solids and surfaces of formulas, against the conditions that nearest points satisfy.
#include <catch2/catch.hpp>
#include <cmath>

#include "model/pairs/smooth_distance.hpp"
#include "perp/model/shape.hpp"
#include "tests/model/random_poses.hpp"

using namespace perp;

namespace {

using Real = long double;
using RealVector = Eigen::Matrix<Real, 3, 1>;

/// Of ellipsoids, aspect to 20.
Vector3 semi_axes(Random& random) {
  const auto one = [&] { return std::exp(random(-std::log(20.0), 0)); };
  return {one(), one(), one()};
}

/// s and the point that supports along n, of an ellipsoid, in extended precision from semi-axes and rotation.
Real support(const Vector3& semi_axes, const Matrix3& R, const RealVector& n, RealVector& point) {
  const Eigen::Matrix<Real, 3, 3> Q = R.cast<Real>();
  const RealVector m = Q.transpose() * n, D = semi_axes.cast<Real>().cwiseAbs2();
  const Real s = std::sqrt(m.dot(D.cwiseProduct(m)));
  point = Q * RealVector(D.cwiseProduct(m) / s);
  return s;
}

struct Tally {
  double worst = 0;
  int nlopt = 0, apart = 0, overlapping = 0;
};

/// Pairs of ellipsoids, two thirds apart and the rest overlapping: F and its slope in extended precision at the direction found, and no
/// direction of `tries` better.
Tally try_ellipsoids(int count, int tries) {
  Random random(11);
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const Vector3 axes_a = semi_axes(random), axes_b = semi_axes(random);
    const Matrix3 A = random.turn().toRotationMatrix(), B = random.turn().toRotationMatrix();
    const SmoothSolid a = SmoothSolid::ellipsoid(axes_a, {Vector3::Zero(), Quaternion(A)}),
                      b = SmoothSolid::ellipsoid(axes_b, {Vector3::Zero(), Quaternion(B)});
    const Vector3 away = random.direction();
    const double both = Support(a, away).value + Support(b, away).value;
    const double reach = i % 3 == 0 ? random(0.4, 1) : 1 + std::pow(10, random(-9, 1));
    const Vector3 d = reach * both * away;
    const SmoothDistance found = smooth_distance(a, b, d);
    tally.nlopt += found.by_nlopt ? 1 : 0;
    (found.value > 0 ? tally.apart : tally.overlapping) += 1;

    const RealVector n = found.n.cast<Real>().normalized();
    RealVector on_a, on_b;
    const Real F = n.dot(d.cast<Real>()) - support(axes_a, A, n, on_a) - support(axes_b, B, n, on_b);
    const RealVector between = d.cast<Real>() - on_a - on_b;
    const double size = d.norm() + axes_a.maxCoeff() + axes_b.maxCoeff();
    const Real slope = (between - n.dot(between) * n).norm();
    const double error = static_cast<double>(std::max(slope, std::abs(F - Real(found.value)))) / size;
    tally.worst = std::isnan(error) ? infinity : std::max(tally.worst, error);
    for (int k = 0; k < tries; ++k) {
      const RealVector m = random.direction().cast<Real>();
      RealVector nowhere;
      const Real other =
          m.dot(d.cast<Real>()) - support(axes_a, A, m, nowhere) - support(axes_b, B, m, nowhere);
      if (other > F) tally.worst = std::max(tally.worst, static_cast<double>(other - F) / size);
    }
  }
  return tally;
}

}  // namespace

TEST_CASE("the distance of two ellipsoids is the largest over all directions, to rounding", "[smooth]") {
  const Tally tally = try_ellipsoids(2000, 100);
  CAPTURE(tally.nlopt);
  CHECK(tally.worst < 1e-12);
  CHECK(tally.apart > 1000);
  CHECK(tally.overlapping > 400);
}

TEST_CASE("distances of a hundred thousand pairs of ellipsoids", "[smooth][slow]") {
  const Tally tally = try_ellipsoids(100000, 10);
  WARN("NLopt went on for " << tally.nlopt << " of 100000 pairs, worst " << tally.worst);
  CHECK(tally.worst < 1e-12);
}

#ifdef PERP_HAS_NLOPT
TEST_CASE("where Newton's steps do not suffice, NLopt finds the direction", "[smooth]") {
  Random random(11);
  for (int i = 0; i < 50; ++i) {
    const SmoothSolid a = SmoothSolid::ellipsoid(semi_axes(random), {Vector3::Zero(), random.turn()}),
                      b = SmoothSolid::ellipsoid(semi_axes(random), {Vector3::Zero(), random.turn()});
    const Vector3 d = 2.5 * random.direction();
    const SmoothDistance newton = smooth_distance(a, b, d),
                         other = smooth_distance(a, b, d, {.newton_steps = 0});
    CHECK(!newton.by_nlopt);
    CHECK(other.by_nlopt);
    CHECK(newton.residual < 1e-13);
    CHECK(other.residual < 1e-5);
    CHECK(other.value == Approx(newton.value).epsilon(1e-9));
  }
}
#endif

TEST_CASE("a superquadric is supported by the points of its surface", "[smooth]") {
  Random random(11);
  for (int i = 0; i < 40; ++i) {
    const Vector3 a = semi_axes(random);
    const Vector2 e(random(0.2, 1.8), random(0.2, 1.8));
    const Shape shape = Shape::superquadric(a, e);
    const auto inside = [&](const Vector3& x) {
      const Vector3 u = x.cwiseQuotient(a).cwiseAbs();
      return std::pow(std::pow(u.x(), 2 / e.y()) + std::pow(u.y(), 2 / e.y()), e.y() / e.x()) +
             std::pow(u.z(), 2 / e.x());
    };
    const Vector3 n = random.direction(), top = shape.support(n);
    CHECK(inside(top) == Approx(1).epsilon(1e-9));
    for (int k = 0; k < 200; ++k) {
      const Vector3 x = random.direction().cwiseProduct(a);
      const Vector3 on = x / std::pow(inside(x), e.x() / 2);
      REQUIRE(inside(on) == Approx(1).epsilon(1e-9));
      CHECK(n.dot(on) <= n.dot(top) + 1e-12);
    }
    const SmoothSolid solid = SmoothSolid::make_superquadric(a, e, {});
    const Support s(solid, n);
    CHECK((s.point - top).norm() < 1e-10);
    CHECK(s.value == Approx(n.dot(top)).epsilon(1e-12));
    for (int k = 0; k < 3; ++k) {
      const Vector3 step = 1e-6 * Vector3::Unit(k);
      const Vector3 slope = (Support(solid, n + step).point - Support(solid, n - step).point) / 2e-6;
      CHECK((slope - s.H.col(k)).norm() < 1e-5 * (1 + s.H.norm()));
    }
  }
}

TEST_CASE("superquadrics meet spheres, ellipsoids, each other and planes at their nearest points",
          "[smooth]") {
  Random random(11);
  int apart = 0;
  for (int i = 0; i < 200; ++i) {
    const Shape shapes[] = {Shape::superquadric({1, 0.7, 0.5}, {random(0.5, 1.5), random(0.5, 1.5)}),
                            Shape::superquadric({0.6, 0.5, 0.8}, {random(0.5, 1.5), random(0.5, 1.5)}),
                            Shape::ellipsoid({0.3, 0.6, 0.4}), Shape::sphere(0.4)};
    const Shape &a = shapes[0], &b = shapes[1 + i % 3];
    const Gap gap = gap_between(a, b), back = gap_between(b, a);
    const Pose A{random.direction(), random.turn()},
        B{A.p + random(1.2, 3) * random.direction(), random.turn()};
    const ContactPoint c = points(gap, A, B)[0], d = points(back, B, A)[0];
    CHECK(c.gap == Approx(d.gap).margin(1e-10));
    if (!(c.gap > 1e-6)) continue;
    ++apart;
    const Vector3 top = A * a.support(A.q.conjugate() * c.normal),
                  bottom = B * b.support(B.q.conjugate() * -c.normal);
    CHECK(c.normal.dot(bottom - top) == Approx(c.gap).margin(1e-11));  // planes across the normal part them
    const Vector3 on_a = c.point - 0.5 * c.gap * c.normal, on_b = c.point + 0.5 * c.gap * c.normal;
    CHECK((on_a - top).norm() < 1e-7);  // and touch each where the distance is measured
    CHECK((on_b - bottom).norm() < 1e-7);
    if (i % 10 == 0) CHECK(check_gap(gap, about(A, B, 0.01)).rate_error < 1e-6);
  }
  CHECK(apart > 100);
  const Gap floor = gap_between(Shape::half_space(), Shape::superquadric({1, 0.7, 0.5}, {0.8, 1.3}));
  CHECK(check_gap(floor, about({}, {{0, 0, 2}, rotation({0.4, 0.3, 0.2})}, 0.01)).passed);
  CHECK(points(floor, {}, {{0, 0, 2}, rotation({0, M_PI / 2, 0})})[0].gap == Approx(1));
}

TEST_CASE("a ball meets a surface of a formula where two solids' nearest points are", "[smooth]") {
  // an ellipsoid by its equation, against the ellipsoid itself
  const Vector3 a(0.5, 0.3, 0.4);
  const Vector3 D = a.cwiseAbs2().cwiseInverse();
  const ImplicitSurface surface{
      .f = [=](const Vector3& x) { return x.dot(D.cwiseProduct(x)) - 1; },
      .gradient = [=](const Vector3& x) -> Vector3 { return 2 * D.cwiseProduct(x); },
      .hessian = {},
      .size = 0.5};
  const Shape ball = Shape::sphere(0.1);
  const Pose place{{0.1, 0.2, 0}, rotation({0.3, 0, 0})};
  const Gap formula = gap_between(Shape::formula(surface), ball, place),
            exact = gap_between(Shape::ellipsoid(a), ball, place);
  Random random(11);
  double worst = 0;
  for (int i = 0; i < 300; ++i) {
    const Pose A{random.direction(), random.turn()};
    const Pose B{A * Vector3(place * (random(0.62, 3) * random.direction())), random.turn()};
    const ContactPoint right = points(exact, A, B)[0];
    double nearest = infinity;
    for (const ContactPoint& c : points(formula, A, B))
      if (std::abs(c.gap - right.gap) < nearest)
        nearest = std::abs(c.gap - right.gap) + (c.normal - right.normal).norm();
    worst = std::max(worst, nearest);
    if (i % 30 == 0) CHECK(check_gap(formula, about(A, B, 0.01)).derivative_error < 1e-5);
  }
  CHECK(worst < 1e-10 * 0.5 * 10);  // in m, and rad of the normal
}

TEST_CASE("a ball in a groove has two contacts, and one over a crest", "[smooth]") {
  const ImplicitSurface groove{
      .f = [](const Vector3& x) { return x.z() - 4 * x.x() * x.x() * (1 - x.x() * x.x()); },
      .gradient = [](const Vector3& x) { return Vector3(-8 * x.x() + 16 * x.x() * x.x() * x.x(), 0, 1); },
      .hessian = {},
      .size = 0.3};
  const Gap gap = gap_between(Shape::formula(groove), Shape::sphere(0.25));
  const std::vector<ContactPoint> within = points(gap, {}, {{0, 0, 0.3}, Quaternion::Identity()});
  REQUIRE(within[1].gap < infinity);
  CHECK(within[0].gap == Approx(within[1].gap));
  CHECK(within[0].normal.x() == Approx(-within[1].normal.x()));
  CHECK(within[0].point.x() < within[1].point.x());
  const Vector3 crest(std::sqrt(0.5), 0, 1.5);
  const std::vector<ContactPoint> over = points(gap, {}, {crest, Quaternion::Identity()});
  CHECK(over[0].gap == Approx(0.25));
  CHECK(over[1].gap == infinity);
}

TEST_CASE("planar ellipses meet lines, discs and each other in their plane", "[smooth]") {
  const Shape ellipse = Shape::ellipse(0.5, 0.2), disc = Shape::planar_disc(0.3);
  CHECK(points(gap_between(Shape::line(), ellipse), {}, {{0, 1, 0}, rotation({0, 0, 0.5})})[0].gap ==
        Approx(1 - std::hypot(0.5 * std::sin(0.5), 0.2 * std::cos(0.5))));
  Random random(11);
  for (int i = 0; i < 60; ++i) {
    const Shape& other = i % 2 == 0 ? disc : ellipse;
    const Gap gap = gap_between(ellipse, other);
    const double angle = random(0, 6);
    const Pose A{{0.1, 0.2, 0}, rotation({0, 0, random(0, 6)})};
    const Pose B{A.p + random(0.1, 1.5) * Vector3(std::cos(angle), std::sin(angle), 0),
                 rotation({0, 0, random(0, 6)})};
    const ContactPoint c = points(gap, A, B)[0];
    CHECK(std::abs(c.normal.z()) < 1e-12);
    double best = -infinity;  // over directions of the plane
    for (int k = 0; k < 3600; ++k) {
      const Vector3 n(std::cos(k * M_PI / 1800), std::sin(k * M_PI / 1800), 0);
      const Vector3 top = A * ellipse.support(A.q.conjugate() * n),
                    bottom = B * other.support(B.q.conjugate() * -n);
      best = std::max(best, n.dot(bottom - top));
    }
    CHECK(c.gap >= best - 1e-12);
    CHECK(c.gap <= best + 1e-5);
  }
}
