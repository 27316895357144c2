// Gaps of one's own with exact derivatives: written once on a scalar type, differentiated by the compiler.
#pragma once

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include "perp/model/gap.hpp"

namespace perp {

/// X_WB as Pose, over the scalar S.
template <class S>
struct PoseOf {
  Eigen::Matrix<S, 3, 1> p;
  Eigen::Matrix<S, 3, 3> R;
  Eigen::Matrix<S, 3, 1> operator*(const Eigen::Matrix<S, 3, 1>& x_B) const { return p + R * x_B; }
};

/// ContactPoint, over the scalar S.
template <class S>
struct ContactPointOf {
  S gap = S(0);
  Eigen::Matrix<S, 3, 1> normal;
  Eigen::Matrix<S, 3, 1> point;
  S gap_t = S(0);
};

/// A gap whose derivatives are those of its formula: a lambda that takes a scalar type S and then
///   (const PoseOf& X_WA, const PoseOf& X_WB, S t) -> ContactPointOf, all over S,
/// called with S = double and with a scalar that carries thirteen derivatives (the twists of A and of B, and time).
template <class Formula>
[[nodiscard]] Gap differentiable(Formula formula) {
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 13, 1>>;
  using DualVector = Eigen::Matrix<Dual, 3, 1>;
  const auto plain = [](const Pose& X) { return PoseOf<double>{X.p, X.R()}; };

  // x + dv, (1 + dw x) R: derivatives 0..2 and 3..5, or 6..8 and 9..11
  const auto dual = [](const Pose& X, int first) {
    PoseOf<Dual> Y;
    const Matrix3 R = X.R();
    for (int i = 0; i < 3; ++i) {
      Y.p[i] = Dual(X.p[i], 13, first + i);
      for (int j = 0; j < 3; ++j) {
        Y.R(i, j) = Dual(R(i, j));
        Y.R(i, j).derivatives().setZero();
        for (int k = 0; k < 3; ++k)
          Y.R(i, j).derivatives()[first + 3 + k] = Vector3::Unit(k).cross(Vector3(R.col(j)))[i];
      }
    }
    return Y;
  };

  Gap gap([=](const Pose& X_WA, const Pose& X_WB, double t) {
    const ContactPointOf<double> c = formula(plain(X_WA), plain(X_WB), t);
    return ContactPoint{.gap = c.gap, .normal = c.normal, .point = c.point, .gap_t = c.gap_t};
  });
  gap.differentiated_by([=](const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactDerivative> out) {
    const ContactPointOf<Dual> c = formula(dual(X_WA, 0), dual(X_WB, 6), Dual(t, 13, 12));
    const auto rows = [](const DualVector& x, ContactDerivative::Columns& columns, Vector3& x_t) {
      for (int i = 0; i < 3; ++i) {
        columns.row(i) = x[i].derivatives().template head<12>().transpose();
        x_t[i] = x[i].derivatives()[12];
      }
    };
    rows(c.normal, out[0].normal, out[0].normal_t);
    rows(c.point, out[0].point, out[0].point_t);
    out[0].gap_tt = c.gap_t.derivatives()[12];
  });
  return gap;
}

}  // namespace perp
