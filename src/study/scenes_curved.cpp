// Contacts whose normal turns as they move: a roller and a bead inside circles, a disc on top of one, a bowl.
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {

Scene roller_in_cylinder(Parameters& set) {
  const double mu = set.number("mu", 1, "friction coefficient [-]", not_negative);
  const double lambda = set.number(
      "lambda", 0.5, "inertia over mass times radius squared: 1/2 solid, 1 hoop [-]", {0, 1, true});
  const double theta0 = set.number("theta", pi / 3, "initial place, from the lowest [rad]", {-1.57, 1.57});
  const double R = 1, r = 0.2, L = R - r;
  Scene s;
  s.id = "B6";
  s.what = "A roller swings to and fro in a hollow cylinder without slipping";
  s.model.set_gravity(down_y);
  const BodyId roller = s.model.add_planar_body(
      1, lambda * r * r, {.pose = {.p = {L * std::sin(theta0), -L * std::cos(theta0), 0}}, .name = "roller"});
  s.model.add_contact(ground, roller, disc_in_circle(R, r), {.mu = mu, .name = "cylinder"});
  s.start = s.model.rest();

  // theta'' = -g/((1 + lambda) L) sin(theta); friction is needed most at the start
  if (mu < lambda / (1 + lambda) * std::abs(std::tan(theta0))) return s;
  const Real stiffness = g / ((1 + Real(lambda)) * L);
  const auto rate = [=](Real, const Reals& y, Reals& dy) {
    dy[0] = y[1];
    dy[1] = -stiffness * std::sin(y[0]);
  };
  const ReferenceMotion motion(rate, {theta0, 0});
  s.exact = exact_by(s.model, [=](const Model& model, State& state, Real t) {
    const Reals y = motion.at(t).y;
    PlanarMotion now = hanging(0, 0, 0, 0, L, y[0], y[1]);
    now.angle = -L / r * (y[0] - theta0);
    now.omega = -L / r * y[1];
    now.put(model, state, roller);
  });
  return s;
}

Scene ball_on_sphere(Parameters& set) {
  const double mu = set.number("mu", 1, "friction coefficient [-]", not_negative);
  const double theta0 = set.number("theta", 0.1, "initial place, from the top [rad]", acute);
  const double R = 1, r = 0.2, L = R + r;
  Scene s;
  s.id = "B7";
  s.what = "A ball rolls down a sphere, slips, and leaves it";
  s.model.set_gravity(down_y);
  const BodyId ball = s.model.add_planar_body(
      1, 0.4 * r * r, {.pose = {.p = {L * std::sin(theta0), L * std::cos(theta0), 0}}, .name = "ball"});
  s.model.add_contact(ground, ball, sphere_on_sphere(R, r), {.mu = mu, .name = "sphere"});
  s.start = s.model.rest();

  // On the sphere y = (theta, theta', angle, spin), clockwise, a unit mass: L theta'' = g sin(theta) - f and
  // (2/5) r spin' = f with the friction f, which rolling needs to be (2/7) g sin(theta). Then y = (x, y, vx, vy, angle, spin).
  enum { Rolls, Slips, Flies };
  const auto push = [=](const Reals& y) { return g * std::cos(y[0]) - L * y[1] * y[1]; };
  const auto moves = [=](const Reals& y, Real friction, Reals& dy) {
    dy[0] = y[1];
    dy[1] = (g * std::sin(y[0]) - friction) / L;
    dy[2] = y[3];
    dy[3] = 5 * friction / (2 * Real(r));
  };
  const auto grip = [=](const Reals& y) { return mu * push(y) - 2 * g * std::sin(y[0]) / 7; };
  Stretch rolls, slips, flies;
  rolls.rate = [=](Real, const Reals& y, Reals& dy) { moves(y, 2 * g * std::sin(y[0]) / 7, dy); };
  rolls.guard = [=](Real, const Reals& y) { return grip(y); };
  rolls.next = [](Real, Reals&) { return Slips; };
  slips.rate = [=](Real, const Reals& y, Reals& dy) { moves(y, mu * push(y), dy); };
  slips.guard = [=](Real, const Reals& y) { return push(y); };
  slips.next = [=](Real, Reals& y) {
    const Real sn = std::sin(y[0]), c = std::cos(y[0]), v = L * y[1];
    y = {L * sn, L * c, v * c, -v * sn, y[2], y[3]};
    return Flies;
  };
  flies.rate = [](Real, const Reals& y, Reals& dy) { dy = {y[2], y[3], 0, -g, y[5], 0}; };
  const Reals start{theta0, 0, 0, 0};
  const ReferenceMotion motion({{Rolls, rolls}, {Slips, slips}, {Flies, flies}}, start,
                               grip(start) > 0 ? Rolls : Slips);
  s.exact = exact_by(s.model, [=](const Model& model, State& state, Real t) {
    const auto [time, y, stretch] = motion.at(t);
    if (stretch == Flies) return PlanarMotion{y[0], y[1], -y[4], y[2], y[3], -y[5]}.put(model, state, ball);
    const Real sn = std::sin(y[0]), c = std::cos(y[0]), v = L * y[1];
    PlanarMotion{L * sn, L * c, -y[2], v * c, -v * sn, -y[3]}.put(model, state, ball);
  });
  return s;
}

Scene bead_in_ring(Parameters& set) {
  const double mu = set.number("mu", 0.3, "friction coefficient [-]", not_negative);
  const double v0 = set.number("v0", 2, "initial speed [m/s]", not_negative);
  const double R = set.number("radius", 1, "of the wall [m]", positive);
  Scene s;
  s.id = "B17";
  s.what =
      "A bead runs along a circular wall without gravity: the wall's curvature alone makes it press and rub";
  s.model.set_gravity(Vector3::Zero());
  const BodyId bead = s.model.add_particle(1, {.pose = {.p = {R, 0, 0}}, .name = "bead"});
  s.model.add_contact(ground, bead, particle_in_circle(R), {.mu = mu, .name = "wall"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, bead, {0, v0, 0});

  // v' = -mu v^2/R
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Real slower = 1 + Real(mu) * v0 * t / R, v = v0 / slower;
    const Real angle = mu == 0 ? v0 * t / R : std::log(slower) / mu;
    const Real c = std::cos(angle), sn = std::sin(angle);
    ParticleMotion{{R * c, R * sn, 0}, {-v * sn, v * c, 0}}.put(model, x, bead);
  });
  return s;
}

