#include "perp/model/gaps.hpp"

#include <array>
#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

double length(const char* where, const char* argument, double value) {
  if (!(value > 0) || !std::isfinite(value))
    refuse(where, argument, value, "needs to be positive and finite [m]");
  return value;
}

/// A plane in world axes: signed distances from it, and its normal.
struct WorldPlane {
  Vector3 normal;
  double offset;
  WorldPlane(const Plane& plane, const Pose& X_WA)
      : normal(X_WA.q * plane.normal), offset(normal.dot(X_WA * plane.point)) {}
  double distance(const Vector3& x) const { return normal.dot(x) - offset; }
  /// The gap of a ball of radius r about x; its lowest point carries the impulse.
  ContactPoint ball(const Vector3& x, double r) const {
    return {.gap = distance(x) - r, .normal = normal, .point = x - r * normal};
  }
};

Plane unit(const char* where, const Plane& plane) {
  const double n = plane.normal.norm();
  if (!(n > 0) || !std::isfinite(n)) refuse(where, "plane.normal", n, "needs a direction");
  if (!plane.point.allFinite()) refuse(where, "plane.point", "not finite", "needs finite entries [m]");
  return {plane.normal / n, plane.point};
}

/// The gap between a sphere of radius r about b inside a wall of radius R about a; d = b - a, along which it is measured.
ContactPoint inside(double R, double r, const Vector3& d, const Vector3& b) {
  const double distance = d.norm();
  const Vector3 normal = distance > 0 ? Vector3(-d / distance) : Vector3(-Vector3::UnitX());
  return {.gap = R - r - distance, .normal = normal, .point = b - r * normal};
}

/// The arguments of a maker, one after the other.
struct Arguments : std::vector<double> {
  Arguments& operator<<(double x) {
    push_back(x);
    return *this;
  }
  Arguments& operator<<(const Vector3& x) {
    insert(end(), x.begin(), x.end());
    return *this;
  }
  Arguments& operator<<(const Plane& plane) { return *this << plane.normal << plane.point; }
};

Gap named(std::string_view maker, Gap gap, const Arguments& arguments) {
  return gap.made_by({maker, arguments, {}});
}

/// A convex polygon in a plane, clipped in place by half planes; a rectangle cut by a rectangle has at most 8 corners.
struct Polygon {
  std::array<Vector2, 8> corner;
  std::size_t size = 0;

  void clip(const Vector2& n, double limit) {  // keeps n . x <= limit
    std::array<Vector2, 8> kept;
    std::size_t count = 0;
    const auto add = [&](const Vector2& x) {
      if (count < kept.size()) kept[count++] = x;
    };
    for (std::size_t i = 0; i < size; ++i) {
      const Vector2 &p = corner[i], &q = corner[(i + 1) % size];
      const double dp = n.dot(p) - limit, dq = n.dot(q) - limit;
      if (dp <= 0) add(p);
      if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) add(p + dp / (dp - dq) * (q - p));
    }
    corner = kept;
    size = count;
  }
};

}  // namespace

Gap sphere_on_plane(double radius, const Plane& plane) {
  length("sphere_on_plane", "radius", radius);
  const auto gap = [radius, plane = unit("sphere_on_plane", plane)](const Pose& X_WA, const Pose& X_WB,
                                                                    double) {
    return WorldPlane(plane, X_WA).ball(X_WB.p, radius);
  };
  return named("sphere_on_plane", gap, Arguments() << radius << plane);
}

Gap particle_on_plane(const Plane& plane) {
  const auto gap = [plane = unit("particle_on_plane", plane)](const Pose& X_WA, const Pose& X_WB, double) {
    return WorldPlane(plane, X_WA).ball(X_WB.p, 0);
  };
  return named("particle_on_plane", gap, Arguments() << plane);
}

