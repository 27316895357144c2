// Two convex solids of flat faces: the features that meet, each a smooth gap of its own.
#pragma once

#include <memory>
#include <span>

#include "model/pairs/polytope.hpp"
#include "model/pairs/witness.hpp"

namespace perp {

/// A slot for every corner of B, every corner of A and every pair of edges. Each that is there is an exact distance of two points of
/// the solids (or, where they overlap, along a face's normal), so that normal and gap fit each other to all orders:
///   corner and face      gap along the face's normal, while the corner is over the face or inside
///   corner and edge      where the corner is nearest to the edge and the line between leaves its own solid
///   corner and corner    likewise; in B's slot
///   edge and edge        along e_A x e_B, where both edges are crossed within and the normal is one of both edges' cones
/// Slots that could be next are there too: the corners of a face that lies on another, edges that cross a face's rim. The least gap is
/// the distance of the solids where they are apart; where they overlap, corners inside count along the face that faces the least
/// translation that separates them.
class PolytopePair {
 public:
  PolytopePair(Polytope a, Polytope b);
  /// Of two that outlive it: makes nothing of its own.
  PolytopePair(const Polytope* a, const Polytope* b);

  int points() const { return corners_b_ + corners_a_ + edges_a_ * edges_b_; }
  double lever_a() const { return a_.reach(); }
  double lever_b() const { return b_.reach(); }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const;
  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const;

 private:
  enum class Kind { CornerFace, FaceCorner, CornerEdge, EdgeCorner, CornerCorner, EdgeEdge };
  struct Feature {
    Kind kind;
    int slot, of_a, of_b;
    Witness witness;  // A's axes
  };
  /// The direction, from A to B, of the least translation that separates; A's axes.
  struct Axis {
    double distance = -infinity;
    Vector3 normal = Vector3::Zero();
    int face_a = -1, face_b = -1;
  };
  struct Placed;

  template <class Take>
  void features(const Pose& X_AB, Take take) const;
  void edge_pairs(const Placed& B, Axis& axis, std::vector<Feature>& crossings) const;
  template <class Take>
  void corners_of_b(const Placed& B, const Axis& axis, Take take) const;
  template <class Take>
  void corners_of_a(const Placed& B, const Axis& axis, const std::vector<int>& on_face, Take take) const;
  bool edges_meet(const Polytope::Edge& a, const Polytope::Edge& b, const Placed& B, Witness& w,
                  bool& strict) const;
  void face_axes(const Placed& B, Axis& axis) const;
  MovingWitness moving(const Feature& f, const Pose& X_WA, const Pose& X_WB) const;

  PolytopePair(std::shared_ptr<const Polytope> a, std::shared_ptr<const Polytope> b);

  std::shared_ptr<const Polytope> own_a_, own_b_;  // null where others have them
  const Polytope &a_, &b_;
  int corners_a_, corners_b_, edges_a_, edges_b_;
  double slack_;  // lengths below count as none [m]
};

}  // namespace perp
