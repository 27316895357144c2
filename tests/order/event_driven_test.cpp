// The event-driven method against every scene whose motion is known.
#include "perp/step/event_driven.hpp"

#include <algorithm>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/error_measure.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

struct Case {
  const char* scene;
  SceneParameters set;
  double until;
};

Trajectory run_of(const Scene& s, double tolerance, Integrator integrator, double until) {
  EventDriven stepper({.rtol = tolerance, .integrator = integrator});
  return simulate(s.model, stepper, s.start, {.t_end = until});
}

/// The largest error over all rows but those at events, where the exact motion is just after and a row may be just before.
double worst_error(const Scene& s, const Trajectory& run) {
  double worst = 0;
  for (std::size_t i = 0; i < run.size(); ++i)
    worst = std::max(worst, configuration_error(s.model, run.state(i), s.exact(run.t(i))));
  return worst;
}

}  // namespace

TEST_CASE("event reaches 1e-10 in configuration on every scene of known motion at tolerance 1e-12",
          "[event]") {
  if (!has_sundials()) return;
  const Case c =
      GENERATE(Case{"seed-sphere", {}, 0.6}, Case{"oblique-sphere", {}, 2}, Case{"incline-block", {}, 1},
               Case{"incline-block", {{"v0", -2}}, 1}, Case{"cross-incline", {{"k", 0.5}}, 0.4},
               Case{"cross-incline", {{"k", 1}}, 0.4}, Case{"cross-incline", {{"k", 1.5}}, 0.6},
               Case{"bouncing-ball", {{"e", 0.5}}, 1}, Case{"bouncing-ball", {{"e", 0.8}}, 1},
               Case{"bouncing-ball", {{"e", 0.9}}, 1}, Case{"shaker", {}, 1}, Case{"turntable", {}, 5},
               Case{"roller-in-cylinder", {}, 1}, Case{"ball-on-sphere", {}, 1.5},
               Case{"friction-pendulum", {}, 12}, Case{"spring-block", {}, 5}, Case{"three-balls", {}, 0.5},
               Case{"dzhanibekov", {}, 5}, Case{"heavy-top", {}, 0.3}, Case{"double-pendulum", {}, 3},
               Case{"slider-crank", {}, 1.3}, Case{"bead-in-ring", {}, 1}, Case{"rocking-block", {}, 1.5},
               Case{"bowl", {}, 1}, Case{"painleve-rod", {}, 0.3}, Case{"four-bar", {}, 0.3},
               Case{"bennett", {}, 0.3}, Case{"sliding-cube", {}, 1.5}, Case{"creep", {}, 1});
  CAPTURE(c.scene, c.set);
  const Scene s = scene(c.scene, c.set);
  const Trajectory run = run_of(s, 1e-12, Integrator::Arkode, c.until);
  CHECK(run.back().t == c.until);
  CHECK(worst_error(s, run) < 1e-10);
  for (std::size_t i = 0; i < run.steps(); ++i) {
    CHECK(run.figures(i).gap_min > -1e-12);
    CHECK(run.figures(i).joint_error < 1e-12);
  }
}

TEST_CASE("IDA and ARKODE agree to 1e-9 where they share no elimination", "[event]") {
  if (!has_sundials()) return;
  const Case c = GENERATE(Case{"heavy-top", {}, 0.3}, Case{"double-pendulum", {}, 1},
                          Case{"slider-crank", {}, 0.3}, Case{"bowl", {}, 1});
  CAPTURE(c.scene);
  const Scene s = scene(c.scene, c.set);
  const State a = run_of(s, 1e-12, Integrator::Arkode, c.until).back();
  const State b = run_of(s, 1e-12, Integrator::Ida, c.until).back();
  CHECK(configuration_error(s.model, a, b) < 1e-9);
}

TEST_CASE("Adams and BDF come to the exact motion too", "[event]") {
  if (!has_sundials()) return;
  const Integrator integrator = GENERATE(Integrator::CvodeAdams, Integrator::CvodeBdf, Integrator::Ida);
  const Case c =
      GENERATE(Case{"seed-sphere", {}, 0.6}, Case{"cross-incline", {{"k", 1.5}}, 0.6}, Case{"shaker", {}, 1},
               Case{"ball-on-sphere", {}, 1.5}, Case{"rocking-block", {}, 0.6});
  CAPTURE(c.scene, name_of(integrator));
  const Scene s = scene(c.scene, c.set);
  CHECK(worst_error(s, run_of(s, 1e-12, integrator, c.until)) < 5e-9);
}

