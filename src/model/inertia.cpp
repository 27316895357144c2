#include "perp/model/inertia.hpp"

#include <cmath>
#include <Eigen/Eigenvalues>
#include <sstream>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

void need_positive(const char* where, const char* argument, double value) {
  if (!(value > 0) || !std::isfinite(value))
    refuse(where, argument, value, "needs to be positive and finite");
}

std::string row(const Vector3& v) { return shortest(v[0]) + " " + shortest(v[1]) + " " + shortest(v[2]); }

}  // namespace

Inertia::Inertia(double mass, const Matrix3& J) : mass_(mass), J_(J) {
  need_positive("Inertia", "mass", mass);
  const std::string text = "(" + row(J.row(0)) + "; " + row(J.row(1)) + "; " + row(J.row(2)) + ")";
  if (!J.allFinite()) refuse("Inertia", "J", text, "needs finite entries");
  if (!J.isApprox(J.transpose(), 1e-12)) refuse("Inertia", "J", text, "needs to be symmetric");

  J_ = 0.5 * (J + J.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(J_);
  moments_ = eigen.eigenvalues();
  axes_ = eigen.eigenvectors();
  if (axes_.determinant() < 0) axes_.col(0) = -axes_.col(0);
  if (!(moments_[0] > 0)) refuse("Inertia", "principal moments", row(moments_), "each needs to be positive");
  if (moments_[0] + moments_[1] < moments_[2] * (1 - 1e-12))
    refuse("Inertia", "principal moments", row(moments_),
           "the two smaller ones need to add up to the largest at least: no body has these");
}

Inertia Inertia::principal(double mass, const Vector3& moments) { return {mass, moments.asDiagonal()}; }

Inertia Inertia::solid_sphere(double mass, double radius) {
  need_positive("Inertia::solid_sphere", "radius", radius);
  return principal(mass, Vector3::Constant(0.4 * mass * radius * radius));
}

Inertia Inertia::hollow_sphere(double mass, double radius) {
  need_positive("Inertia::hollow_sphere", "radius", radius);
  return principal(mass, Vector3::Constant(2.0 / 3.0 * mass * radius * radius));
}

Inertia Inertia::solid_box(double mass, const Vector3& size) {
  for (const double edge : size) need_positive("Inertia::solid_box", "size", edge);
  const Vector3 s = size.cwiseAbs2();
  return principal(mass, mass / 12 * Vector3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()));
}

Inertia Inertia::solid_cylinder(double mass, double radius, double length) {
  need_positive("Inertia::solid_cylinder", "radius", radius);
  need_positive("Inertia::solid_cylinder", "length", length);
  const double across = mass * (3 * radius * radius + length * length) / 12;
  return principal(mass, {across, across, 0.5 * mass * radius * radius});
}

Inertia Inertia::solid_ellipsoid(double mass, const Vector3& semi_axes) {
  for (const double a : semi_axes) need_positive("Inertia::solid_ellipsoid", "semi_axes", a);
  const Vector3 s = semi_axes.cwiseAbs2();
  return principal(mass, mass / 5 * Vector3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()));
}

}  // namespace perp
