// Solid spheres that slide and roll on a plane.
#include <algorithm>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// A solid sphere set down on a floor with velocity v0 and spin w0. Its contact point slides at u = v - R w x z, and since
/// friction changes v and w in fixed proportion, u decays along its own line at (7/2) mu g; then the sphere rolls.
struct ThrownSphere {
  Real R, mu;
  RealVector3 v0, w0;

  RealVector3 u0() const { return v0 - R * w0.cross(RealVector3::UnitZ()); }
  RealVector3 direction() const { return u0().norm() > 0 ? u0().normalized() : u0(); }
  Real rolls_at() const { return mu > 0 ? 2 * u0().norm() / (7 * mu * g) : infinity; }

  RealVector3 v(Real t) const { return v0 - mu * g * std::min(t, rolls_at()) * direction(); }
  RealVector3 w(Real t) const {
    return w0 + 5 * mu * g / (2 * R) * std::min(t, rolls_at()) * RealVector3::UnitZ().cross(direction());
  }
  RealVector3 x(Real t) const {
    const Real s = std::min(t, rolls_at());  // time spent sliding
    return v0 * s - mu * g * s * s / 2 * direction() + v(t) * (t - s);
  }
};

Scene thrown(double R, double mu, const Vector3& v0, const Vector3& w0) {
  Scene s;
  const BodyId ball =
      s.model.add_body(Inertia::solid_sphere(1, R), {.pose = {.p = {0, 0, R}}, .name = "ball"});
  s.model.add_contact(ground, ball, sphere_on_plane(R), {.mu = mu, .name = "floor"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, ball, v0, w0);

  const ThrownSphere motion{R, mu, v0.cast<Real>(), w0.cast<Real>()};
  const ReferenceMotion orientations = turning([=](Real t) { return motion.w(t); }, motion.rolls_at());
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    model.set_position(x, ball, Vector3(0, 0, R) + motion.x(t).cast<double>());
    model.set_orientation(x, ball, orientation(orientations.at(t).y));
    model.set_velocity(x, ball, motion.v(t).cast<double>(), motion.w(t).cast<double>());
  });
  return s;
}

}  // namespace

Scene seed_sphere(Parameters& set) {
  const double mu = set.number("mu", 0.2, "friction coefficient [-]", not_negative);
  const double v0 = set.number("v0", 2, "initial velocity along x [m/s]");
  Scene s = thrown(1, mu, {v0, 0, 0}, Vector3::Zero());
  s.id = "B1";
  s.what = "A solid sphere thrown along a floor slides, gathers spin and rolls [T03, section 4]";
  s.t_end = 0.6;
  return s;
}

Scene oblique_sphere(Parameters& set) {
  const double mu = set.number("mu", 0.3, "friction coefficient [-]", not_negative);
  const double heading = set.number("heading", 0, "turns the initial velocities about z [rad]");
  const Quaternion turn(Eigen::AngleAxisd(heading, Vector3::UnitZ()));
  Scene s = thrown(0.5, mu, turn * Vector3(3, 1, 0), turn * Vector3(4, -6, 5));
  s.id = "B2";
  s.what =
      "A spinning sphere slides along a parabola, its friction turned against its heading, then rolls "
      "straight";
  s.t_end = 2;
  return s;
}

Scene turntable(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double rate = set.number("rate", 2, "of the turntable [rad/s]");
  const double R = 0.1;
  const Vector3 r0(0.3, 0, 0), v0(0, 0.1, 0), z = Vector3::UnitZ();

  Scene s;
  s.id = "B5c";
  s.what = "A solid sphere rolls in a circle on a turntable, at 2/7 of the table's rate";
  const BodyId table = s.model.add_prescribed(PrescribedMotion::turntable(z, rate), {.name = "table"});
  const BodyId ball =
      s.model.add_body(Inertia::solid_sphere(1, R), {.pose = {.p = r0 + R * z}, .name = "ball"});
  s.model.add_contact(table, ball, sphere_on_plane(R), {.mu = mu, .name = "floor"});

  // rolling without slip: v - R w x z = rate z x r, which leaves w_z free; then v' = c z x v with c = (2/7) rate
  const RealVector3 up = RealVector3::UnitZ(), start = r0.cast<Real>(), velocity = v0.cast<Real>();
  const Real c = 2 * Real(rate) / 7;
  using Turn = Eigen::AngleAxis<Real>;
  const auto v = [=](Real t) -> RealVector3 { return Turn(c * t, up) * velocity; };
  const auto r = [=](Real t) -> RealVector3 {  // the integral of v, without a division by c
    const Real half = c * t / 2, sinc = half == 0 ? 1 : std::sin(half) / half;
    return start + t * sinc * (Turn(half, up) * velocity);
  };
  const auto w = [=](Real t) -> RealVector3 { return (up.cross(v(t)) + rate * r(t)) / R; };
  s.start = s.model.rest();
  s.model.set_velocity(s.start, ball, v0, w(0).cast<double>());

  if (mu * g < std::abs(double(c)) * v0.norm()) return s;  // it slips
  const ReferenceMotion orientations = turning(w);
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    model.set_position(x, ball, r(t).cast<double>() + R * z);
    model.set_orientation(x, ball, orientation(orientations.at(t).y));
    model.set_velocity(x, ball, v(t).cast<double>(), w(t).cast<double>());
  });
  return s;
}

}  // namespace perp
