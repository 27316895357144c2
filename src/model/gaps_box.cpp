// A box of A against a sphere, and against another box.
#include "model/gap_maker.hpp"
#include "model/pairs/polytope_pair.hpp"

namespace perp {
namespace {

/// The nearest point of the box, piece by piece: face, edge or corner as one, two or three coordinates lie outside.
struct SphereOnBox {
  double radius;
  Vector3 half;

  int points() const { return 1; }
  double lever_a() const { return half.norm(); }
  double lever_b() const { return 0; }

  /// The centre in the box's axes; the outward direction; which coordinates count for it; the distance (< 0 inside).
  struct Nearest {
    Vector3 centre, normal, counts = Vector3::Zero();
    double distance;
  };
  Nearest nearest(const Pose& X_WA, const Pose& X_WB) const {
    Nearest at;
    at.centre = X_WA.inverse() * X_WB.p;
    at.normal = at.centre - at.centre.cwiseMax(-half).cwiseMin(half);
    at.distance = at.normal.norm();
    if (at.distance > 0) {
      at.normal /= at.distance;
      at.counts = (at.normal.array() != 0).cast<double>();
    } else {  // the centre is inside: out through the nearest face
      int face = 0;
      at.distance = (at.centre.cwiseAbs() - half).maxCoeff(&face);
      at.normal[face] = at.centre[face] < 0 ? -1 : 1;
    }
    return at;
  }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
    const Nearest at = nearest(X_WA, X_WB);
    const Vector3 n = X_WA.q * at.normal;
    out[0] = {.gap = at.distance - radius, .normal = n, .point = X_WB.p - radius * n};
  }

  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
    const Nearest at = nearest(X_WA, X_WB);
    const Matrix3 R = X_WA.R();
    // n = R n_A, dn_A = (I - n_A n_Aᵀ)/distance (centre's counting part), dcentre = Rᵀ (v_B - v_A - w_A x (p_B - p_A))
    Matrix3 turn = Matrix3::Zero();
    if (at.distance > 0)
      turn = R * (Matrix3::Identity() - at.normal * at.normal.transpose()) * at.counts.asDiagonal() *
             R.transpose() / at.distance;
    v_A(out[0].normal) = -turn;
    v_B(out[0].normal) = turn;
    w_A(out[0].normal) = turn * skew(X_WB.p - X_WA.p) - skew(R * at.normal);
    out[0].point = -radius * out[0].normal;
    v_B(out[0].point) += Matrix3::Identity();
  }
};

Polytope rectangle(const Vector2& size) {
  const double x = 0.5 * size.x(), y = 0.5 * size.y();
  return Polytope::polygon({{-x, -y}, {x, -y}, {x, y}, {-x, y}});
}

}  // namespace

Gap rectangle_on_rectangle(const Vector2& size_a, const Vector2& size_b) {
  for (const double edge : size_a) length("rectangle_on_rectangle", "size_a", edge);
  for (const double edge : size_b) length("rectangle_on_rectangle", "size_b", edge);
  return gap_of_pair("rectangle_on_rectangle", PolytopePair(rectangle(size_a), rectangle(size_b)),
                     Arguments() << size_a.x() << size_a.y() << size_b.x() << size_b.y());
}

Gap sphere_on_box(double radius, const Vector3& size) {
  length("sphere_on_box", "radius", radius);
  for (const double edge : size) length("sphere_on_box", "size", edge);
  return gap_of("sphere_on_box", SphereOnBox{radius, 0.5 * size}, Arguments() << radius << size);
}

Gap box_on_box(const Vector3& size_a, const Vector3& size_b) {
  for (const double edge : size_a) length("box_on_box", "size_a", edge);
  for (const double edge : size_b) length("box_on_box", "size_b", edge);
  return gap_of_pair("box_on_box", PolytopePair(Polytope::box(size_a), Polytope::box(size_b)),
                     Arguments() << size_a << size_b);
}

}  // namespace perp