Gap point_on_plane(const Vector3& point, const Plane& plane) {
  if (!point.allFinite()) refuse("point_on_plane", "point", "not finite", "needs finite entries [m]");
  const auto gap = [point, plane = unit("point_on_plane", plane)](const Pose& X_WA, const Pose& X_WB,
                                                                  double) {
    return WorldPlane(plane, X_WA).ball(X_WB * point, 0);
  };
  return named("point_on_plane", gap, Arguments() << point << plane);
}

Gap sphere_on_sphere(double radius_a, double radius_b) {
  const double reach =
      length("sphere_on_sphere", "radius_a", radius_a) + length("sphere_on_sphere", "radius_b", radius_b);
  const auto gap = [=](const Pose& X_WA, const Pose& X_WB, double) {
    const Vector3 d = X_WB.p - X_WA.p;
    const double distance = d.norm();
    const Vector3 normal = distance > 0 ? Vector3(d / distance) : Vector3::UnitZ();
    return ContactPoint{.gap = distance - reach, .normal = normal, .point = X_WB.p - radius_b * normal};
  };
  return named("sphere_on_sphere", gap, Arguments() << radius_a << radius_b);
}

Gap sphere_in_sphere(double radius_a, double radius_b) {
  length("sphere_in_sphere", "radius_b", radius_b);
  length("sphere_in_sphere", "radius_a - radius_b", radius_a - radius_b);
  const auto gap = [=](const Pose& X_WA, const Pose& X_WB, double) {
    return inside(radius_a, radius_b, X_WB.p - X_WA.p, X_WB.p);
  };
  return named("sphere_in_sphere", gap, Arguments() << radius_a << radius_b);
}

Gap sphere_on_box(double radius, const Vector3& size) {
  length("sphere_on_box", "radius", radius);
  for (const double edge : size) length("sphere_on_box", "size", edge);
  const auto gap = [radius, half = Vector3(0.5 * size)](const Pose& X_WA, const Pose& X_WB, double) {
    const Vector3 centre = X_WA.inverse() * X_WB.p;  // in the box's axes, as the next two
    const Vector3 nearest = centre.cwiseMax(-half).cwiseMin(half);
    double distance = (centre - nearest).norm();
    Vector3 normal = centre - nearest;
    if (distance > 0) {
      normal /= distance;
    } else {  // the centre is inside: out through the nearest face
      int face = 0;
      distance = (centre.cwiseAbs() - half).maxCoeff(&face);
      normal[face] = centre[face] < 0 ? -1 : 1;
    }
    normal = X_WA.q * normal;
    return ContactPoint{.gap = distance - radius, .normal = normal, .point = X_WB.p - radius * normal};
  };
  return named("sphere_on_box", gap, Arguments() << radius << size);
}

Gap capsule_on_plane(double radius, double length_, const Plane& plane) {
  length("capsule_on_plane", "radius", radius);
  const double half = 0.5 * length("capsule_on_plane", "length", length_);
  Gap gap = Gap::patch(2, [=, plane = unit("capsule_on_plane", plane)](const Pose& X_WA, const Pose& X_WB,
                                                                       double, std::span<ContactPoint> out) {
    const WorldPlane floor(plane, X_WA);
    const Vector3 axis = X_WB.q * Vector3(0, 0, half);
    out[0] = floor.ball(X_WB.p - axis, radius);
    out[1] = floor.ball(X_WB.p + axis, radius);
  });
  return named("capsule_on_plane", gap, Arguments() << radius << length_ << plane);
}

Gap box_on_plane(const Vector3& size, const Plane& plane) {
  for (const double edge : size) length("box_on_plane", "size", edge);
  Gap gap = Gap::patch(8, [half = Vector3(0.5 * size), plane = unit("box_on_plane", plane)](
                              const Pose& X_WA, const Pose& X_WB, double, std::span<ContactPoint> out) {
    const WorldPlane floor(plane, X_WA);
    const Matrix3 R = X_WB.R();
    for (int corner = 0; corner < 8; ++corner) {  // 0..3 the lower face, 4..7 the upper, in B's axes
      const Vector3 sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
      out[static_cast<std::size_t>(corner)] = floor.ball(X_WB.p + R * sign.cwiseProduct(half), 0);
    }
  });
  return named("box_on_plane", gap, Arguments() << size << plane);
}

