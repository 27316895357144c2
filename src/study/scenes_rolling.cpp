// Bodies that roll on a plane with a contact point that wanders over them: an ellipse, a rattleback, a disc on its rim.
#include <cmath>
#include <Eigen/LU>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// exact() knows the motion while friction and weight hold the contact point, not what follows.
enum { Rolls, Unknown };
ReferenceMotion rolling(Stretch rolls, const Reals& start) {
  rolls.next = [](Real, Reals&) { return Unknown; };
  return {{{Rolls, rolls}, {Unknown, still}}, start, Rolls};
}

void not_known(State& x) {
  x.q.setConstant(not_set);
  x.nu.setConstant(not_set);
}

}  // namespace

Scene rolling_ellipse(Parameters& set) {
  const double mu = set.number("mu", 2, "friction coefficient [-]", not_negative);
  const double angle0 =
      set.number("angle", 0.6, "initial angle of the long axis from the line [rad]", {-1.57, 1.57});
  const double a = 1, b = 0.5, I = (a * a + b * b) / 4;
  Scene s;
  s.id = "B16";
  s.what = "An ellipse rocks on its flat side, rolling without slipping";
  s.t_end = 0.5;
  s.model.set_gravity(down_y);
  const BodyId ellipse = s.model.add_planar_body(1, I, {.name = "ellipse"});
  s.model.add_contact(ground, ellipse, ellipse_on_line(a, b), {.mu = mu, .name = "floor"});

  // The centre's height H(angle) = √(a² sin² + b² cos²), y = (angle, angle', x): rolling means x' = -H angle', so that
  // (H² + H'² + I) angle'' = -(H + H'') H' angle'² - g H'.
  struct Height {
    Real H, slope, curvature;
    Height(Real e, Real b, Real angle) {
      const Real sn = std::sin(angle), c = std::cos(angle);
      H = std::sqrt(b * b + e * sn * sn);
      slope = e * sn * c / H;
      curvature = (e * (c * c - sn * sn) - slope * slope) / H;
    }
  };
  const Real e = Real(a) * a - Real(b) * b;
  const auto faster = [=](const Reals& y) {
    const Height h(e, b, y[0]);
    return -((h.H + h.curvature) * y[1] * y[1] + g) * h.slope / (h.H * h.H + h.slope * h.slope + I);
  };
  Stretch rolls;
  rolls.rate = [=](Real, const Reals& y, Reals& dy) { dy = {y[1], faster(y), -Height(e, b, y[0]).H * y[1]}; };
  rolls.guard = [=](Real, const Reals& y) {
    const Height h(e, b, y[0]);
    const Real along = -h.H * faster(y) - h.slope * y[1] * y[1];
    return mu * (g + h.slope * faster(y) + h.curvature * y[1] * y[1]) - std::abs(along);
  };
  const auto place = [=](const Model& model, State& x, const Reals& y) {
    const Height h(e, b, y[0]);
    PlanarMotion{y[2], h.H, y[0], -h.H * y[1], h.slope * y[1], y[1]}.put(model, x, ellipse);
  };
  const Reals start{angle0, 0, 0};
  s.start = s.model.rest();
  place(s.model, s.start, start);
  if (!(rolls.guard(0, start) > 0)) return s;  // it slips at once
  const ReferenceMotion motion = rolling(rolls, start);
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const auto [time, y, stretch] = motion.at(t);
    stretch == Rolls ? place(model, x, y) : not_known(x);
  });
  return s;
}