Scene bowl(Parameters& set) {
  const double theta = set.number("theta", pi / 3, "initial place, from the lowest [rad]", acute);
  const double v0 = set.number("v0", 1, "initial horizontal velocity [m/s]");
  const double R = 1, r = 0.1;
  Scene s;
  s.id = "B21";
  s.what = "A marble without friction slides round and round in a spherical bowl";
  const Vector3 place(std::sin(theta) * R, 0, -std::cos(theta) * R);
  const BodyId marble = s.model.add_particle(1, {.pose = {.p = place}, .name = "marble"});
  s.model.add_contact(ground, marble, sphere_in_sphere(R + r, r), {.name = "bowl"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, marble, {0, v0, 0});

  // x'' = gravity - (|v|^2 + gravity . x) x/R^2; with this energy it stays below the rim
  if (v0 * v0 > 2 * g * R * std::cos(theta)) return s;
  const auto rate = [=](Real, const Reals& y, Reals& dy) {
    const RealVector3 x(y[0], y[1], y[2]), v(y[3], y[4], y[5]), fall(0, 0, -g);
    const RealVector3 a = fall - (v.squaredNorm() + fall.dot(x)) / x.squaredNorm() * x;
    dy = {v.x(), v.y(), v.z(), a.x(), a.y(), a.z()};
  };
  const ReferenceMotion motion(rate, {place.x(), 0, place.z(), 0, v0, 0});
  s.exact = exact_by(s.model, [=](const Model& model, State& state, Real t) {
    const Reals y = motion.at(t).y;
    ParticleMotion{{y[0], y[1], y[2]}, {y[3], y[4], y[5]}}.put(model, state, marble);
  });
  return s;
}

}  // namespace perp