TEST_CASE("Event times are exact to 1e-10", "[event]") {
  if (!has_sundials()) return;
  struct Times {
    const char* scene;
    SceneParameters set;
    double until;
    std::vector<double> t;
  };
  const Times c = GENERATE(
      Times{"seed-sphere", {}, 0.6, {0.291247997670016019}},
      Times{"oblique-sphere", {}, 1, {0.651250321100856181}},
      Times{"incline-block", {{"v0", -2}}, 1, {0.21851106416401444}},
      Times{"cross-incline", {{"k", 1.5}}, 0.6, {0.489296636085626911}},
      Times{"bouncing-ball", {{"e", 0.8}}, 1.2, {0.451523640985730904, 1.17396146656290035}},
      Times{"shaker", {}, 0.6, {0.0624557343869608896, 0.351693536744083536, 0.586054509985259763}},
      Times{"ball-on-sphere", {}, 1.5, {1.16953241866, 1.21841190252}},
      Times{"friction-pendulum",
            {},
            12,
            {1.09175148829423, 2.16402878121614, 3.22031877399045, 4.26345249925988, 5.29579763390132,
             6.31938732151865, 7.33601038924429, 8.34727727028209, 9.35467026893212, 10.3595836662653,
             11.3633573740884}},
      Times{"spring-block", {}, 4, {M_PI / 5, 2 * M_PI / 5, 3 * M_PI / 5, 4 * M_PI / 5, M_PI, 6 * M_PI / 5}},
      Times{"slider-crank", {}, 1.3, {1.18674812085396}},
      Times{"rocking-block", {}, 0.5, {0.4938032150788319}});
  CAPTURE(c.scene);
  const Scene s = scene(c.scene, c.set);
  const Trajectory run = run_of(s, 1e-12, Integrator::Arkode, c.until);
  std::vector<double> found;
  for (const Event& e : run.events)
    if (found.empty() || e.t > found.back() + 1e-9) found.push_back(e.t);
  REQUIRE(found.size() == c.t.size());
  for (std::size_t i = 0; i < c.t.size(); ++i) CHECK(std::abs(found[i] - c.t[i]) < 1e-10);
}

TEST_CASE("The state between rows is as exact as the rows", "[event]") {
  if (!has_sundials()) return;
  const Case c =
      GENERATE(Case{"seed-sphere", {}, 0.6}, Case{"cross-incline", {{"k", 1.5}}, 0.6},
               Case{"bouncing-ball", {}, 2}, Case{"double-pendulum", {}, 1}, Case{"rocking-block", {}, 1.5});
  CAPTURE(c.scene);
  const Scene s = scene(c.scene, c.set);
  const Trajectory run = run_of(s, 1e-12, Integrator::Arkode, c.until);
  for (int i = 0; i <= 97; ++i) {
    const double t = c.until * i / 97;
    const State x = run.at(t), exact = s.exact(t);
    CHECK(x.t == t);
    CHECK(configuration_error(s.model, x, exact) < 1e-10);
    CHECK(velocity_error(s.model, x, exact) < 1e-9);
  }
  CHECK_THROWS_AS(run.at(c.until + 0.1), std::invalid_argument);
}

TEST_CASE("The error follows the tolerance", "[event]") {
  if (!has_sundials()) return;
  const Case c =
      GENERATE(Case{"oblique-sphere", {}, 2}, Case{"cross-incline", {{"k", 1.5}}, 0.6},
               Case{"ball-on-sphere", {}, 1.5}, Case{"dzhanibekov", {}, 5}, Case{"friction-pendulum", {}, 5});
  CAPTURE(c.scene);
  const Scene s = scene(c.scene, c.set);
  const State exact = s.exact(c.until);
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    CAPTURE(tolerance);
    const Trajectory run = run_of(s, tolerance, Integrator::Arkode, c.until);
    CHECK(configuration_error(s.model, run.back(), exact) < 100 * tolerance);
  }
  // and steps are not smaller than it asks
  CHECK(run_of(s, 1e-4, Integrator::Arkode, c.until).evaluations <
        run_of(s, 1e-12, Integrator::Arkode, c.until).evaluations);
}

