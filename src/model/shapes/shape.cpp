#include "perp/model/shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "model/gap_maker.hpp"
#include "model/shapes/hull.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr double pi = 3.14159265358979323846;
Matrix3 diagonal(double x, double y, double z) { return Vector3(x, y, z).asDiagonal(); }

double beta(double x, double y) { return std::exp(std::lgamma(x) + std::lgamma(y) - std::lgamma(x + y)); }

/// ‖(x, y)‖ of exponent p, and its gradient: without overflow or underflow of the powers.
double norm_of(double p, double x, double y, Vector2& gradient) {
  const double largest = std::max(std::abs(x), std::abs(y));
  gradient.setZero();
  if (!(largest > 0)) return 0;
  const double u = std::abs(x) / largest, v = std::abs(y) / largest;
  const double n = std::pow(std::pow(u, p) + std::pow(v, p), 1 / p);
  gradient = {std::copysign(std::pow(u / n, p - 1), x), std::copysign(std::pow(v / n, p - 1), y)};
  return largest * n;
}

/// The gradient of the support function: of the dual norms of the two that the shape's own is made of.
Vector3 superquadric_support(const Vector3& a, double e1, double e2, const Vector3& d) {
  const auto dual = [](double e) { return 2 / (2 - e); };  // p = 2/e, 1/p + 1/q = 1
  Vector2 inner, outer;
  const double across = norm_of(dual(e2), a.x() * d.x(), a.y() * d.y(), inner);
  norm_of(dual(e1), across, a.z() * d.z(), outer);
  return {a.x() * outer.x() * inner.x(), a.y() * outer.x() * inner.y(), a.z() * outer.y()};
}

/// Volume, first and second moments (∫ x xᵀ) of the tetrahedra that a surface makes with the origin.
struct Moments {
  double volume = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();

  void add(const Vector3& a, const Vector3& b, const Vector3& c) {
    const double v = a.dot(b.cross(c)) / 6;
    const Vector3 sum = a + b + c;
    volume += v;
    first += v / 4 * sum;
    second += v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
};

Moments moments_of(const std::vector<Vector3>& vertices, const std::vector<std::vector<int>>& faces) {
  Moments m;
  for (const std::vector<int>& loop : faces)
    for (std::size_t i = 1; i + 1 < loop.size(); ++i)
      m.add(vertices[at(loop[0])], vertices[at(loop[i])], vertices[at(loop[i + 1])]);
  return m;
}

/// The same of a polygon: area, ∫ x, ∫ x xᵀ.
Moments moments_of(const std::vector<Vector3>& loop) {
  Moments m;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vector3 &a = loop[i], &b = loop[(i + 1) % loop.size()], sum = a + b;
    const double area = a.cross(b).z() / 2;
    m.volume += area;
    m.first += area / 3 * sum;
    m.second += area / 12 * (a * a.transpose() + b * b.transpose() + sum * sum.transpose());
  }
  return m;
}

/// Zero where it is that but for rounding, so that vertices about their centre stay what they are.
Vector3 centre_of(const Moments& m, const std::vector<Vector3>& vertices) {
  constexpr double rounding = 1e-14;  // of the size
  double size = 0;
  for (const Vector3& x : vertices) size = std::max(size, x.norm());
  const Vector3 centre = m.first / m.volume;
  return centre.norm() > rounding * size ? centre : Vector3::Zero();
}

/// Counter-clockwise, without points on or within it: Andrew's monotone chain.
std::vector<Vector3> planar_hull(std::vector<Vector2> points) {
  const auto turn = [](const Vector3& a, const Vector3& b, const Vector2& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  std::sort(points.begin(), points.end(), [](const Vector2& a, const Vector2& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  std::vector<Vector3> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Vector2& x : points) {
      while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), x) <= 0) hull.pop_back();
      hull.emplace_back(x.x(), x.y(), 0);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

}  // namespace

