// Particles on planes and walls: everything that a scene without orientations can show.
#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {
namespace {

template <class Motion>
std::function<State(double)> exact_of(const Model& particles, BodyId particle, Motion motion) {
  return exact_by(particles,
                  [=](const Model& model, State& x, Real t) { motion(t).put(model, x, particle); });
}

/// A particle on the plane z = 0 of a slope: gravity leans by theta from -z towards `downhill`, a unit vector.
BodyId block_on_slope(Scene& s, double theta, const Vector3& downhill, const Vector3& v0, double mu) {
  s.model.set_gravity(g * (std::sin(theta) * downhill - std::cos(theta) * Vector3::UnitZ()));
  const BodyId block = s.model.add_particle(1, {.name = "block"});
  s.model.add_contact(ground, block, particle_on_plane(), {.mu = mu, .name = "slope"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, block, v0);
  return block;
}

}  // namespace

Scene incline_block(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double theta = set.number("theta", pi / 6, "slope [rad]", acute);
  const double v0 = set.number("v0", 0, "initial velocity, positive downhill [m/s]");
  Scene s;
  s.id = "B3";
  s.what =
      "A block on a slope slides along x, downhill; thrown uphill (v0 < 0) it stops and comes back if it can";
  const BodyId block = block_on_slope(s, theta, Vector3::UnitX(), {v0, 0, 0}, mu);

  // gravity and friction along x, as forces per mass: at most two stretches of constant acceleration
  const Real pull = s.model.gravity().x(), hold = Real(mu) * -Real(s.model.gravity().z());
  s.exact = exact_of(s.model, block, [=](Real t) {
    const Real first = v0 == 0 ? std::max<Real>(pull - hold, 0) : pull + (v0 < 0 ? hold : -hold);
    const Real stop = v0 * first < 0 ? -v0 / first : v0 == 0 && first == 0 ? 0 : infinity;
    const Real s1 = std::min(t, stop), s2 = t - s1, second = std::max<Real>(pull - hold, 0);
    return ParticleMotion{{v0 * s1 + first * s1 * s1 / 2 + second * s2 * s2 / 2, 0, 0},
                          {s2 > 0 ? second * s2 : v0 + first * s1, 0, 0}};
  });
  return s;
}

Scene cross_incline(Parameters& set) {
  const double k = set.number("k", 0.5, "friction coefficient over tan(theta) [-]", not_negative);
  const double theta = set.number("theta", pi / 6, "slope [rad]", {0, 1.57, true});
  const double v0 = set.number("v0", 2, "initial velocity along x, across the slope [m/s]", positive);
  Scene s;
  s.id = "B3b";
  s.what = "A block thrown across a slope: friction turns with the velocity from across (x) to downhill (y)";
  s.t_end = 0.4;
  const BodyId block = block_on_slope(s, theta, Vector3::UnitY(), {v0, 0, 0}, k * std::tan(theta));

  // With phi the angle of v from downhill and L = ln tan(phi/2), which falls from 0, v = v0 e^((k-1)L) (1 + e^(2L))/2, and
  // t, x, y are sums of F(p) = (1 - e^(pL))/p. L(t) is the root of a monotone function.
  const Real A = s.model.gravity().y(), K = k, V = v0;
  const auto F = [](Real p, Real L) { return p == 0 ? -L : -std::expm1(p * L) / p; };
  const auto time = [=](Real L) { return V / (2 * A) * (F(K - 1, L) + F(K + 1, L)); };
  const Real stop = k > 1 ? V * K / (A * (K * K - 1)) : infinity;
  s.exact = exact_of(s.model, block, [=](Real t) -> ParticleMotion {
    if (t >= stop)
      return {{2 * K * V * V / (A * (4 * K * K - 1)), V * V / (4 * A * (K * K - 1)), 0}, RealVector3::Zero()};
    Real L = 0;
    if (t > 0) {
      Real below = -1;
      while (time(below) < t && below > -1e4L) below *= 2;
      std::uintmax_t iterations = 200;
      const auto late = [&](Real at) { return time(at) - t; };
      if (late(below) > 0)
        below = boost::math::tools::toms748_solve(late, below, Real(0), late(below), -t,
                                                  boost::math::tools::eps_tolerance<Real>(62), iterations)
                    .first;
      L = below;
    }
    const Real v = V * std::exp((K - 1) * L) * (1 + std::exp(2 * L)) / 2;
    const Real phi = 2 * std::atan(std::exp(L));
    return {{V * V / (2 * A) * (F(2 * K - 1, L) + F(2 * K + 1, L)),
             V * V / (4 * A) * (F(2 * K - 2, L) - F(2 * K + 2, L)), 0},
            {v * std::sin(phi), v * std::cos(phi), 0}};
  });
  return s;
}

Scene bouncing_ball(Parameters& set) {
  const double e = set.number("e", 0.8, "restitution [-]", {0, 0.999});
  const double height = set.number("height", 1, "from which it falls [m]", positive);
  Scene s;
  s.id = "B4";
  s.what = "A ball bounces ever lower, infinitely often in a finite time, and lies still";
  const BodyId ball = s.model.add_particle(1, {.pose = {.p = {0, 0, height}}, .name = "ball"});
  s.model.add_contact(ground, ball, particle_on_plane(), {.e = e, .name = "floor"});
  s.start = s.model.rest();

  s.exact = exact_of(s.model, ball, [=](Real t) -> ParticleMotion {
    const Real fall = std::sqrt(2 * height / Real(g)), rest = fall * (1 + Real(e)) / (1 - Real(e));
    if (t < fall) return {{0, 0, height - g * t * t / 2}, {0, 0, -g * t}};
    if (t >= rest) return {RealVector3::Zero(), RealVector3::Zero()};
    Real since = t - fall, v = e * g * fall;  // the bounces last 2 v/g each, v falling by the factor e
    while (since >= 2 * v / g && v > 0) {
      since -= 2 * v / g;
      v *= e;
    }
    return {{0, 0, since * (v - g * since / 2)}, {0, 0, v - g * since}};
  });
  return s;
}

Scene shaker(Parameters& set) {
  const double a = set.number("amplitude", 0.1, "of the plate [m]", positive);
  const double rate = set.number("rate", 12, "of the plate [rad/s]", positive);
  Scene s;
  s.id = "B5a";
  s.what =
      "A particle on a plate that shakes up and down: lifted off, caught without a bounce, lifted off again";
  s.t_end = 0.3;
  const BodyId plate = s.model.add_prescribed(PrescribedMotion::shaker({0, 0, a}, rate), {.name = "plate"});
  const BodyId particle = s.model.add_particle(1, {.name = "particle"});
  s.model.add_contact(plate, particle, particle_on_plane(), {.name = "plate"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, particle, {0, 0, a * rate});

  // on the plate while its acceleration is above -g, else in free flight in y = (z, v) until it is down again
  const Real A = a, w = rate;
  const auto height = [=](Real t) { return A * std::sin(w * t); };
  const auto speed = [=](Real t) { return A * w * std::cos(w * t); };
  const auto weight = [=](Real t) { return g - A * w * w * std::sin(w * t); };
  enum { Carried, Flies };
  Stretch carried = still, flies;
  carried.guard = [=](Real t, const Reals&) { return weight(t); };
  carried.next = [=](Real t, Reals& y) {
    y = {height(t), speed(t)};
    return Flies;
  };
  flies.rate = [](Real, const Reals& y, Reals& dy) { dy = {y[1], -g}; };
  flies.guard = [=](Real t, const Reals& y) { return y[0] - height(t); };
  flies.next = [=](Real t, Reals& y) {
    y = {height(t), speed(t)};
    return weight(t) > 0 ? Carried : Flies;
  };
  const ReferenceMotion motion({{Carried, carried}, {Flies, flies}}, {0, A * w}, Carried, 0.1L / w);
  s.exact = exact_of(s.model, particle, [=](Real t) -> ParticleMotion {
    const ReferenceMotion::Point now = motion.at(t);
    if (now.stretch == Carried) return {{0, 0, height(t)}, {0, 0, speed(t)}};
    return {{0, 0, now.y[0]}, {0, 0, now.y[1]}};
  });
  return s;
}

Scene three_balls(Parameters& set) {
  const double e = set.number("e", 1, "restitution [-]", fraction);
  Scene s;
  s.id = "B11";
  s.what =
      "The first of three balls in touch has a velocity towards the others; Newton's law for both contacts "
      "at once";
  s.t_end = 0.5;
  s.model.set_gravity(Vector3::Zero());
  const double r = 0.5;
  const auto add = [&](const char* name, double x) {
    return s.model.add_particle(1, {.pose = {.p = {x, 0, 0}}, .name = name});
  };
  const BodyId balls[] = {add("first", -2 * r), add("second", 0), add("third", 2 * r)};
  s.model.add_contact(balls[0], balls[1], sphere_on_sphere(r, r), {.e = e, .name = "near"});
  s.model.add_contact(balls[1], balls[2], sphere_on_sphere(r, r), {.e = e, .name = "far"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, balls[0], {1, 0, 0});

  // the contacts' velocities -1 and 0 become e and 0, the sum stays: not the (0, 0, 1) of one contact after the other
  const Real after[] = {(1 - 2 * Real(e)) / 3, (1 + Real(e)) / 3, (1 + Real(e)) / 3};
  s.exact = [=, model = s.model, start = s.start](double t) {
    State x = start;
    x.t = t;
    for (int i = 0; t > 0 && i < 3; ++i)
      ParticleMotion{{2 * r * (i - 1) + after[i] * t, 0, 0}, {after[i], 0, 0}}.put(model, x, balls[i]);
    return x;
  };
  return s;
}

}  // namespace perp