Scene rattleback(Parameters& set) {
  const double mu = set.number("mu", 2, "friction coefficient [-]", not_negative);
  const double spin = set.number("spin", -5, "initial rate about the upright [rad/s]");
  const double tilt = set.number("tilt", 0.01, "of the upright in both horizontal axes [rad]", {-0.1, 0.1});
  const Vector3 axes(0.2, 0.03, 0.02), centre(0, 0, 0.01);
  Matrix3 J = Vector3(2e-4, 1.6e-3, 1.7e-3).asDiagonal();
  J(0, 1) = J(1, 0) = -2e-5;
  Scene s;
  s.id = "B23";
  s.what = "A rattleback turned against its liking shakes, stops and turns back [KL82]";
  const BodyId stone = s.model.add_body(Inertia(1, J), {.name = "stone"});
  s.model.add_contact(ground, stone, ellipsoid_on_plane(axes, {}, centre), {.mu = mu, .name = "floor"});

  // In body axes, y = (w, orientation, x, y of the centre of mass): with the upright m, m' = m x w, and the contact point c,
  // rolling means v = c x w, and c x (force at c) gives J w' - c x (c x w') = J w x w + c x (c' x w + w x v + g m).
  using RealMatrix3 = Eigen::Matrix<Real, 3, 3>;
  const RealVector3 D = axes.cast<Real>().cwiseAbs2(), middle = centre.cast<Real>();
  const RealMatrix3 inertia = J.cast<Real>();
  struct Rolling {
    RealVector3 w, m, c, v, w_rate, force;
    Real height;
  };
  const auto look = [=](const Reals& y) {
    Rolling r;
    const Eigen::Quaternion<Real> q(y[3], y[4], y[5], y[6]);
    r.w = {y[0], y[1], y[2]};
    r.m = q.normalized().conjugate() * RealVector3::UnitZ();
    const RealVector3 Dm = D.cwiseProduct(r.m), m_rate = r.m.cross(r.w);
    const Real support = std::sqrt(r.m.dot(Dm));
    r.c = middle - Dm / support;
    r.height = -r.c.dot(r.m);
    r.v = r.c.cross(r.w);
    const RealVector3 c_rate =
        Dm * (Dm.dot(m_rate) / (support * support * support)) - D.cwiseProduct(m_rate) / support;
    const RealVector3 known = c_rate.cross(r.w) + r.w.cross(r.v) + g * r.m;
    RealMatrix3 C;
    C << 0, -r.c.z(), r.c.y(), r.c.z(), 0, -r.c.x(), -r.c.y(), r.c.x(), 0;
    const RealVector3 L = inertia * r.w;
    r.w_rate = RealMatrix3(inertia - C * C).inverse() * (L.cross(r.w) + r.c.cross(known));
    r.force = known + r.c.cross(r.w_rate);
    return r;
  };
  Stretch rolls;
  rolls.rate = [=](Real, const Reals& y, Reals& dy) {
    const Rolling r = look(y);
    const Eigen::Quaternion<Real> q(y[3], y[4], y[5], y[6]);
    const RealVector3 v = q.normalized() * r.v;
    for (int i = 0; i < 3; ++i) dy[static_cast<std::size_t>(i)] = r.w_rate[i];
    turn_in_body_axes(y, r.w, dy, 3);
    dy[7] = v.x();
    dy[8] = v.y();
  };
  rolls.guard = [=](Real, const Reals& y) {
    const Rolling r = look(y);
    const Real N = r.force.dot(r.m);
    return mu * N - (r.force - N * r.m).norm();
  };
  const auto place = [=](const Model& model, State& x, const Reals& y) {
    const Rolling r = look(y);
    const Eigen::Quaternion<Real> q = Eigen::Quaternion<Real>(y[3], y[4], y[5], y[6]).normalized();
    model.set_position(x, stone, {double(y[7]), double(y[8]), double(r.height)});
    model.set_orientation(x, stone, q.cast<double>());
    model.set_velocity(x, stone, (q * r.v).cast<double>(), (q * r.w).cast<double>());
  };
  const Vector3 upright = Vector3(tilt, tilt, 1).normalized(), w0 = spin * upright;
  const Quaternion q0 = Quaternion::FromTwoVectors(upright, Vector3::UnitZ());
  const Reals start{w0.x(), w0.y(), w0.z(), q0.w(), q0.x(), q0.y(), q0.z(), 0, 0};
  s.start = s.model.rest();
  place(s.model, s.start, start);
  if (!(rolls.guard(0, start) > 0)) return s;  // it slips at once
  const ReferenceMotion motion = rolling(rolls, start);
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const auto [time, y, stretch] = motion.at(t);
    stretch == Rolls ? place(model, x, y) : not_known(x);
  });
  return s;
}

Scene euler_disk(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double alpha = set.number("alpha", 0.1, "of the disc above the floor [rad]", {0, 1.57, true});
  const double a = 0.0375;
  Scene s;
  s.id = "C10";
  s.what = "A coin rolls steadily on its rim, its centre at rest";
  const BodyId disc =
      s.model.add_body(Inertia::principal(1, a * a * Vector3(0.25, 0.25, 0.5)), {.name = "disc"});
  s.model.add_contact(ground, disc, disc_on_plane(a), {.mu = mu, .name = "floor"});

  // it turns at rate sin(alpha) about the diameter through the contact point, which goes round at `rate`, and needs no friction
  const Real lean = alpha, rate = std::sqrt(4 * Real(g) / (Real(a) * std::sin(lean)));
  const auto place = [=](const Model& model, State& x, Real t) {
    using Turn = Eigen::AngleAxis<Real>;
    using R3 = RealVector3;
    const Eigen::Quaternion<Real> q =
        Turn(rate * t, R3::UnitZ()) * Turn(lean, R3::UnitX()) * Turn(-rate * std::cos(lean) * t, R3::UnitZ());
    const R3 uphill = Turn(rate * t, R3::UnitZ()) * R3(0, std::cos(lean), std::sin(lean));
    model.set_position(x, disc, {0, 0, double(a * std::sin(lean))});
    model.set_orientation(x, disc, q.cast<double>());
    model.set_velocity(x, disc, Vector3::Zero(), Vector3((rate * std::sin(lean) * uphill).cast<double>()));
  };
  s.start = s.model.rest();
  place(s.model, s.start, 0);
  s.exact = exact_by(s.model, place);
  return s;
}

}  // namespace perp