Shape Shape::sphere(double radius) { return {Kind::Sphere, {length("Shape::sphere", "radius", radius)}}; }
Shape Shape::half_space() { return {Kind::HalfSpace, {}}; }
Shape Shape::line() { return {Kind::Line, {}}; }
Shape Shape::disc(double radius) { return {Kind::Disc, {length("Shape::disc", "radius", radius)}}; }
Shape Shape::planar_disc(double radius) {
  return {Kind::PlanarDisc, {length("Shape::planar_disc", "radius", radius)}};
}
Shape Shape::hollow_sphere(double radius) {
  return {Kind::HollowSphere, {length("Shape::hollow_sphere", "radius", radius)}};
}
Shape Shape::hollow_cylinder(double radius) {
  return {Kind::HollowCylinder, {length("Shape::hollow_cylinder", "radius", radius)}};
}
Shape Shape::box(const Vector3& size) {
  for (const double edge : size) length("Shape::box", "size", edge);
  return {Kind::Box, {size.x(), size.y(), size.z()}};
}
Shape Shape::box(double width, double height) {
  return {Kind::PlanarBox, {length("Shape::box", "width", width), length("Shape::box", "height", height)}};
}
Shape Shape::capsule(double radius, double length_) {
  return {Kind::Capsule,
          {length("Shape::capsule", "radius", radius), length("Shape::capsule", "length", length_)}};
}
Shape Shape::cylinder(double radius, double length_) {
  return {Kind::Cylinder,
          {length("Shape::cylinder", "radius", radius), length("Shape::cylinder", "length", length_)}};
}
Shape Shape::ellipsoid(const Vector3& semi_axes) {
  for (const double a : semi_axes) length("Shape::ellipsoid", "semi_axes", a);
  return {Kind::Ellipsoid, {semi_axes.x(), semi_axes.y(), semi_axes.z()}};
}

Shape Shape::superquadric(const Vector3& semi_axes, const Vector2& exponents) {
  for (const double a : semi_axes) length("Shape::superquadric", "semi_axes", a);
  for (const double e : exponents)
    if (!(e >= 0.1 && e <= 1.9)) refuse("Shape::superquadric", "exponents", e, "need to be in [0.1, 1.9]");
  return {Kind::Superquadric, {semi_axes.x(), semi_axes.y(), semi_axes.z(), exponents.x(), exponents.y()}};
}
Shape Shape::ellipse(double a, double b) {
  return {Kind::Ellipse, {length("Shape::ellipse", "a", a), length("Shape::ellipse", "b", b)}};
}
Shape Shape::formula(ImplicitSurface surface) {
  if (!surface.f || !surface.gradient)
    refuse("Shape::formula", "surface", "without f or gradient", "needs both as functions");
  length("Shape::formula", "size", surface.size);
  Shape shape(Kind::Formula, {});
  shape.surface_ = std::make_shared<const ImplicitSurface>(std::move(surface));
  return shape;
}

Shape Shape::polyhedron(const std::vector<Vector3>& vertices) {
  Shape shape(Kind::Polyhedron, {});
  Hull hull = convex_hull("Shape::polyhedron", vertices);
  const Moments m = moments_of(hull.vertices, hull.faces);
  if (!(m.volume > 0)) refuse("Shape::polyhedron", "vertices", "flat", "need to span a solid");
  shape.centre_ = centre_of(m, hull.vertices);
  for (Vector3& x : hull.vertices) x -= shape.centre_;
  shape.vertices_ = std::move(hull.vertices);
  shape.faces_ = std::move(hull.faces);
  return shape;
}

Shape Shape::polygon(const std::vector<Vector2>& vertices) {
  Shape shape(Kind::Polygon, {});
  for (const Vector2& x : vertices)
    if (!x.allFinite()) refuse("Shape::polygon", "vertices", "not finite", "need finite coordinates [m]");
  shape.vertices_ = planar_hull(vertices);
  if (shape.vertices_.size() < 3)
    refuse("Shape::polygon", "vertices", std::to_string(shape.vertices_.size()) + " corners",
           "need three at least that are not in line");
  const Moments m = moments_of(shape.vertices_);
  shape.centre_ = centre_of(m, shape.vertices_);
  for (Vector3& x : shape.vertices_) x -= shape.centre_;
  return shape;
}

std::string_view Shape::name() const {
  static constexpr std::string_view names[] = {
      "sphere",       "half_space", "box",           "capsule",         "cylinder", "disc", "ellipsoid",
      "superquadric", "polyhedron", "hollow_sphere", "hollow_cylinder", "formula",  "disc", "box",
      "polygon",      "ellipse",    "line"};
  return names[static_cast<std::size_t>(kind_)];
}

