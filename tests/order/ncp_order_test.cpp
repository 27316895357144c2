// Orders of convergence of the nonlinear steps, two-sided, on motions that are known.
#include <catch2/catch.hpp>

#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "tests/order/ladder.hpp"

namespace perp {
namespace {

/// Six steps and a factor of 32 for every scene: T/80 ... T/2560.
const std::vector<int>& counts() {
  static const std::vector<int> list = ladder(80, 6);
  return list;
}

enum class Measure { Configuration, Position };

/// What a fit is made of: one run a level, or the largest error of sixteen whose steps spread over [n, 1.25 n], where a switch
/// falls at a random fraction of a step.
struct Fit {
  int envelope = 1;
  Measure measure = Measure::Configuration;
};
constexpr Fit smooth{}, switches{16};

double error(const Scene& s, const State& x, const State& exact, Measure measure) {
  if (measure == Measure::Configuration) return distance(s.model, x, exact);
  double largest = 0;
  for (const Body& b : s.model.bodies())
    if (b.nv > 0) largest = std::max(largest, (x.q - exact.q).segment<3>(b.q0).lpNorm<Eigen::Infinity>());
  return largest;
}

/// Order at T (the scene's own if not set) against the exact motion.
double observed(Stepper& stepper, const char* name, const Fit& fit, const SceneParameters& set = {},
                double T = not_set) {
  const Scene s = scene(name, set);
  if (std::isnan(T)) T = s.t_end;
  const State exact = s.exact(T);
  std::vector<double> list;
  for (const int n : counts()) {
    double largest = 0;
    for (int i = 0; i < fit.envelope; ++i) {
      const int steps =
          n + (fit.envelope > 1 ? static_cast<int>(std::lround(0.25 * n * i / (fit.envelope - 1))) : 0);
      largest = std::max(largest, error(s, run(s, stepper, T, steps), exact, fit.measure));
    }
    list.push_back(largest);
  }
  return order_of(counts(), list);
}

auto order(double p) { return Approx(p).margin(0.1); }

}  // namespace

TEST_CASE("the fully implicit step has order 1 in smooth motion", "[order]") {
  NcpStepper ncp;
  CHECK(observed(ncp, "roller-in-cylinder", smooth) == order(1));
  CHECK(observed(ncp, "rolling-ellipse", smooth) == order(1));
  CHECK(observed(ncp, "bowl", smooth) == order(1));
  CHECK(observed(ncp, "dzhanibekov", smooth) == order(1));
  CHECK(observed(ncp, "double-pendulum", smooth) == order(1));
  CHECK(observed(ncp, "turntable", smooth) == order(1));
}

TEST_CASE("the fully implicit step has order 1 where friction turns, with exact cones", "[order]") {
  NcpStepper ncp;
  CHECK(observed(ncp, "seed-sphere", switches) == order(1));
  CHECK(observed(ncp, "oblique-sphere", switches) == order(1));
  CHECK(observed(ncp, "oblique-sphere", switches, {{"heading", 1}}) == order(1));
  CHECK(observed(ncp, "cross-incline", smooth) == order(1));
  CHECK(observed(ncp, "cross-incline", switches, {{"k", 1.5}}, 0.6) == order(1));
}

TEST_CASE("on a circular wall directions at the end cost an order, those at the start do not", "[order]") {
  NcpStepper end, start({.directions = Directions::Start});
  CHECK(observed(end, "bead-in-ring", smooth) == order(1));
  CHECK(observed(start, "bead-in-ring", smooth) == order(2));
  CHECK(observed(start, "roller-in-cylinder", smooth) == order(1));
}

TEST_CASE("the second-order step has order 2 in smooth motion", "[order]") {
  Ncp2Stepper ncp2;
  CHECK(observed(ncp2, "roller-in-cylinder", smooth) == order(2));
  CHECK(observed(ncp2, "rolling-ellipse", smooth) == order(2));
  CHECK(observed(ncp2, "bead-in-ring", smooth) == order(2));
  CHECK(observed(ncp2, "bowl", smooth) == order(2));
  CHECK(observed(ncp2, "dzhanibekov", smooth) == order(2));
  CHECK(observed(ncp2, "double-pendulum", smooth) == order(2));
  CHECK(observed(ncp2, "turntable", smooth) == order(2));
  CHECK(observed(ncp2, "rattleback", smooth, {}, 0.25) == order(2));
}

TEST_CASE("springs, dampers and motors of joints leave the second-order step its order", "[order]") {
  const bool with_a_spring = GENERATE(false, true), motor = GENERATE(false, true);
  const double k = 40, c = 1.5, J = 0.5;
  Scene s;
  s.model.set_gravity(Vector3::Zero());
  const BodyId wheel = s.model.add_planar_body(1, J, {.name = "wheel"});
  const JointId axle = s.model.add_joint(revolute(ground, wheel));
  if (motor)
    s.model.add_motor({.joint = axle, .effort = [=](const Model&, const State&, double angle, double rate) {
                         return -k * angle - c * rate;
                       }});
  else
    s.model.add_joint_spring({.joint = axle, .stiffness = k, .damping = c});
  if (with_a_spring)
    s.model.add_spring({.a = ground, .b = wheel, .stiffness = 3});  // centre to centre: no force
  s.start = s.model.rest();
  s.model.set_velocity(s.start, wheel, Vector3::Zero(), {0, 0, 5});
  const double T = 1, d = c / (2 * J), w = std::sqrt(k / J - d * d);
  State exact = s.start;
  exact.q[2] = 5 / w * std::exp(-d * T) * std::sin(w * T);
  Ncp2Stepper ncp2;
  CAPTURE(with_a_spring, motor);
  CHECK(order_of(counts(), errors(s, ncp2, T, exact, counts())) == order(2));
}

TEST_CASE("the second-order step has order 2 where friction turns and through the end of slip", "[order]") {
  Ncp2Stepper ncp2;
  CHECK(observed(ncp2, "seed-sphere", {16, Measure::Position}) == Approx(2).margin(0.15));  // sixteen are few
  CHECK(observed(ncp2, "oblique-sphere", switches) == order(2));
  CHECK(observed(ncp2, "oblique-sphere", switches, {{"heading", 1}}) == order(2));
  CHECK(observed(ncp2, "cross-incline", smooth) == order(2));
  CHECK(observed(ncp2, "cross-incline", smooth, {{"k", 1}}) == order(2));
  CHECK(observed(ncp2, "cross-incline", switches, {{"k", 1.5}}, 0.6) == order(2));
  CHECK(observed(ncp2, "friction-pendulum", switches) == order(2));
}

TEST_CASE(
    "where a shaken plate throws a particle off and catches it the nonlinear steps have order 2 in its place",
    "[order]") {
  NcpStepper ncp;
  Ncp2Stepper ncp2;
  for (Stepper* s : {static_cast<Stepper*>(&ncp), static_cast<Stepper*>(&ncp2)}) {
    CHECK(observed(*s, "shaker", switches) == order(2));
    CHECK(observed(*s, "shaker", switches, {}, 0.8) == order(2));  // past the landing
  }
}

TEST_CASE("across impacts that throw back the nonlinear steps have order 1", "[order]") {
  NcpStepper ncp;
  Ncp2Stepper ncp2;
  for (Stepper* s : {static_cast<Stepper*>(&ncp), static_cast<Stepper*>(&ncp2)}) {
    CHECK(observed(*s, "rocking-block", switches) == order(1));
    CHECK(observed(*s, "bouncing-ball", switches) == order(1));
  }
}

}  // namespace perp
