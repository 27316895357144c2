// A solid of flat faces, an edge or a corner, and a cylinder or a disc.
#pragma once

#include <span>

#include "model/pairs/polytope.hpp"
#include "model/pairs/witness.hpp"

namespace perp {

/// A circular cylinder about `axis` through `centre`, in its body's axes; of no length a disc.
struct RoundBar {
  Vector3 centre, axis, across;  ///< unit; `across` where angles on its rims are counted from
  double radius, half;           ///< half: of its length [m]
  double reach() const { return centre.norm() + std::hypot(radius, half); }
};

/// A of flat faces (blown up by its radius: a sphere is a corner, a capsule an edge), B a cylinder. Slots, each a smooth gap of its own:
///   corner of A           and a cap, the side or a rim, where it is nearest
///   edge of A and side    where the lines of edge and axis are nearest
///   edge of A and rim     where both tangents are across the line between: two for each rim
///   edge of A over a cap  where it crosses the rim, along the cap's normal: two for each cap
///   face of A and rim     the rim's lowest point over the face
///   rim's fixed points    eight on each rim, over the face that it is almost flat on
/// The least gap is the distance where the two are apart; where they overlap, features along the least translation over faces, caps, and the
/// normals of corners and edges that meet the side or a rim.
class CylinderPair {
 public:
  /// Both outlive it.
  CylinderPair(const Polytope& a, const RoundBar& b);

  int points() const;
  double lever_a() const { return a_.reach(); }
  double lever_b() const { return b_.reach(); }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  static constexpr int fixed = 8;
  enum class Kind { CornerCap, CornerSide, CornerRim, EdgeSide, EdgeRim, EdgeCap, FaceRim, FacePoint };
  struct Feature {
    Kind kind;
    int slot, of_a;   ///< corner, edge or face
    double end;       ///< -1 or 1: which cap or rim
    double angle;     ///< on the rim
    bool strict;      ///< its normal is one of both solids there
    Witness witness;  ///< A's axes
  };
  struct Placed;
  struct Axis {
    double distance = -infinity;
    Vector3 normal = Vector3::Zero();
  };

  template <class Take>
  void features(const Pose& X_AB, Take take) const;
  template <class Take>
  void corners(const Placed& B, Take take) const;
  template <class Take>
  void edges(const Placed& B, Take take) const;
  template <class Take>
  void edge_and_rims(const Placed& B, int edge, Take take) const;
  template <class Take>
  void edge_over_caps(const Placed& B, int edge, Take take) const;
  template <class Take>
  void faces(const Placed& B, Take take) const;
  Axis flat_axes(const Placed& B) const;
  MovingWitness moving(const Feature& f, const Pose& X_WA, const Pose& X_WB) const;
  MovingWitness moving_rim(const Feature& f, const Pose& X_WA, const Pose& X_WB) const;

  const Polytope& a_;
  const RoundBar& b_;
  int corners_, edges_, faces_, ends_;
  double slack_;  // lengths below count as none [m]
};

}  // namespace perp
