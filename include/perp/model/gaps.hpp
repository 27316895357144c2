// The gaps that perp brings along. Each says which of the two bodies is which: A first, B second, as in add_contact.
#pragma once

#include "perp/model/gap.hpp"

namespace perp {

/// A half space of body A in A's axes: solid where normal . (x - point) < 0. The default is the floor z = 0.
struct Plane {
  Vector3 normal = Vector3::UnitZ();  ///< outwards; made a unit vector
  Vector3 point = Vector3::Zero();    ///< anywhere on the boundary [m]
};

/// The line y = 0 of planar scenes, solid below.
inline const Plane horizontal_line{Vector3::UnitY(), Vector3::Zero()};

// Spatial. Lengths in m; each throws std::invalid_argument for a length that is not positive and finite.
[[nodiscard]] Gap particle_on_plane(const Plane& plane = {});               ///< B's origin
[[nodiscard]] Gap sphere_on_plane(double radius, const Plane& plane = {});  ///< sphere about B's origin
[[nodiscard]] Gap sphere_on_sphere(double radius_a, double radius_b);       ///< both about their origins
[[nodiscard]] Gap sphere_in_sphere(double radius_a, double radius_b);       ///< B inside the hollow A

/// B inside a hollow circular cylinder of A: `axis` (made a unit vector) through `point`, both in A's axes.
[[nodiscard]] Gap sphere_in_cylinder(double radius_a, double radius_b, const Vector3& axis = Vector3::UnitZ(),
                                     const Vector3& point = Vector3::Zero());

/// An ellipsoid about `centre` in B's axes, its own axes B's.
[[nodiscard]] Gap ellipsoid_on_plane(const Vector3& semi_axes, const Plane& plane = {},
                                     const Vector3& centre = Vector3::Zero());

/// The rim of a thin disc about B's origin in B's xy plane: its lowest point (flat, that along -x of B, which moves as one fixed in B),
/// and eight points fixed on it, there up to a tilt of 30 degrees, for where it lies flat. 9 points.
[[nodiscard]] Gap disc_on_plane(double radius, const Plane& plane = {});

/// The nearest point of a box about A's origin, `size` its full edges: a table with edges and corners to fall from.
[[nodiscard]] Gap sphere_on_box(double radius, const Vector3& size);

/// A point fixed in B, in B's axes: the foot of a table.
[[nodiscard]] Gap point_on_plane(const Vector3& point, const Plane& plane = {});

[[nodiscard]] Gap capsule_on_plane(double radius, double length,
                                   const Plane& plane = {});                   ///< axis B's z; 2 points
[[nodiscard]] Gap box_on_plane(const Vector3& size, const Plane& plane = {});  ///< full edges of B; 8 points

/// Two boxes about their origins, full edges along their axes: corners of each on the faces of the other, edges that cross, and edges and
/// corners that are nearest, 160 points of which few are there at a time; each its own smooth gap. The least gap is the boxes' distance
/// or, where they overlap, what the least translation that separates them leaves; face to face the points are the corners of the
/// faces' overlap. Slots: eight corners of B, eight of A, the pairs of edges; corners numbered x first, then y, then z. A point lies
/// half way between the surfaces.
[[nodiscard]] Gap box_on_box(const Vector3& size_a, const Vector3& size_b);

/// `gap` between shapes that sit elsewhere in their bodies: A's at X_AS, B's at X_BS (in the body's axes), where `gap` has them at
/// the origins. Refuses a place that is not finite.
[[nodiscard]] Gap placed(const Gap& gap, const Pose& X_AS, const Pose& X_BS);

// Planar: A's and B's z axes are the world's; normals lie in the xy plane.
[[nodiscard]] Gap disc_on_line(double radius, const Plane& line = horizontal_line);
[[nodiscard]] Gap ellipse_on_line(double a, double b,
                                  const Plane& line = horizontal_line);      ///< semi-axes along B's x and y
[[nodiscard]] Gap disc_in_circle(double radius_circle, double radius_disc);  ///< circle about A's origin
[[nodiscard]] Gap particle_in_circle(double radius);  ///< B's origin; along z it is a tube
[[nodiscard]] Gap box_on_line(double width, double height,
                              const Plane& line = horizontal_line);  ///< 4 points

/// Two rectangles about their origins, full edges along their axes: corners of B (four slots), then of A, on the faces of the other, or
/// nearest to a corner. One inside counts along the face that looks most along the least translation that separates the two. Points lie
/// half way between the surfaces.
[[nodiscard]] Gap rectangle_on_rectangle(const Vector2& size_a, const Vector2& size_b);

}  // namespace perp
