// Random starts of small scenes: whatever happens, a run ends at its time or says why it does not.
#include <cmath>
#include <random>

#include "perp/model/gaps.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

struct Start {
  Model model;
  State x;
};

/// Numbers in an interval, from a seed, the same everywhere.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double operator()(double a, double b) {
    return a + (b - a) * (static_cast<double>(random_()) / 4294967296.0);
  }
  bool coin() { return random_() % 2 == 0; }
  Vector3 vector(double size) {
    const double x = (*this)(-size, size), y = (*this)(-size, size), z = (*this)(-size, size);
    return {x, y, z};
  }

 private:
  std::mt19937 random_;
};

Start rod(Draw& draw) {
  Start s;
  s.model.set_gravity({0, -9.81, 0});
  const BodyId b = s.model.add_planar_body(1, 1.0 / 3);
  const double mu = draw(0, 2), e = draw.coin() ? 0 : draw(0, 0.9);
  for (const double end : {-1.0, 1.0})
    s.model.add_contact(ground, b, point_on_plane({end, 0, 0}, horizontal_line), {.mu = mu, .e = e});
  s.x = s.model.rest();
  const double angle = draw(-3.1, 3.1);
  s.x.q << 0, std::abs(std::sin(angle)) + (draw.coin() ? draw(0, 0.3) : 0), angle;
  s.x.nu << draw(-3, 3), draw(-3, 1), draw(-5, 5);
  return s;
}

Start two_spheres(Draw& draw) {
  Start s;
  const double mu = draw(0, 1), e = draw.coin() ? 0 : draw(0, 0.9);
  const BodyId a = s.model.add_body(Inertia::solid_sphere(1, 0.1));
  const BodyId b = s.model.add_body(Inertia::solid_sphere(draw(0.2, 5), 0.15));
  s.model.add_contact(ground, a, sphere_on_plane(0.1), {.mu = mu, .e = e});
  s.model.add_contact(ground, b, sphere_on_plane(0.15), {.mu = mu, .e = e});
  s.model.add_contact(a, b, sphere_on_sphere(0.1, 0.15), {.mu = mu, .e = e});
  s.x = s.model.rest();
  s.model.set_position(s.x, a, {0, 0, 0.1 + (draw.coin() ? draw(0, 0.2) : 0)});
  s.model.set_position(s.x, b, {draw(0.26, 0.5), draw(-0.2, 0.2), 0.15 + draw(0, 0.2)});
  s.model.set_velocity(s.x, a, draw.vector(2), draw.vector(8));
  s.model.set_velocity(s.x, b, draw.vector(2), draw.vector(8));
  return s;
}

Start ellipsoid(Draw& draw) {
  Start s;
  const Vector3 axes(0.2, 0.15, 0.1);
  const BodyId b = s.model.add_body(Inertia::solid_ellipsoid(1, axes));
  s.model.add_contact(ground, b, ellipsoid_on_plane(axes),
                      {.mu = draw(0, 1), .e = draw.coin() ? 0 : draw(0, 0.9)});
  s.x = s.model.rest();
  s.model.set_orientation(s.x, b, rotation(draw.vector(3)));
  s.model.set_position(s.x, b, {0, 0, 0.2 + draw(0, 0.2)});
  s.model.set_velocity(s.x, b, draw.vector(2), draw.vector(8));
  return s;
}

/// A run of a second: no NaN, no energy from nowhere, an end that is reached or explained. Whether it was reached.
bool runs_well(const Start& start) {
  EventDriven stepper({.rtol = 1e-8, .max_evaluations = 300'000});
  Trajectory run;
  bool reached = true;
  try {
    run = simulate(start.model, stepper, start.x, {.t_end = 1});
  } catch (const StepFailure& failure) {
    CHECK_FALSE(failure.report.message.empty());
    run = failure.trajectory;
    reached = false;
  }
  double energy = start.model.energy(start.x);
  const double scale = std::max(1.0, std::abs(energy));
  for (std::size_t i = 0; i < run.steps(); ++i) {
    REQUIRE(run.state(i + 1).q.allFinite());
    REQUIRE(run.state(i + 1).nu.allFinite());
    CHECK(run.figures(i).energy <= energy + 1e-5 * scale);
    energy = run.figures(i).energy;
  }
  return reached;
}

void random_starts(int count) {
  int reached = 0;
  for (int i = 0; i < count; ++i)
    for (Start (*make)(Draw&) : {rod, two_spheres, ellipsoid}) {
      Draw draw(static_cast<unsigned>(i + 1));
      CAPTURE(i);
      reached += runs_well(make(draw)) ? 1 : 0;
    }
  CHECK(reached >= 3 * count * 95 / 100);
}

}  // namespace

TEST_CASE("Runs from random starts end, or say why they do not, and gain no energy", "[event]") {
  if (has_sundials()) random_starts(20);
}

TEST_CASE("Runs from many random starts end, or say why they do not, and gain no energy", "[event][slow]") {
  if (has_sundials()) random_starts(1000);
}

}  // namespace perp