double Shape::volume() const {
  const std::vector<double>& s = sizes_;
  switch (kind_) {
    case Kind::Sphere:
      return 4.0 / 3 * pi * s[0] * s[0] * s[0];
    case Kind::Box:
      return s[0] * s[1] * s[2];
    case Kind::Capsule:
      return pi * s[0] * s[0] * (s[1] + 4.0 / 3 * s[0]);
    case Kind::Cylinder:
      return pi * s[0] * s[0] * s[1];
    case Kind::Ellipsoid:
      return 4.0 / 3 * pi * s[0] * s[1] * s[2];
    case Kind::Superquadric:
      return 2 * s[0] * s[1] * s[2] * s[3] * s[4] * beta(s[3] / 2 + 1, s[3]) * beta(s[4] / 2, s[4] / 2);
    case Kind::Polyhedron:
      return moments_of(vertices_, faces_).volume;
    case Kind::PlanarDisc:
      return pi * s[0] * s[0];
    case Kind::PlanarBox:
      return s[0] * s[1];
    case Kind::Ellipse:
      return pi * s[0] * s[1];
    case Kind::Polygon:
      return moments_of(vertices_).volume;
    case Kind::Disc:
      return 0;
    default:
      return infinity;
  }
}

Matrix3 Shape::moments() const {
  const std::vector<double>& s = sizes_;
  const double v = volume();
  const auto of_box = [&](double x, double y, double z) {
    return diagonal(v / 12 * (y * y + z * z), v / 12 * (x * x + z * z), v / 12 * (x * x + y * y));
  };
  const auto of_second = [](const Matrix3& second) -> Matrix3 {
    return second.trace() * Matrix3::Identity() - second;
  };
  switch (kind_) {
    case Kind::Sphere:
      return 0.4 * v * s[0] * s[0] * Matrix3::Identity();
    case Kind::Box:
      return of_box(s[0], s[1], s[2]);
    case Kind::Capsule: {  // cylinder, and half balls whose centres of volume are 3/8 r from their planes
      const double r = s[0], l = s[1], middle = pi * r * r * l, ball = 4.0 / 3 * pi * r * r * r;
      const double across =
          middle * (3 * r * r + l * l) / 12 + ball * (0.4 * r * r + l * l / 4 + 3.0 / 8 * l * r);
      return diagonal(across, across, middle * r * r / 2 + 0.4 * ball * r * r);
    }
    case Kind::Cylinder: {
      const double across = v * (3 * s[0] * s[0] + s[1] * s[1]) / 12;
      return diagonal(across, across, v * s[0] * s[0] / 2);
    }
    case Kind::Ellipsoid:
      return v / 5 *
             diagonal(s[1] * s[1] + s[2] * s[2], s[0] * s[0] + s[2] * s[2], s[0] * s[0] + s[1] * s[1]);
    case Kind::Superquadric: {  // [JLS00, ch. 2]: integrals of x^2, y^2 and z^2
      const double e = s[3], f = s[4], all = s[0] * s[1] * s[2] * e * f / 2;
      const double across = all * beta(1.5 * f, f / 2) * beta(e / 2, 2 * e + 1);
      const double along = 4 * all * beta(f / 2, f / 2 + 1) * beta(1.5 * e, e + 1);
      return of_second(diagonal(across * s[0] * s[0], across * s[1] * s[1], along * s[2] * s[2]));
    }
    case Kind::Polyhedron:
      return of_second(moments_of(vertices_, faces_).second);
    case Kind::PlanarDisc:
      return diagonal(0, 0, v * s[0] * s[0] / 2);
    case Kind::PlanarBox:
      return diagonal(0, 0, v / 12 * (s[0] * s[0] + s[1] * s[1]));
    case Kind::Ellipse:
      return diagonal(0, 0, v / 4 * (s[0] * s[0] + s[1] * s[1]));
    case Kind::Polygon:
      return diagonal(0, 0, moments_of(vertices_).second.trace());
    default:
      return Matrix3::Zero();
  }
}