TEST_CASE("The seed's sphere needs at most 500 evaluations to 1e-12", "[event]") {
  if (!has_sundials()) return;
  const Scene s = scene("seed-sphere");
  const Trajectory run = run_of(s, 1e-12, Integrator::Arkode, 0.6);
  CHECK(worst_error(s, run) < 1e-12);
  CHECK(run.evaluations <= 500);
}

TEST_CASE("A rolling ellipse is where its equation of motion says", "[event]") {
  if (!has_sundials()) return;
  Model model;
  model.set_gravity({0, -9.81, 0});
  const double a = 1, b = 0.5, phi = 0.6;
  const BodyId ellipse = model.add_planar_body(1, (a * a + b * b) / 4);
  model.add_contact(ground, ellipse, ellipse_on_line(a, b), {.mu = 50});
  State x = model.rest();
  x.q << 0, std::hypot(a * std::sin(phi), b * std::cos(phi)), phi;
  EventDriven stepper({.rtol = 1e-12});
  const Trajectory run = simulate(model, stepper, x, {.t_end = 0.5});
  CHECK(std::abs(run.back().q[2] + 0.06481332802093094) < 1e-12);
  CHECK(std::abs(run.at(0.3).q[2] - 0.3790900963453028) < 1e-12);
}

TEST_CASE("A rattleback turns back when its equations of motion say", "[event]") {
  if (!has_sundials()) return;
  struct Turn {
    double spin, reversal;
    double rate[4];  // about the upright, at these times:
  };
  const double times[] = {0.5, 1, 2, 5};
  for (const Turn& turn :
       {Turn{-5, 2.747880658295, {-4.49072160949, -2.86575629421, -1.31292559588, 4.475203749163}},
        Turn{5, 10.85765563292, {5.34907801195, 5.33396678052, 5.17505251132, 4.16817238438}}}) {
    const Scene s = scene("rattleback", {{"spin", turn.spin}, {"mu", 50}});
    const Trajectory run = run_of(s, 1e-12, Integrator::Arkode, std::max(5.0, turn.reversal + 0.01));
    const auto rate = [&](double t) { return s.model.angular_velocity(run.at(t), {1}).z(); };
    for (int i = 0; i < 4; ++i) CHECK(std::abs(rate(times[i]) - turn.rate[i]) < 1e-8);
    // it goes through zero there, for the first time
    CHECK(rate(turn.reversal - 1e-8) * turn.spin > 0);
    CHECK(rate(turn.reversal + 1e-8) * turn.spin < 0);
    for (std::size_t i = 0; i < run.size(); ++i)
      if (run.t(i) < turn.reversal) REQUIRE(s.model.angular_velocity(run.state(i), {1}).z() * turn.spin > 0);
    CHECK(std::abs(s.model.energy(run.back()) - s.model.energy(s.start)) < 1e-12);
  }
}

namespace {

void joints_stay_closed(const char* name, Integrator integrator, double tolerance) {
  CAPTURE(name, name_of(integrator));
  const Scene s = scene(name);
  const Trajectory run = run_of(s, tolerance, integrator, 100);
  CHECK(run.back().t == 100);
  double worst = 0;
  for (std::size_t i = 0; i < run.steps(); ++i) worst = std::max(worst, run.figures(i).joint_error);
  CHECK(worst < 1e-12);
}

}  // namespace

TEST_CASE("Joints are closed to 1e-12 throughout 100 s", "[event]") {
  if (!has_sundials()) return;
  joints_stay_closed("double-pendulum", Integrator::Arkode, 1e-8);
  joints_stay_closed("slider-crank", Integrator::Arkode, 1e-8);
  joints_stay_closed("slider-crank", Integrator::Ida, 1e-8);
}

TEST_CASE("Joints are closed to 1e-12 throughout 100 s under IDA and in loops of redundant joints",
          "[event][slow]") {
  if (!has_sundials()) return;
  for (const Integrator integrator : {Integrator::Arkode, Integrator::Ida})
    for (const char* name : {"four-bar", "double-pendulum", "heavy-top"})
      joints_stay_closed(name, integrator, 1e-6);
}

