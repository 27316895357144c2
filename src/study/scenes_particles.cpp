// Particles on planes and walls: everything that a scene without orientations can show.
#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// exact() of a scene with one particle: where it is and how it moves, in extended precision.
struct ParticleMotion {
  RealVector3 x, v;
};

template <class Motion>
std::function<State(double)> exact_of(const Model& model, BodyId particle, Motion motion) {
  return [=](double t) {
    State state = model.rest();
    state.t = t;
    const ParticleMotion now = motion(Real(t));
    model.set_position(state, particle, now.x.template cast<double>());
    model.set_velocity(state, particle, now.v.template cast<double>());
    return state;
  };
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
  const Stretch carried{.rate = [](Real, const Reals&, Reals&) {},
                        .guard = [=](Real t, const Reals&) { return weight(t); },
                        .next =
                            [=](Real t, Reals& y) {
                              y = {height(t), speed(t)};
                              return 1;
                            }};
  const Stretch flying{.rate =
                           [](Real, const Reals& y, Reals& dy) {
                             dy[0] = y[1];
                             dy[1] = -g;
                           },
                       .guard = [=](Real t, const Reals& y) { return y[0] - height(t); },
                       .next =
                           [=](Real t, Reals& y) {
                             y = {height(t), speed(t)};
                             return weight(t) > 0 ? 0 : 1;
                           }};
  const ReferenceMotion motion({carried, flying}, {0, A * w}, 0, 0.1L / w);
  s.exact = exact_of(s.model, particle, [=](Real t) -> ParticleMotion {
    const ReferenceMotion::Point now = motion.at(static_cast<double>(t));
    if (now.stretch == 0) return {{0, 0, height(t)}, {0, 0, speed(t)}};
    return {{0, 0, now.y[0]}, {0, 0, now.y[1]}};
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
  s.exact = exact_of(s.model, bead, [=](Real t) {
    const Real slower = 1 + Real(mu) * v0 * t / R, v = v0 / slower;
    const Real angle = mu == 0 ? v0 * t / R : std::log(slower) / mu;
    const Real c = std::cos(angle), sn = std::sin(angle);
    return ParticleMotion{{R * c, R * sn, 0}, {-v * sn, v * c, 0}};
  });
  return s;
}

}  // namespace perp
