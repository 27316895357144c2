// Circles of B on a plane of A.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "model/pairs/witness.hpp"
#include "perp/model/gaps.hpp"

namespace perp {

/// The circles of a disc (one) or a cylinder (two) about the z axis of a place X_BS, with eight points fixed on each.
struct Rims {
  static constexpr int fixed = 8;
  struct Rim {
    Vector3 centre;
    std::vector<Vector3> points;
  };

  Rims(const std::vector<Vector3>& centres, double radius, const Pose& X_BS);

  std::vector<Rim> all;  ///< B's axes
  Vector3 axis, aside;   ///< unit; aside across the axis: where the lowest point is of a rim that lies flat
  double radius, reach = 0;
};

/// The rims on a plane, each with its lowest point, which rolls, and with its fixed points, for where it lies or stands flat: there all of
/// the rim is lowest, and the lowest point alone says nothing of what carries it. Down to a tilt of `flat` the lowest point is exact;
/// below it is that along -x of B and moves as one fixed in B.
class RimsOnPlane {
 public:
  RimsOnPlane(const Rims& rims, const Plane& plane) : rims_(&rims), plane_(plane) {}
  RimsOnPlane(std::shared_ptr<const Rims> rims, const Plane& plane)
      : own_(std::move(rims)), rims_(own_.get()), plane_(plane) {}

  int points() const { return static_cast<int>(rims_->all.size()) * (1 + Rims::fixed); }
  double lever_a() const { return infinity; }
  double lever_b() const { return rims_->reach; }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  std::shared_ptr<const Rims> own_;  // null where others have them
  const Rims* rims_;
  Plane plane_;
};

}  // namespace perp