namespace {

struct Throw {
  Model model;
  State x;
};

/// A brick that falls on its lower edge, or with `roll` on its lowest corner.
Throw thrown_box(double roll) {
  Throw t;
  const Vector3 size(0.3, 0.2, 0.1);
  const BodyId box = t.model.add_body(Inertia::solid_box(1, size));
  t.model.add_contact(ground, box, box_on_plane(size), {.mu = 0.3});
  t.x = t.model.rest();
  const Quaternion q = rotation({0, 0.5, 0}) * rotation({roll, 0, 0});
  double lowest = 0;
  for (int i = 0; i < 8; ++i) {
    const Vector3 corner(i & 1 ? 0.15 : -0.15, i & 2 ? 0.1 : -0.1, i & 4 ? 0.05 : -0.05);
    lowest = std::min(lowest, (q * corner).z());
  }
  t.model.set_orientation(t.x, box, q);
  t.model.set_position(t.x, box, {0, 0, 0.05 - lowest});
  t.model.set_velocity(t.x, box, {1, 0.4, -0.5});
  return t;
}

}  // namespace

TEST_CASE("A box thrown on an edge goes the same way under ARKODE and IDA, through ten changes of mode",
          "[event]") {
  if (!has_sundials()) return;
  const Throw t = thrown_box(0);
  std::vector<Trajectory> runs;
  for (const EventDrivenOptions& options :
       {EventDrivenOptions{.rtol = 1e-12}, EventDrivenOptions{.rtol = 1e-12, .integrator = Integrator::Ida},
        EventDrivenOptions{.rtol = 1e-13}}) {
    EventDriven stepper(options);
    runs.push_back(simulate(t.model, stepper, t.x, {.t_end = 0.4}));
    double energy = t.model.energy(t.x);
    for (std::size_t i = 0; i < runs.back().steps(); ++i) {
      CHECK(runs.back().figures(i).energy <= energy + 1e-11);
      energy = runs.back().figures(i).energy;
    }
  }
  // it lands on two corners, falls over on all four, slides and turns, sticks; four corners are more than determine forces
  for (const Trajectory& run : runs) {
    REQUIRE(run.events.size() == 10);
    for (std::size_t i = 0; i < 10; ++i) {
      CHECK(run.events[i].kind == runs[0].events[i].kind);
      CHECK(run.events[i].contact == runs[0].events[i].contact);
      CHECK(std::abs(run.events[i].t - runs[0].events[i].t) < 1e-9);
    }
    for (const double time : {0.1, 0.2, 0.3, 0.4})
      CHECK(configuration_error(t.model, run.at(time), runs[0].at(time)) < 5e-9);
  }
  CHECK(runs[0].back().nu.norm() < 1e-12);
}

TEST_CASE("ncp2 tends to the event-driven motion of a box thrown on a corner at the order of impacts",
          "[event]") {
  if (!has_sundials()) return;
  const Throw t = thrown_box(0.2);
  constexpr double until = 0.137;  // corners hit and lift in turn
  EventDriven arkode({.rtol = 1e-12}), ida({.rtol = 1e-12, .integrator = Integrator::Ida});
  const Trajectory run = simulate(t.model, arkode, t.x, {.t_end = until});
  CHECK(run.events.size() >= 4);
  CHECK(configuration_error(t.model, simulate(t.model, ida, t.x, {.t_end = until}).back(), run.back()) <
        1e-9);
  double x = 0, y = 0, xx = 0, xy = 0;
  int levels = 0;
  for (int n = 50; n <= 1600; n *= 2, ++levels) {
    double error = 0;  // the largest of some step counts: where in a step an impact falls is chance
    for (int k = 0; k < 6; ++k) {
      Ncp2Stepper ncp2;
      const Trajectory steps = simulate(t.model, ncp2, t.x, {.t_end = until, .h = until / (n + k * n / 24)});
      error = std::max(error, configuration_error(t.model, steps.back(), run.back()));
    }
    const double log_h = -std::log(n), log_error = std::log(error);
    x += log_h, y += log_error, xx += log_h * log_h, xy += log_h * log_error;
  }
  const double order = (levels * xy - x * y) / (levels * xx - x * x);
  CHECK(order > 0.8);
  CHECK(order < 1.3);
}

}  // namespace perp