Gap box_on_box(const Vector3& size_a, const Vector3& size_b) {
  for (const double edge : size_a) length("box_on_box", "size_a", edge);
  for (const double edge : size_b) length("box_on_box", "size_b", edge);
  Gap gap = Gap::patch(8, [a = Vector3(0.5 * size_a), b = Vector3(0.5 * size_b)](
                              const Pose& X_WA, const Pose& X_WB, double, std::span<ContactPoint> out) {
    const Pose X_AB = X_WA.inverse() * X_WB;
    const Matrix3 R = X_AB.R();
    const Vector3 base = X_AB * Vector3(0, 0, -b.z());  // centre of B's bottom face, in A's axes
    Polygon overlap;
    for (const Vector2& sign : {Vector2(-1, -1), Vector2(1, -1), Vector2(1, 1), Vector2(-1, 1)})
      overlap.corner[overlap.size++] = (base + R.leftCols<2>() * sign.cwiseProduct(b.head<2>())).head<2>();
    overlap.clip(Vector2::UnitX(), a.x());
    overlap.clip(-Vector2::UnitX(), a.x());
    overlap.clip(Vector2::UnitY(), a.y());
    overlap.clip(-Vector2::UnitY(), a.y());

    // height of the bottom face's plane over each corner, along A's z
    const Vector3 slope = R.col(2);
    const Vector3 normal = X_WA.q * Vector3::UnitZ();
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = {};
      if (i >= overlap.size) continue;
      const Vector2& x = overlap.corner[i];
      const double z = base.z() - slope.head<2>().dot(x - base.head<2>()) / slope.z();
      out[i] = {.gap = z - a.z(), .normal = normal, .point = X_WA * Vector3(x.x(), x.y(), z)};
    }
  });
  return named("box_on_box", gap, Arguments() << size_a << size_b);
}

Gap disc_on_line(double radius, const Plane& line) {
  return named("disc_on_line", sphere_on_plane(radius, line), Arguments() << radius << line);
}

Gap disc_in_circle(double radius_circle, double radius_disc) {
  length("disc_in_circle", "radius_disc", radius_disc);
  length("disc_in_circle", "radius_circle - radius_disc", radius_circle - radius_disc);
  const auto gap = [=](const Pose& X_WA, const Pose& X_WB, double) {
    const Vector3 d = X_WB.p - X_WA.p;
    return inside(radius_circle, radius_disc, {d.x(), d.y(), 0}, X_WB.p);
  };
  return named("disc_in_circle", gap, Arguments() << radius_circle << radius_disc);
}

Gap particle_in_circle(double radius) {
  length("particle_in_circle", "radius", radius);
  const auto gap = [=](const Pose& X_WA, const Pose& X_WB, double) {
    const Vector3 d = X_WB.p - X_WA.p;
    return inside(radius, 0, {d.x(), d.y(), 0}, X_WB.p);
  };
  return named("particle_in_circle", gap, Arguments() << radius);
}

Gap box_on_line(double width, double height, const Plane& line) {
  length("box_on_line", "width", width);
  length("box_on_line", "height", height);
  Gap gap = Gap::patch(4, [=, line = unit("box_on_line", line)](const Pose& X_WA, const Pose& X_WB, double,
                                                                std::span<ContactPoint> out) {
    const WorldPlane floor(line, X_WA);
    for (int corner = 0; corner < 4; ++corner) {
      const Vector3 x_B(((corner & 1) != 0 ? 0.5 : -0.5) * width, ((corner & 2) != 0 ? 0.5 : -0.5) * height,
                        0);
      out[static_cast<std::size_t>(corner)] = floor.ball(X_WB * x_B, 0);
    }
  });
  return named("box_on_line", gap, Arguments() << width << height << line);
}

}  // namespace perp
