// A plane of A against points, balls and ellipsoids of B.
#include <algorithm>

#include "model/gap_maker.hpp"
#include "model/pairs/round_on_plane.hpp"

namespace perp {
namespace {

/// Balls of one radius about points fixed in B, each a contact point at its lowest place. Radius 0: corners, feet.
struct BallsOnPlane {
  std::vector<Vector3> centres;  // B's axes
  double radius;
  Plane plane;

  int points() const { return static_cast<int>(centres.size()); }
  double lever_a() const { return infinity; }  // the plane has no end
  double lever_b() const {
    double longest = 0;
    for (const Vector3& c : centres) longest = std::max(longest, c.norm());
    return longest;
  }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
    const WorldPlane floor(plane, X_WA);
    const Matrix3 R = X_WB.R();
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const Vector3 x = X_WB.p + R * centres[i];
      out[i] = {
          .gap = floor.distance(x) - radius, .normal = floor.normal, .point = x - radius * floor.normal};
    }
  }

  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
    const Matrix3 n_turns = -skew(X_WA.q * plane.normal), R = X_WB.R();
    for (std::size_t i = 0; i < centres.size(); ++i) {
      w_A(out[i].normal) = n_turns;
      w_A(out[i].point) = -radius * n_turns;
      v_B(out[i].point).setIdentity();
      w_B(out[i].point) = -skew(R * centres[i]);
    }
  }
};

/// An ellipsoid about a point of B, its axes B's; a semi-axis of 0 makes it flat, as an ellipse or a disc is. Its lowest point
/// in the direction -m (unit, B's axes) is x = centre - D m/s, D = diag(a²), s = √(m·D m), its support there -s.
struct LowestOfEllipsoid {
  Vector3 squares;  // a², b², c²
  Plane plane;
  Vector3 centre = Vector3::Zero();  // B's axes

  int points() const { return 1; }
  double lever_a() const { return infinity; }
  double lever_b() const { return std::sqrt(squares.maxCoeff()); }

  struct Lowest {
    double support;
    Vector3 point;  // B's axes
    Lowest(const LowestOfEllipsoid& shape, const Vector3& m) {
      const Vector3 Dm = shape.squares.cwiseProduct(m);
      support = std::sqrt(m.dot(Dm));
      const Vector3 below =
          support > 0 ? Vector3(Dm / support) : std::sqrt(shape.squares.x()) * Vector3::UnitX();
      point = shape.centre - below;
    }
  };

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
    const WorldPlane floor(plane, X_WA);
    const Vector3 m = X_WB.q.conjugate() * floor.normal;
    const Lowest lowest(*this, m);
    out[0] = {.gap = floor.distance(X_WB * centre) - lowest.support,
              .normal = floor.normal,
              .point = X_WB * lowest.point};
  }

  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
    const Vector3 n = X_WA.q * plane.normal;
    const Matrix3 R = X_WB.R();
    const Vector3 m = R.transpose() * n, Dm = squares.cwiseProduct(m);
    const Lowest lowest(*this, m);
    const double s = lowest.support;
    // dx = -(D/s - D m (D m)ᵀ/s³) dm with dm = Rᵀ (w_A - w_B) x n; in world axes H = R (...) Rᵀ
    Matrix3 H = Matrix3::Zero();
    if (s > 0) H = Matrix3(squares.asDiagonal()) / s - Dm * Dm.transpose() / (s * s * s);
    H = R * H * R.transpose();
    const Matrix3 N = skew(n);
    w_A(out[0].normal) = -N;
    v_B(out[0].point).setIdentity();
    w_A(out[0].point) = H * N;
    w_B(out[0].point) = -skew(R * lowest.point) - H * N;
  }
};

BallsOnPlane corners(const Vector3& half, int count, const Plane& plane) {
  BallsOnPlane shape{{}, 0, plane};
  for (int corner = 0; corner < count;
       ++corner) {  // of a box 0..3 the lower face, 4..7 the upper, in B's axes
    const Vector3 sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
    shape.centres.emplace_back(sign.cwiseProduct(half));
  }
  return shape;
}

}  // namespace

Gap sphere_on_plane(double radius, const Plane& plane) {
  length("sphere_on_plane", "radius", radius);
  return gap_of("sphere_on_plane", BallsOnPlane{{Vector3::Zero()}, radius, unit("sphere_on_plane", plane)},
                Arguments() << radius << plane);
}

Gap particle_on_plane(const Plane& plane) {
  const Plane floor = unit("particle_on_plane", plane);
  return gap_of("particle_on_plane", BallsOnPlane{{Vector3::Zero()}, 0, floor}, Arguments() << plane);
}

Gap point_on_plane(const Vector3& point, const Plane& plane) {
  if (!point.allFinite()) refuse("point_on_plane", "point", "not finite", "needs finite entries [m]");
  const Plane floor = unit("point_on_plane", plane);
  return gap_of("point_on_plane", BallsOnPlane{{point}, 0, floor}, Arguments() << point << plane);
}

Gap capsule_on_plane(double radius, double length_, const Plane& plane) {
  length("capsule_on_plane", "radius", radius);
  const Vector3 end(0, 0, 0.5 * length("capsule_on_plane", "length", length_));
  const Plane floor = unit("capsule_on_plane", plane);
  return gap_of("capsule_on_plane", BallsOnPlane{{-end, end}, radius, floor},
                Arguments() << radius << length_ << plane);
}

Gap box_on_plane(const Vector3& size, const Plane& plane) {
  for (const double edge : size) length("box_on_plane", "size", edge);
  return gap_of("box_on_plane", corners(0.5 * size, 8, unit("box_on_plane", plane)),
                Arguments() << size << plane);
}

Gap ellipsoid_on_plane(const Vector3& semi_axes, const Plane& plane, const Vector3& centre) {
  for (const double a : semi_axes) length("ellipsoid_on_plane", "semi_axes", a);
  if (!centre.allFinite()) refuse("ellipsoid_on_plane", "centre", "not finite", "needs finite entries [m]");
  return gap_of("ellipsoid_on_plane",
                LowestOfEllipsoid{semi_axes.cwiseAbs2(), unit("ellipsoid_on_plane", plane), centre},
                Arguments() << semi_axes << plane << centre);
}

Gap disc_on_plane(double radius, const Plane& plane) {
  length("disc_on_plane", "radius", radius);
  const auto rim = std::make_shared<const Rims>(std::vector<Vector3>{Vector3::Zero()}, radius, Pose{});
  return gap_of_pair("disc_on_plane", RimsOnPlane(rim, unit("disc_on_plane", plane)),
                     Arguments() << radius << plane);
}

Gap disc_on_line(double radius, const Plane& line) {
  length("disc_on_line", "radius", radius);
  return gap_of("disc_on_line", BallsOnPlane{{Vector3::Zero()}, radius, unit("disc_on_line", line)},
                Arguments() << radius << line);
}

Gap ellipse_on_line(double a, double b, const Plane& line) {
  length("ellipse_on_line", "a", a);
  length("ellipse_on_line", "b", b);
  return gap_of("ellipse_on_line", LowestOfEllipsoid{{a * a, b * b, 0}, unit("ellipse_on_line", line)},
                Arguments() << a << b << line);
}

Gap box_on_line(double width, double height, const Plane& line) {
  length("box_on_line", "width", width);
  length("box_on_line", "height", height);
  return gap_of("box_on_line", corners({0.5 * width, 0.5 * height, 0}, 4, unit("box_on_line", line)),
                Arguments() << width << height << line);
}

}  // namespace perp
