// Circles and ellipsoids of B on a plane of A.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "model/pairs/witness.hpp"
#include "perp/model/gaps.hpp"

namespace perp {

/// The rims of a disc (one) or a cylinder (two), each with its lowest point, which rolls, and with points fixed on it, for where it lies
/// or stands flat: there all of the rim is lowest, and the lowest point alone says nothing of what carries it. Down to a tilt of `flat`
/// the lowest point is exact; below it is that along -x of B and moves as one fixed in B.
class RimsOnPlane {
 public:
  /// One disc about `centres[i]` each, axis along z of B.
  RimsOnPlane(std::vector<Vector3> centres, double radius, const Plane& plane, const Pose& X_BS = {});

  int points() const { return static_cast<int>(rims_.size()) * (1 + fixed); }
  double lever_a() const { return infinity; }
  double lever_b() const { return reach_; }
  std::string feature(int slot) const;  ///< "rim0", "rim0-5"

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  static constexpr int fixed = 8;
  struct Rim {
    Vector3 centre;
    std::vector<Vector3> points;
  };

  std::vector<Rim> rims_;  // B's axes
  Vector3 axis_, aside_;   // unit; aside_ across the axis: where the lowest point is of a rim that lies flat
  double radius_, reach_ = 0;
  Plane plane_;
};

/// The lowest point of an ellipsoid at X_BS.
class EllipsoidOnPlane {
 public:
  EllipsoidOnPlane(const Vector3& semi_axes, const Plane& plane, const Pose& X_BS);

  int points() const { return 1; }
  double lever_a() const { return infinity; }
  double lever_b() const { return reach_; }
  static std::string feature(int) { return {}; }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  Matrix3 D_;  // B's axes: support point D m/√(mᵀ D m)
  Vector3 centre_;
  double reach_;
  Plane plane_;
};

}  // namespace perp
