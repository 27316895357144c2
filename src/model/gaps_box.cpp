// A box of A against a sphere, and against another box.
#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include <array>

#include "model/gap_maker.hpp"

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

/// A convex polygon in a plane, clipped in place by half planes; a rectangle cut by a rectangle has at most 8 corners.
template <class S>
struct Polygon {
  using Point = Eigen::Matrix<S, 2, 1>;
  std::array<Point, 8> corner;
  std::size_t size = 0;

  /// Keeps sign x[axis] <= limit. A corner nearer to the line than a share of 1e-9 is on it: edges that lie in line, as of boxes
  /// stacked, stay so whatever the rounding, and corners do not come and go.
  void clip(int axis, double sign, double limit) {
    const double near = 1e-9 * limit;
    std::array<Point, 8> kept;
    std::size_t count = 0;
    const auto add = [&](const Point& x) {
      if (count < kept.size()) kept[count++] = x;
    };
    for (std::size_t i = 0; i < size; ++i) {
      const Point &p = corner[i], &q = corner[(i + 1) % size];
      const S dp = sign * p[axis] - limit, dq = sign * q[axis] - limit;
      if (dp <= near) add(p);
      if ((dp < -near && dq > near) || (dp > near && dq < -near)) {
        const S part = dp / (dp - dq);
        Point x;
        for (int k = 0; k < 2; ++k) x[k] = p[k] + part * (q[k] - p[k]);
        add(x);
      }
    }
    corner = kept;
    size = count;
  }
};

/// The overlap of B's bottom face with A's top face, seen along A's z, and B's height there.
struct BoxOnBox {
  Vector3 a, b;  // half sizes

  int points() const { return 8; }
  double lever_a() const { return infinity; }  // its points come and go as it slides: not a distance
  double lever_b() const { return infinity; }

  /// Corners (x, y, z) in A's axes of B's bottom face, clipped; from the pose of B in A's axes over any scalar.
  template <class S>
  std::size_t overlap(const Eigen::Matrix<S, 3, 1>& p, const Eigen::Matrix<S, 3, 3>& R,
                      std::array<Eigen::Matrix<S, 3, 1>, 8>& out) const {
    Eigen::Matrix<S, 3, 1> base;  // centre of the bottom face
    for (int k = 0; k < 3; ++k) base[k] = p[k] - b.z() * R(k, 2);
    Polygon<S> polygon;
    for (const Vector2& sign : {Vector2(-1, -1), Vector2(1, -1), Vector2(1, 1), Vector2(-1, 1)}) {
      auto& corner = polygon.corner[polygon.size++];
      for (int k = 0; k < 2; ++k)
        corner[k] = base[k] + sign.x() * b.x() * R(k, 0) + sign.y() * b.y() * R(k, 1);
    }
    for (int axis = 0; axis < 2; ++axis)
      for (const double side : {1.0, -1.0}) polygon.clip(axis, side, a[axis]);
    for (std::size_t i = 0; i < polygon.size; ++i) {  // height of the face's plane over each corner
      const auto& x = polygon.corner[i];
      out[i] = {x[0], x[1], base[2] - (R(0, 2) * (x[0] - base[0]) + R(1, 2) * (x[1] - base[1])) / R(2, 2)};
    }
    return polygon.size;
  }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
    const Pose X_AB = X_WA.inverse() * X_WB;
    std::array<Vector3, 8> corner;
    const std::size_t size = overlap<double>(X_AB.p, X_AB.R(), corner);
    const Vector3 normal = X_WA.q * Vector3::UnitZ();
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = {};
      if (i < size) out[i] = {.gap = corner[i].z() - a.z(), .normal = normal, .point = X_WA * corner[i]};
    }
  }

  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
    using Dual =
        Eigen::AutoDiffScalar<Eigen::Matrix<double, 6, 1>>;  // by the twist of B seen from A, A's axes
    const Pose X_AB = X_WA.inverse() * X_WB;
    const Matrix3 R_A = X_WA.R(), R_AB = X_AB.R();
    Eigen::Matrix<Dual, 3, 1> p;
    Eigen::Matrix<Dual, 3, 3> R;
    for (int i = 0; i < 3; ++i) {
      p[i] = Dual(X_AB.p[i], 6, i);
      for (int j = 0; j < 3; ++j) {
        R(i, j) = Dual(R_AB(i, j));
        R(i, j).derivatives().setZero();
        for (int k = 0; k < 3; ++k)
          R(i, j).derivatives()[3 + k] = Vector3::Unit(k).cross(Vector3(R_AB.col(j)))[i];
      }
    }
    std::array<Eigen::Matrix<Dual, 3, 1>, 8> corner;
    const std::size_t size = overlap<Dual>(p, R, corner);

    // v_AB = Rᵀ (v_B - v_A - w_A x (p_B - p_A)),  w_AB = Rᵀ (w_B - w_A);  the point is p_A + R_A corner
    const Matrix3 r = skew(X_WB.p - X_WA.p);
    for (std::size_t i = 0; i < size; ++i) {
      Eigen::Matrix<double, 3, 6> J;
      Vector3 x;
      for (int k = 0; k < 3; ++k) {
        J.row(k) = corner[i][k].derivatives().transpose();
        x[k] = corner[i][k].value();
      }
      const Matrix3 by_v = R_A * J.leftCols<3>() * R_A.transpose();
      const Matrix3 by_w = R_A * J.rightCols<3>() * R_A.transpose();
      w_A(out[i].normal) = -skew(R_A.col(2));
      v_A(out[i].point) = Matrix3::Identity() - by_v;
      w_A(out[i].point) = -skew(R_A * x) + by_v * r - by_w;
      v_B(out[i].point) = by_v;
      w_B(out[i].point) = by_w;
    }
  }
};

