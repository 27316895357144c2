// Friction that twists and rolls: a sphere that spins in place, a wheel that coasts to rest.
#include <algorithm>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {

Scene spun_sphere(Parameters& set) {
  const double gamma = set.number("torsion", 0.02, "of the contact [m]", positive);
  const double mu = set.number("mu", 0.3, "friction coefficient [-]", not_negative);
  const double spin = set.number("spin", 30, "initial rate about the upright [rad/s]");
  const double R = 0.1;
  Scene s;
  s.id = "B10";
  s.what =
      "A sphere that spins in place is stopped by the contact's torsional friction, after (2/5) R² w/(gamma "
      "g)";
  s.t_end = 0.5;
  const BodyId ball =
      s.model.add_body(Inertia::solid_sphere(1, R), {.pose = {.p = {0, 0, R}}, .name = "ball"});
  s.model.add_contact(ground, ball, sphere_on_plane(R), {.mu = mu, .torsion = gamma, .name = "floor"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, ball, Vector3::Zero(), {0, 0, spin});

  const Real slowing = gamma * g / (Real(2) / 5 * Real(R) * Real(R)), rate = spin;  // [rad/s²]
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Real spins = std::min(t, std::abs(rate) / slowing), lost = std::copysign(slowing * spins, rate);
    const Real half = (rate - lost / 2) * spins / 2;
    model.set_orientation(x, ball, Quaternion(double(std::cos(half)), 0, 0, double(std::sin(half))));
    model.set_velocity(x, ball, Vector3::Zero(), {0, 0, double(rate - lost)});
  });
  return s;
}

namespace {

/// A wheel of radius R on a slope, x downhill: rolling friction slows it by `resists` until it stands, whence it stays or,
/// where the slope pulls harder, rolls down.
struct CoastingWheel {
  Real R, v0, pulls, resists;

  Real slowing() const { return pulls - std::copysign(resists, v0); }  // [m/s²] while it goes as it began
  Real stands_at() const { return v0 * slowing() < 0 ? -v0 / slowing() : v0 == 0 ? 0 : infinity; }
  Real after() const { return std::max(pulls - resists, Real(0)); }

  PlanarMotion at(Real t) const {
    const Real first = std::min(t, stands_at()), then = t - first;
    const Real x = v0 * first + slowing() * first * first / 2 + after() * then * then / 2;
    const Real v = then > 0 ? after() * then : v0 + slowing() * first;
    return {x, R, -x / R, v, 0, -v / R};
  }
};

}  // namespace

Scene coasting_wheel(Parameters& set) {
  const double rho = set.number("rolling", 0.01, "of the contact [m]", not_negative);
  const double slope = set.number("slope", 0, "[rad]", {0, 1.5});
  const double v0 = set.number("v0", 1, "initial velocity, downhill [m/s]");
  const double mu = set.number("mu", 0.8, "friction coefficient [-]", not_negative);
  const double R = 0.2, m = 1, J = m * R * R / 2;
  Scene s;
  s.id = "B10b";
  s.what =
      "A wheel coasts to rest by rolling friction, and stays on a slope with tan(slope) <= rolling/R, or "
      "rolls down";
  s.t_end = 2.5;
  s.model.set_gravity(g * Vector3(std::sin(slope), -std::cos(slope), 0));
  const BodyId wheel = s.model.add_planar_body(m, J, {.pose = {.p = {0, R, 0}}, .name = "wheel"});
  s.model.add_contact(ground, wheel, disc_on_line(R), {.mu = mu, .rolling = rho, .name = "road"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, wheel, {v0, 0, 0}, {0, 0, -v0 / R});

  const Real down = Real(g) * std::sin(Real(slope)), press = Real(g) * std::cos(Real(slope));
  const CoastingWheel motion{R, v0, 2 * down / 3, 2 * Real(rho) / R * press / 3};
  // friction that the rolling needs: it never slides
  const Real needed = std::max({std::abs(down - motion.slowing()), std::abs(down - motion.after()), down});
  if (!(needed <= mu * press)) return s;
  s.exact =
      exact_by(s.model, [=](const Model& model, State& x, Real t) { motion.at(t).put(model, x, wheel); });
  return s;
}

}  // namespace perp
