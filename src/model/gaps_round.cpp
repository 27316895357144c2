// Spheres and discs against spheres, circles and cylinders, from outside and from inside.
#include "model/gap_maker.hpp"

namespace perp {
namespace {

/// The distance d from A's centre, or from A's axis, to B's centre, along which the gap is measured:
///   outside:  psi = |d| - (r_a + r_b),  n = d/|d|          inside:  psi = (r_a - r_b) - |d|,  n = -d/|d|
struct Round {
  double r_a, r_b;
  bool within = false;
  Vector3 point = Vector3::Zero();  // of the axis, A's axes
  Vector3 axis = Vector3::Zero();   // unit, A's axes; zero: a sphere's centre, no axis
  bool axis_turns = true;           // false: a planar scene's z axis

  int points() const { return 1; }
  double lever_a() const {
    return axis.isZero(0) || !axis_turns ? 0 : infinity;
  }  // the normal meets the centre
  double lever_b() const { return 0; }
  Vector3 world_axis(const Pose& X_WA) const { return axis_turns ? Vector3(X_WA.q * axis) : axis; }

  void evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
    const Vector3 a = world_axis(X_WA), s = X_WB.p - X_WA * point, d = s - a.dot(s) * a;
    const double distance = d.norm(), sign = within ? -1 : 1;
    Vector3 n = distance > 0 ? Vector3(sign / distance * d) : Vector3(Vector3::UnitX());
    if (!(distance > 0) && std::abs(a.x()) > 0.5) n = Vector3::UnitY();
    out[0] = {
        .gap = within ? r_a - r_b - distance : distance - r_a - r_b, .normal = n, .point = X_WB.p - r_b * n};
  }

  void differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
    const Vector3 a = world_axis(X_WA), x = X_WA.q * point, s = X_WB.p - X_WA.p - x;
    const double along = a.dot(s);
    const Vector3 d = s - along * a;
    const double distance = d.norm();
    if (distance > 0) {
      // dd = P ds - (a.s) da - a (s.da), P = I - a aᵀ, ds = v_B - v_A - w_A x x, da = w_A x a; only its part across d turns n
      const Matrix3 I = Matrix3::Identity(), P = I - a * a.transpose();
      const Matrix3 turn = (within ? -1 : 1) / distance * (I - d * d.transpose() / (distance * distance));
      v_A(out[0].normal) = -turn * P;
      v_B(out[0].normal) = turn * P;
      const Matrix3 da = axis_turns ? Matrix3(-skew(a)) : Matrix3::Zero();
      w_A(out[0].normal) = turn * (P * skew(x) - along * da - a * (s.transpose() * da));
    }
    out[0].point = -r_b * out[0].normal;
    v_B(out[0].point) += Matrix3::Identity();
  }
};

}  // namespace

Gap sphere_on_sphere(double radius_a, double radius_b) {
  length("sphere_on_sphere", "radius_a", radius_a);
  length("sphere_on_sphere", "radius_b", radius_b);
  return gap_of("sphere_on_sphere", Round{radius_a, radius_b}, Arguments() << radius_a << radius_b);
}

Gap sphere_in_sphere(double radius_a, double radius_b) {
  length("sphere_in_sphere", "radius_b", radius_b);
  length("sphere_in_sphere", "radius_a - radius_b", radius_a - radius_b);
  return gap_of("sphere_in_sphere", Round{radius_a, radius_b, true}, Arguments() << radius_a << radius_b);
}

Gap sphere_in_cylinder(double radius_a, double radius_b, const Vector3& axis, const Vector3& point) {
  length("sphere_in_cylinder", "radius_b", radius_b);
  length("sphere_in_cylinder", "radius_a - radius_b", radius_a - radius_b);
  if (!(axis.norm() > 0) || !axis.allFinite())
    refuse("sphere_in_cylinder", "axis", axis.norm(), "needs a direction");
  if (!point.allFinite()) refuse("sphere_in_cylinder", "point", "not finite", "needs finite entries [m]");
  return gap_of("sphere_in_cylinder", Round{radius_a, radius_b, true, point, axis.normalized()},
                Arguments() << radius_a << radius_b << axis << point);
}

Gap disc_in_circle(double radius_circle, double radius_disc) {
  length("disc_in_circle", "radius_disc", radius_disc);
  length("disc_in_circle", "radius_circle - radius_disc", radius_circle - radius_disc);
  return gap_of("disc_in_circle",
                Round{radius_circle, radius_disc, true, Vector3::Zero(), Vector3::UnitZ(), false},
                Arguments() << radius_circle << radius_disc);
}

Gap particle_in_circle(double radius) {
  length("particle_in_circle", "radius", radius);
  return gap_of("particle_in_circle", Round{radius, 0, true, Vector3::Zero(), Vector3::UnitZ(), false},
                Arguments() << radius);
}

}  // namespace perp
