// Bodies that turn freely or about a fixed point.
#include <cmath>

#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// Euler's equations J w' = J w x w + m(q) in body axes, J = diag(moments) about the fixed point or the centre of mass, with
/// the orientation q: y = (w, q).
template <class Moment>
ReferenceMotion turning_about_a_point(const Vector3& moments, const Vector3& w0, const Quaternion& q0,
                                      Moment moment) {
  const RealVector3 J = moments.cast<Real>();
  const auto rate = [=](Real, const Reals& y, Reals& dy) {
    const RealVector3 w(y[0], y[1], y[2]), L = J.cwiseProduct(w);
    const RealVector3 a = (L.cross(w) + moment(y)).cwiseQuotient(J);
    dy[0] = a.x();
    dy[1] = a.y();
    dy[2] = a.z();
    turn_in_body_axes(y, w, dy, 3);
  };
  return {rate, {w0.x(), w0.y(), w0.z(), q0.w(), q0.x(), q0.y(), q0.z()}};
}

/// A free body that starts at the identity with the angular velocity w0.
Scene free_body(const Vector3& moments, const Vector3& w0) {
  Scene s;
  s.model.set_gravity(Vector3::Zero());
  const BodyId body = s.model.add_body(Inertia::principal(1, moments), {.name = "body"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, body, Vector3::Zero(), w0);
  const ReferenceMotion motion = turning_about_a_point(moments, w0, Quaternion::Identity(),
                                                       [](const Reals&) { return RealVector3::Zero(); });
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Reals y = motion.at(t).y;
    const Quaternion q = orientation(y, 3);
    model.set_orientation(x, body, q);
    model.set_velocity(x, body, Vector3::Zero(), q * Vector3(double(y[0]), double(y[1]), double(y[2])));
  });
  return s;
}

}  // namespace

Scene dzhanibekov(Parameters& set) {
  const double spin = set.number("spin", 5, "about the middle axis [rad/s]");
  const double tilt = set.number("tilt", 0.01, "initial rate about the other two axes [rad/s]");
  Scene s = free_body({1, 2, 3}, {tilt, spin, tilt});
  s.id = "B12";
  s.what = "A free body that turns about its middle axis flips over and back, again and again";
  return s;
}

Scene free_spin(Parameters& set) {
  const double spin = set.number("spin", 1e4, "magnitude of the angular velocity [rad/s]", positive);
  Scene s = free_body({1e-4, 2e-4, 3e-4}, spin / std::sqrt(3) * Vector3::Ones());
  s.id = "C12";
  s.what = "A small free body spins so fast that its gyroscopic terms are stiff";
  return s;
}

Scene heavy_top(Parameters& set) {
  const double spin = set.number("spin", 150, "about the top's axis [rad/s]");
  const double theta = set.number("theta", pi / 6, "initial angle of the axis from upright [rad]", {0, pi});
  const double m = 1, l = 0.1, A = 0.012, C = 0.002;  // A, C about the tip
  Scene s;
  s.id = "B13";
  s.what = "A fast top on a ball joint, let go at an angle: it nods and precesses";
  s.t_end = 0.3;
  const BodyId top = s.model.add_body(Inertia::principal(m, {A - m * l * l, A - m * l * l, C}),
                                      {.pose = {.p = {0, 0, l}}, .name = "top"});
  s.model.add_joint(ball(ground, top, {.name = "tip"}));
  const auto place = [=](const Model& model, State& x, const Quaternion& q, const Vector3& w) {
    const Vector3 p = q * Vector3(0, 0, l), w_world = q * w;
    model.set_position(x, top, p);
    model.set_orientation(x, top, q);
    model.set_velocity(x, top, w_world.cross(p), w_world);
  };
  const Quaternion q0(std::cos(theta / 2), 0, std::sin(theta / 2), 0);
  s.start = s.model.rest();
  place(s.model, s.start, q0, {0, 0, spin});

  // weight acts at l along the axis: moment m g l (axis x down), both in body axes
  const auto weight = [=](const Reals& y) -> RealVector3 {
    const Eigen::Quaternion<Real> q(y[3], y[4], y[5], y[6]);
    return m * l * g * RealVector3::UnitZ().cross(q.conjugate() * RealVector3(0, 0, -1));
  };
  const ReferenceMotion motion = turning_about_a_point({A, A, C}, {0, 0, spin}, q0, weight);
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Reals y = motion.at(t).y;
    place(model, x, orientation(y, 3), {double(y[0]), double(y[1]), double(y[2])});
  });
  return s;
}

}  // namespace perp