Vector3 Shape::support(const Vector3& d) const {
  const std::vector<double>& s = sizes_;
  const auto sign = [](double x) { return x < 0 ? -1.0 : 1.0; };
  const auto around = [&](double radius) -> Vector3 {
    const double across = std::hypot(d.x(), d.y());
    if (!(across > 0)) return radius * Vector3::UnitX();
    return radius / across * Vector3(d.x(), d.y(), 0);
  };
  switch (kind_) {
    case Kind::Sphere:
      return d.norm() > 0 ? Vector3(s[0] * d.normalized()) : Vector3(0, 0, s[0]);
    case Kind::Box:
      return 0.5 * Vector3(sign(d.x()) * s[0], sign(d.y()) * s[1], sign(d.z()) * s[2]);
    case Kind::Capsule:
      return (d.norm() > 0 ? Vector3(s[0] * d.normalized()) : Vector3(0, 0, s[0])) +
             Vector3(0, 0, sign(d.z()) * s[1] / 2);
    case Kind::Cylinder:
      return around(s[0]) + Vector3(0, 0, sign(d.z()) * s[1] / 2);
    case Kind::Disc:
    case Kind::PlanarDisc:
      return around(s[0]);
    case Kind::Ellipsoid: {
      const Vector3 D(s[0] * s[0], s[1] * s[1], s[2] * s[2]);
      return D.cwiseProduct(d) / std::sqrt(d.dot(D.cwiseProduct(d)));
    }
    case Kind::Ellipse: {
      const double h = std::hypot(s[0] * d.x(), s[1] * d.y());
      return h > 0 ? Vector3(s[0] * s[0] * d.x() / h, s[1] * s[1] * d.y() / h, 0) : Vector3(s[0], 0, 0);
    }
    case Kind::Superquadric:
      return superquadric_support({s[0], s[1], s[2]}, s[3], s[4], d);
    case Kind::PlanarBox:
      return 0.5 * Vector3(sign(d.x()) * s[0], sign(d.y()) * s[1], 0);
    case Kind::Polyhedron:
    case Kind::Polygon:
      return *std::max_element(vertices_.begin(), vertices_.end(),
                               [&](const Vector3& a, const Vector3& b) { return a.dot(d) < b.dot(d); });
    default:
      refuse("Shape::support", "shape", name(), "has no end");
  }
}

double Shape::reach() const {
  const std::vector<double>& s = sizes_;
  switch (kind_) {
    case Kind::Sphere:
    case Kind::Disc:
    case Kind::PlanarDisc:
      return s[0];
    case Kind::Box:
      return 0.5 * Vector3(s[0], s[1], s[2]).norm();
    case Kind::PlanarBox:
      return 0.5 * std::hypot(s[0], s[1]);
    case Kind::Capsule:
      return s[0] + s[1] / 2;
    case Kind::Cylinder:
      return std::hypot(s[0], s[1] / 2);
    case Kind::Ellipsoid:
      return std::max({s[0], s[1], s[2]});
    case Kind::Superquadric:  // within its box
      return Vector3(s[0], s[1], s[2]).norm();
    case Kind::Ellipse:
      return std::max(s[0], s[1]);
    case Kind::Polyhedron:
    case Kind::Polygon: {
      double longest = 0;
      for (const Vector3& x : vertices_) longest = std::max(longest, x.norm());
      return longest;
    }
    default:
      return infinity;
  }
}

void MassProperties::add(const Shape& shape, const Pose& X_BS, double density) {
  if (!(density > 0) || !std::isfinite(density))
    refuse("shape", "density", density, "needs to be positive and finite");
  const double volume = shape.volume();
  if (!(volume > 0) || !std::isfinite(volume))
    refuse("shape", "density", density,
           "a " + std::string(shape.name()) + " has no volume of its own: the body needs mass and inertia");
  const auto shift = [](double m, const Vector3& d) -> Matrix3 {
    return m * (d.squaredNorm() * Matrix3::Identity() - d * d.transpose());
  };
  const double m = density * volume;
  const Matrix3 R = X_BS.R();
  const Vector3 both = (mass * centre + m * X_BS.p) / (mass + m);
  J += shift(mass, centre - both) + density * R * shape.moments() * R.transpose() + shift(m, X_BS.p - both);
  mass += m;
  centre = both;
}

}  // namespace perp
