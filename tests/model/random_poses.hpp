// What tests of gaps share: numbers, directions and turns at random, the points of a gap at two poses.
#pragma once

#include <random>
#include <vector>

#include "perp/model/gap.hpp"

namespace perp {

struct Random {
  std::mt19937 engine;

  explicit Random(unsigned seed) : engine(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Vector3 direction() {
    Vector3 v;
    do v = {(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)};
    while (v.norm() > 1 || v.norm() < 0.1);
    return v.normalized();
  }
  Quaternion turn() { return rotation((*this)(0, 3) * direction()); }
};

inline std::vector<ContactPoint> points(const Gap& gap, const Pose& X_WA, const Pose& X_WB) {
  std::vector<ContactPoint> all(static_cast<std::size_t>(gap.points()));
  gap(X_WA, X_WB, 0, all);
  return all;
}

/// check_gap at two poses, and at others within `spread`.
inline GapCheckOptions about(const Pose& X_WA, const Pose& X_WB, double spread) {
  GapCheckOptions options;
  options.X_WA = X_WA;
  options.X_WB = X_WB;
  options.spread = spread;
  return options;
}

}  // namespace perp
