// What a body looks like: of shapes come contacts, and mass and inertia.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "perp/core/pose.hpp"
#include "perp/model/gap.hpp"

namespace perp {

/// A surface f(x) = 0 in a shape's axes, x in m, with its derivatives; f twice differentiable with a gradient that is not zero near it.
struct ImplicitSurface {
  std::function<double(const Vector3& x)> f;
  std::function<Vector3(const Vector3& x)> gradient;
  std::function<Matrix3(const Vector3& x)> hessian;  ///< empty: by differences of `gradient`
  double size = 0;        ///< a length of the surface, that errors are small beside [m]
  std::string text = {};  ///< f as an expression of x, y, z, where it is one
};

/// A solid in axes of its own: origin at its centre of volume, axis of capsule, cylinder and disc along z. Makers throw
/// std::invalid_argument naming the size that no solid can have. Planar shapes (of planar bodies and the ground) lie in the xy plane.
class Shape {
 public:
  enum class Kind {
    Sphere,
    HalfSpace,
    Box,
    Capsule,
    Cylinder,
    Disc,
    Ellipsoid,
    Superquadric,
    Polyhedron,
    HollowSphere,
    HollowCylinder,
    Formula,
    PlanarDisc,
    PlanarBox,
    Polygon,
    Ellipse,
    Line
  };

  static Shape sphere(double radius);
  static Shape half_space();                           ///< solid below its z = 0
  static Shape box(const Vector3& size);               ///< full edges
  static Shape capsule(double radius, double length);  ///< `length` between the centres of its ends
  static Shape cylinder(double radius, double length);
  static Shape disc(double radius);  ///< thin: a coin
  static Shape ellipsoid(const Vector3& semi_axes);
  /// ((x/a)^(2/e_2) + (y/b)^(2/e_2))^(e_2/e_1) + (z/c)^(2/e_1) <= 1 of absolute values, with exponents (e_1, e_2) in [0.1, 1.9]: 1 rounds as
  /// an ellipsoid, less is like a box, more like an octahedron.
  static Shape superquadric(const Vector3& semi_axes, const Vector2& exponents);
  /// The convex hull of points, at least four, not in a plane. The origin moves to the hull's centre of volume.
  static Shape polyhedron(const std::vector<Vector3>& vertices);
  static Shape hollow_sphere(double radius);    ///< solid outside the radius: others are inside
  static Shape hollow_cylinder(double radius);  ///< likewise about z, without ends
  /// Solid where f < 0: a bowl, a cam, a track. Meets spheres and particles.
  static Shape formula(ImplicitSurface surface);
  static Shape planar_disc(double radius);
  static Shape ellipse(double a, double b);  ///< semi-axes along x and y
  static Shape box(double width, double height);
  static Shape polygon(const std::vector<Vector2>& vertices);  ///< convex hull of at least three
  static Shape line();                                         ///< solid below y = 0

  Kind kind() const { return kind_; }
  const std::vector<double>& sizes() const { return sizes_; }         ///< as given to the maker [m]
  const std::vector<Vector3>& vertices() const { return vertices_; }  ///< of polyhedra and polygons
  const std::vector<std::vector<int>>& faces() const {
    return faces_;
  }  ///< of polyhedra: loops, counter-clockwise from outside
  const ImplicitSurface& surface() const { return *surface_; }  ///< of a formula
  const Vector3& centre() const {
    return centre_;
  }  ///< of a polyhedron or polygon in the axes its vertices were given in
  bool planar() const { return kind_ >= Kind::PlanarDisc; }
  std::string_view name() const;  ///< "box"

  /// [m^3], planar [m^2]; 0 of a disc, infinity of what has no end.
  double volume() const;
  /// Second moments of volume about the origin: J = density * moments; planar: (2, 2) [m^5, m^4].
  Matrix3 moments() const;
  /// The point furthest along a direction; of shapes that end.
  Vector3 support(const Vector3& direction) const;
  double reach()
      const;  ///< the largest distance of its points from its origin; infinity of what has no end [m]

 private:
  Shape(Kind kind, std::vector<double> sizes) : kind_(kind), sizes_(std::move(sizes)) {}
  void take_hull(const std::vector<Vector3>& points);

  Kind kind_;
  std::vector<double> sizes_;
  std::vector<Vector3> vertices_;
  std::vector<std::vector<int>> faces_;
  Vector3 centre_ = Vector3::Zero();
  std::shared_ptr<const ImplicitSurface> surface_;
};

/// The gap between two shapes that sit at X_AS, X_BS in their bodies, each of its points a feature of both; throws
/// std::invalid_argument where there is none for this pair (hollow in hollow, half space on half space, ...).
[[nodiscard]] Gap gap_between(const Shape& a, const Shape& b, const Pose& X_AS = {}, const Pose& X_BS = {});

/// Mass of solids at poses X_BS in a body, in its axes.
struct MassProperties {
  double mass = 0;                   ///< [kg]
  Vector3 centre = Vector3::Zero();  ///< of mass [m]
  Matrix3 J = Matrix3::Zero();       ///< about it [kg m^2]

  /// Of a shape with a volume, and what was there; refuses a density that is not positive [kg/m^3, kg/m^2].
  void add(const Shape& shape, const Pose& X_BS, double density);
};

}  // namespace perp
