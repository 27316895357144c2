// Joints with and without dry friction: pendulums under gravity along -y, and a block on a guide.
#include <cmath>
#include <numbers>

#include "study/scene_parts.hpp"

namespace perp {

Scene friction_pendulum(Parameters& set) {
  const double tau =
      set.number("friction", 0.5, "largest moment of dry friction in the hinge [N m]", not_negative);
  const double angle = set.number("angle", 1.2, "initial angle from straight down [rad]");
  const double m = 2, c = 0.5, J = 0.5;  // a point mass of 1 kg at 1 m has the same equation
  Scene s;
  s.id = "B8";
  s.what = "A pendulum with dry friction in its hinge swings ever less and sticks beside its lowest place";
  s.model.set_gravity(down_y);
  const BodyId arm = s.model.add_planar_body(m, J, {.pose = {.p = {0, -c, 0}}, .name = "arm"});
  s.model.add_joint(revolute(ground, arm, {.friction = tau, .name = "hinge"}));
  const auto place = [=](const Model& model, State& state, Real phi, Real omega) {
    hanging(0, 0, 0, 0, c, phi, omega).put(model, state, arm);
  };
  s.start = s.model.rest();
  place(s.model, s.start, angle, 0);

  // (J + m c^2) phi'' = -m g c sin(phi) -+ tau; at rest friction holds what it can
  const Real inertia = J + m * c * c, weight = Real(g) * m * c, hold = tau;
  const auto swinging = [=](int sign) {
    Stretch swing;
    swing.rate = [=](Real, const Reals& y, Reals& dy) {
      dy[0] = y[1];
      dy[1] = -(weight * std::sin(y[0]) + sign * hold) / inertia;
    };
    swing.guard = [=](Real, const Reals& y) { return sign * y[1]; };
    swing.next = [=](Real, Reals& y) {
      y[1] = 0;
      return std::abs(weight * std::sin(y[0])) <= hold ? 0 : -sign;
    };
    return swing;
  };
  const Real pull = -weight * std::sin(Real(angle));
  const int first = std::abs(pull) <= hold ? 0 : pull > 0 ? 1 : -1;
  const ReferenceMotion motion({{0, still}, {1, swinging(1)}, {-1, swinging(-1)}}, {angle, 0}, first);
  s.exact = exact_by(s.model, [=](const Model& model, State& state, Real t) {
    const Reals y = motion.at(t).y;
    place(model, state, y[0], y[1]);
  });
  return s;
}

Scene spring_block(Parameters& set) {
  const double F = set.number("friction", 1, "dry friction of the guide [N]", not_negative);
  const double x0 = set.number("x0", 0.5, "initial stretch [m]");
  const double m = 1, stiffness = 25;
  Scene s;
  s.id = "B9";
  s.what =
      "A block on a spring and a rough guide loses the same length of swing each half cycle until it sticks";
  s.t_end = 0.5;
  s.model.set_gravity(Vector3::Zero());
  const BodyId block = s.model.add_planar_body(m, 1, {.name = "block"});
  s.model.add_joint(prismatic(ground, block, {.axis = Vector3::UnitX(), .friction = F, .name = "guide"}));
  s.model.add_spring({.a = ground, .b = block, .stiffness = stiffness});
  s.start = s.model.rest();
  s.model.set_position(s.start, block, {x0, 0, 0});

  // half a cycle takes pi/w about the centre +-F/k and turns at 2 F/k less; within F/k friction holds
  const Real w = std::sqrt(Real(stiffness) / m), centre = F / stiffness, half = std::numbers::pi_v<Real> / w;
  s.exact = exact_by(s.model, [=](const Model& model, State& state, Real t) {
    Real x = std::abs(Real(x0)), v = 0, since = t;
    Real side = x0 < 0 ? -1 : 1;  // the block starts this half cycle at side * x, at rest
    for (; x > centre && since >= half; since -= half, side = -side) x -= 2 * centre;
    if (x < 0) x = -x, side = -side;  // came to rest before the spring's
    if (x > centre) {
      v = -side * (x - centre) * w * std::sin(w * since);
      x = centre + (x - centre) * std::cos(w * since);
    }
    PlanarMotion{side * x, 0, 0, v, 0, 0}.put(model, state, block);
  });
  return s;
}

Scene double_pendulum(Parameters& set) {
  const double angle1 =
      set.number("angle1", pi / 2, "initial angle of the upper arm from straight down [rad]");
  const double angle2 =
      set.number("angle2", pi / 2, "initial angle of the lower arm from straight down [rad]");
  Scene s;
  s.id = "B14";
  s.what =
      "A double pendulum, its arms' masses placed so that they move as two unit point masses on unit strings";
  s.model.set_gravity(down_y);
  const double c1 = 2.0 / 3, c2 = 0.75;
  const BodyId upper = s.model.add_planar_body(1, 2.0 / 9, {.pose = {.p = {0, -c1, 0}}, .name = "upper"});
  const BodyId lower =
      s.model.add_planar_body(4.0 / 3, 0.25, {.pose = {.p = {0, -1 - c2, 0}}, .name = "lower"});
  s.model.add_joint(revolute(ground, upper, {.name = "shoulder"}));
  s.model.add_joint(revolute(upper, lower, {.point = {0, -1, 0}, .name = "elbow"}));
  const auto place = [=](const Model& model, State& state, const Reals& y) {  // y = (angles, rates)
    const PlanarMotion elbow = hanging(0, 0, 0, 0, 1, y[0], y[2]);
    hanging(0, 0, 0, 0, c1, y[0], y[2]).put(model, state, upper);
    hanging(elbow.x, elbow.y, elbow.vx, elbow.vy, c2, y[1], y[3]).put(model, state, lower);
  };
  s.start = s.model.rest();
  place(s.model, s.start, {angle1, angle2, 0, 0});

  // L = w1^2 + w2^2/2 + w1 w2 cos(a1 - a2) + g (2 cos a1 + cos a2)
  const auto rate = [](Real, const Reals& y, Reals& dy) {
    const Real c = std::cos(y[0] - y[1]), sn = std::sin(y[0] - y[1]);
    const Real f1 = -y[3] * y[3] * sn - 2 * g * std::sin(y[0]);
    const Real f2 = y[2] * y[2] * sn - g * std::sin(y[1]);
    dy[0] = y[2];
    dy[1] = y[3];
    dy[2] = (f1 - c * f2) / (2 - c * c);
    dy[3] = (2 * f2 - c * f1) / (2 - c * c);
  };
  const ReferenceMotion motion(rate, {angle1, angle2, 0, 0});
  s.exact = exact_by(s.model,
                     [=](const Model& model, State& state, Real t) { place(model, state, motion.at(t).y); });
  return s;
}

}  // namespace perp