/// Corners of each rectangle on the faces of the other: 0..3 those of B on A, 4..7 those of A on B.
struct RectangleOnRectangle {
  Vector2 a, b;  // half sizes

  int points() const { return 8; }
  double lever_a() const { return infinity; }  // its points come and go: not a distance
  double lever_b() const { return infinity; }

  /// One corner on a face of the other rectangle: who has the face and who the corner, the face's outward normal in its owner's axes.
  struct Touch {
    bool there = false;
    double gap = 0;
    Vector3 normal = Vector3::Zero(), corner = Vector3::Zero();  // owner's axes
  };

  /// `corner` (its owner's axes) on the rectangle of half size `half`, whose axes X_FC leads to.
  static Touch touch(const Pose& X_FC, const Vector2& half, const Vector3& corner) {
    const Vector3 c = X_FC * corner;
    const auto apart = [&](int axis) { return std::abs(X_FC.p[axis]) - half[axis]; };
    const int first = apart(0) > apart(1) ? 0 : 1;  // the face that parts the rectangles more
    Touch touch;
    touch.corner = corner;
    for (const int axis : {first, 1 - first}) {
      if (!(std::abs(c[1 - axis]) <= half[1 - axis])) continue;
      const bool outside = std::abs(c[axis]) > half[axis];
      const double side = (outside ? c[axis] : X_FC.p[axis]) < 0 ? -1 : 1;
      touch.there = true;
      touch.gap = side * c[axis] - half[axis];
      touch.normal[axis] = side;
      return touch;
    }
    return touch;
  }

  Touch touch(const Pose& X_WA, const Pose& X_WB, std::size_t i) const {
    const Vector2 sign((i & 1U) != 0 ? 1 : -1, (i & 2U) != 0 ? 1 : -1);
    const bool of_b = i < 4;
    const Vector2 corner = sign.cwiseProduct(of_b ? b : a);
    return of_b ? touch(X_WA.inverse() * X_WB, a, {corner.x(), corner.y(), 0})
                : touch(X_WB.inverse() * X_WA, b, {corner.x(), corner.y(), 0});
  }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
    for (std::size_t i = 0; i < 8; ++i) {
      const Touch t = touch(X_WA, X_WB, i);
      out[i] = {};
      if (!t.there) continue;
      const Vector3 n = i < 4 ? Vector3(X_WA.q * t.normal) : Vector3(-(X_WB.q * t.normal));
      out[i] = {.gap = t.gap, .normal = n, .point = (i < 4 ? X_WB : X_WA) * t.corner};
    }
  }

  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
    for (std::size_t i = 0; i < 8; ++i) {
      const Touch t = touch(X_WA, X_WB, i);
      if (!t.there) continue;
      if (i < 4) {
        w_A(out[i].normal) = -skew(X_WA.q * t.normal);
        v_B(out[i].point).setIdentity();
        w_B(out[i].point) = -skew(X_WB.q * t.corner);
      } else {
        w_B(out[i].normal) = skew(X_WB.q * t.normal);
        v_A(out[i].point).setIdentity();
        w_A(out[i].point) = -skew(X_WA.q * t.corner);
      }
    }
  }
};

}  // namespace

Gap rectangle_on_rectangle(const Vector2& size_a, const Vector2& size_b) {
  for (const double edge : size_a) length("rectangle_on_rectangle", "size_a", edge);
  for (const double edge : size_b) length("rectangle_on_rectangle", "size_b", edge);
  return gap_of("rectangle_on_rectangle", RectangleOnRectangle{0.5 * size_a, 0.5 * size_b},
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
  return gap_of("box_on_box", BoxOnBox{0.5 * size_a, 0.5 * size_b}, Arguments() << size_a << size_b);
}

}  // namespace perp
