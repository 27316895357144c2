// Convex solids of flat faces as their corners, edges and faces, each with what tells where a point is nearest to it.
#pragma once

#include <vector>

#include "perp/core/pose.hpp"

namespace perp {

/// The convex hull of `corners`, blown up by `radius`: a point (a sphere's centre), a segment (a capsule's axis), a box, a polyhedron, a
/// half space (a face without corners); in the plane z = 0 a polygon, which is a prism without ends.
struct Polytope {
  struct Edge {
    int from, to;                ///< corners
    Vector3 along;               ///< unit
    double length;               ///< [m]
    std::vector<Vector3> sides;  ///< within each face that meets here, away from the edge, unit; none of a segment
  };
  struct Side {
    Vector3 normal;  ///< of an edge within the face's plane, outwards
    double limit;    ///< normal . x <= limit in the face [m]
  };
  struct Face {
    Vector3 normal;  ///< unit, outwards
    double offset;   ///< normal . x of its points [m]
    Vector3 point;   ///< one of them
    std::vector<Side> sides;
  };

  std::vector<Vector3> corners;
  std::vector<std::vector<Vector3>> spokes;  ///< of each corner, unit vectors along its edges
  std::vector<Edge> edges;
  std::vector<Face> faces;
  double radius = 0;  ///< [m]
  double size = 0;    ///< the largest distance between corners [m]

  static Polytope point(double radius);
  static Polytope segment(double length, double radius);  ///< along z about the origin
  static Polytope box(const Vector3& size);               ///< full edges about the origin
  static Polytope half_space();                           ///< solid below z = 0
  static Polytope polygon(std::vector<Vector2> corners);  ///< in the plane z = 0, counter-clockwise, convex
  /// Faces as loops of corners, counter-clockwise seen from outside; convex.
  static Polytope polyhedron(std::vector<Vector3> corners, const std::vector<std::vector<int>>& loops);

  Polytope moved(const Pose& X) const;
  double reach() const;  ///< the largest distance of a point of it from the origin; infinity of a half space [m]
  bool solid() const { return !faces.empty(); }

  /// Of the face whose plane x is furthest above.
  int highest_face(const Vector3& x, double& height) const;
  bool over(const Face& face, const Vector3& x, double slack) const;

 private:
  void add_edge(int from, int to, std::vector<Vector3> sides);
  void add_face(const std::vector<int>& loop);
};

}  // namespace perp
