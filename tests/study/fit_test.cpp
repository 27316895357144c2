// Parameters found again from motions made by another method, with noise.
#include "perp/study/fit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <tuple>

#include "perp/model/gaps.hpp"
#include "study/derivative_free.hpp"
#include "study/fit_intervals.hpp"
#include "study/fit_runs.hpp"
#include "study/least_squares.hpp"
#include "tests/study/measured_motion.hpp"

using namespace perp;

namespace {

/// A ball thrown onto the floor: slips in its first impact, bounces, rolls.
Scene thrown_ball(const SceneParameters& set) {
  const auto get = [&](const char* name, double otherwise) {
    const auto found = set.find(name);
    return found == set.end() ? otherwise : found->second;
  };
  Scene s;
  s.name = "thrown-ball";
  s.t_end = 0.8;
  const double mu = get("mu", 0.15), e = get("e", 0.6);
  s.parameters = {{"mu", mu, ""}, {"e", e, ""}};
  const BodyId ball = s.model.add_body(Inertia::solid_sphere(0.2, 0.05), {.name = "ball"});
  s.model.add_contact(ground, ball, sphere_on_plane(0.05), {.mu = mu, .e = e, .name = "floor"});
  s.start = s.model.rest();
  s.model.set_position(s.start, ball, {0, 0, 0.5});
  s.model.set_velocity(s.start, ball, {3, 0.5, -1}, {0, -20, 5});
  return s;
}

/// A planar rod on a hinge; `k` and `m` enter as a spring and a mass on a line of their own in other scenes.
Scene pendulum(const SceneParameters& set) {
  const auto get = [&](const char* name, double otherwise) {
    const auto found = set.find(name);
    return found == set.end() ? otherwise : found->second;
  };
  Scene s;
  s.name = "pendulum";
  s.t_end = 6;
  const double friction = get("friction", 0.05), damping = get("damping", 0.02), angle = 1.2, l = 0.5, m = 1;
  s.parameters = {{"friction", friction, ""}, {"damping", damping, ""}};
  s.model.set_gravity({0, -9.81, 0});
  const BodyId rod =
      s.model.add_planar_body(m, m * l * l / 12, {.pose = {.p = {0, -l / 2, 0}}, .name = "rod"});
  const JointId hinge = s.model.add_joint(
      revolute(ground, rod, {.point = {0, 0, 0}, .axis = {0, 0, 1}, .friction = friction, .name = "hinge"}));
  s.model.add_joint_spring({.joint = hinge, .stiffness = 0, .damping = damping});
  s.start = s.model.rest();
  s.model.set_position(s.start, rod, {l / 2 * std::sin(angle), -l / 2 * std::cos(angle), 0});
  s.start.q[2] = angle;
  return s;
}

/// A mass on a spring without gravity: only k/m shows.
Scene oscillator(const SceneParameters& set) {
  const auto get = [&](const char* name, double otherwise) {
    const auto found = set.find(name);
    return found == set.end() ? otherwise : found->second;
  };
  Scene s;
  s.name = "oscillator";
  s.t_end = 1;
  const double m = get("m", 2), k = get("k", 80), x0 = get("x0", 0.1);
  s.parameters = {{"m", m, ""}, {"k", k, ""}, {"x0", x0, ""}};
  s.model.set_gravity(Vector3::Zero());
  const BodyId mass = s.model.add_particle(m, {.name = "mass"});
  s.model.add_spring({.a = ground, .b = mass, .stiffness = k, .damping = 0, .length = 0});
  s.start = s.model.rest();
  s.model.set_position(s.start, mass, {x0, 0, 0});
  return s;
}

FitProblem ball_problem(unsigned seed) {
  const Scene truth = thrown_ball({});
  const Camera camera{.offset = 0.013, .seed = seed};
  return {.scene = thrown_ball,
          .measured = {measured(truth, truth.start, 0.6, camera, {"x", "y", "z", "qw", "qx", "qy", "qz"})},
          .free = {{.name = "mu"}, {.name = "e"}, {.name = "ball.start"}},
          .set = {{"mu", 0.45}, {"e", 0.2}},
          .seed = seed,
          .jobs = 2};
}

bool holds(const FittedValue& v, double truth) { return v.identifiable && v.low <= truth && truth <= v.high; }

/// Fits seeds 1 ... n of the ball and counts.
struct Coverage {
  int mu = 0, e = 0;
  double width_mu = 0, width_e = 0, spread_mu = 0, spread_e = 0;
};
Coverage coverage(unsigned n) {
  Coverage c;
  std::vector<double> mus, es;
  for (unsigned seed = 1; seed <= n; ++seed) {
    const FitResult result = fit(ball_problem(seed));
    CAPTURE(seed, result.message);
    REQUIRE(result.fitted());
    const FittedValue &mu = value_of(result, "mu"), &e = value_of(result, "e");
    c.mu += holds(mu, 0.15), c.e += holds(e, 0.6);
    for (const auto& [v, width, values] :
         {std::tuple(&mu, &c.width_mu, &mus), std::tuple(&e, &c.width_e, &es)}) {
      if (!v->identifiable) continue;  // counted as not held
      *width += v->high - v->low;
      values->push_back(v->value);
    }
  }
  c.width_mu /= static_cast<double>(mus.size()), c.width_e /= static_cast<double>(es.size());
  const auto spread = [&](const std::vector<double>& x) {
    double mean = 0, square = 0;
    const auto count = static_cast<double>(x.size());
    for (const double v : x) mean += v / count;
    for (const double v : x) square += (v - mean) * (v - mean) / (count - 1);
    return std::sqrt(square);
  };
  c.spread_mu = spread(mus), c.spread_e = spread(es);
  return c;
}

}  // namespace

TEST_CASE(
    "mu and e of a thrown ball come out of its noisy motion, start and clock unknown, guesses a factor 3 off",
    "[fit]") {
  const FitResult result = fit(ball_problem(1));
  REQUIRE(result.status == FitStatus::Converged);
  CHECK(holds(value_of(result, "mu"), 0.15));
  CHECK(holds(value_of(result, "e"), 0.6));
  CHECK(value_of(result, "mu").high - value_of(result, "mu").low < 0.1 * 0.15);  // not by being wide
  CHECK(value_of(result, "e").high - value_of(result, "e").low < 0.1 * 0.6);
  CHECK(result.flat.empty());
  for (const FitResult::Noise& noise : result.noise) CHECK(noise.cells > 80);
  CHECK(std::abs(result.correlation) < 0.1);  // the noise was white
}

TEST_CASE("in twenty seeds of noise the truth is within the 95 % interval as often as that says",
          "[fit][slow]") {
  const Coverage c = coverage(20);
  CAPTURE(c.mu, c.e, c.width_mu, c.spread_mu, c.width_e, c.spread_e);
  std::printf(
      "mu held by %d of 20 intervals, width %.2g, 2 x 1.96 x spread %.2g\ne held by %d of 20, width %.2g, 2 "
      "x 1.96 x spread %.2g\n",
      c.mu, c.width_mu, 3.92 * c.spread_mu, c.e, c.width_e, 3.92 * c.spread_e);
  CHECK(c.mu >= 17);
  CHECK(c.e >= 17);
  CHECK(c.width_mu < 2 * 3.92 * c.spread_mu);
  CHECK(c.width_mu > 0.5 * 3.92 * c.spread_mu);
  CHECK(c.width_e < 2 * 3.92 * c.spread_e);
  CHECK(c.width_e > 0.5 * 3.92 * c.spread_e);
}

TEST_CASE("a pendulum's dry friction and damping are told apart", "[fit]") {
  const Scene truth = pendulum({});
  const FitProblem problem{.scene = pendulum,
                           .measured = {measured(truth, truth.start, 4, {.rate = 40, .seed = 3}, {"angle"})},
                           .free = {{.name = "friction"}, {.name = "damping"}},
                           .set = {{"friction", 0.15}, {"damping", 0.007}},
                           .h = 0.01};
  const FitResult result = fit(problem);
  REQUIRE(result.fitted());
  CHECK(holds(value_of(result, "friction"), 0.05));
  CHECK(holds(value_of(result, "damping"), 0.02));
  CHECK(value_of(result, "damping").high < 1.6 * value_of(result, "damping").low);  // not by being wide
}

TEST_CASE("a smooth motion's slopes come of one run, and are those of differences; a bounce's do not",
          "[fit]") {
  const Scene truth = pendulum({});
  const FitProblem swinging{
      .scene = pendulum,
      .measured = {measured(truth, truth.start, 2, {.rate = 40, .seed = 3}, {"angle"})},
      .free = {{.name = "friction"}, {.name = "damping"}, {.name = "rod.omega"}, {.name = "clock.offset"}},
      .h = 0.002};
  FitRuns runs(swinging, swinging.measured, truth);
  const Unknowns unknowns(swinging, truth, swinging.measured);
  Vector theta(unknowns.size());
  std::vector<int> all;
  for (int i = 0; i < unknowns.size(); ++i) {
    theta[i] = unknowns[i].guess;
    all.push_back(i);
  }
  const Vector r = runs.residual(unknowns, theta, runs.scene(unknowns, theta), 0).raw;
  const long before = runs.runs();
  const std::optional<Matrix> J = runs.slopes(unknowns, theta, all, 0, r);
  REQUIRE(J);
  CHECK(runs.runs() == before + 1);
  for (const int i : all) {
    CAPTURE(unknowns[i].name);
    // a run to another time has other steps, and its friction turns round elsewhere in them: over ten steps that counts for little
    const bool clock = unknowns[i].kind == UnknownKind::ClockOffset;
    const double d = (clock ? 1e-2 : 1e-5) * unknowns[i].scale;
    const auto at = [&](double t) {
      Vector there = theta;
      there[i] += t;
      return runs.residual(unknowns, there, runs.scene(unknowns, there), 0).raw;
    };
    const Vector slope = (at(d) - at(-d)) / (2 * d);
    CHECK((J->col(i) - slope).cwiseAbs().maxCoeff() < (clock ? 1e-2 : 1e-3) * slope.cwiseAbs().maxCoeff());
  }

  const FitProblem bouncing = ball_problem(1);
  const Scene ball = bouncing.scene({});
  FitRuns bounces(bouncing, bouncing.measured, ball);
  const Unknowns of_ball(bouncing, ball, bouncing.measured);
  Vector guess(of_ball.size());
  std::vector<int> every;
  for (int i = 0; i < of_ball.size(); ++i) {
    guess[i] = of_ball[i].guess;
    every.push_back(i);
  }
  const Vector raw = bounces.residual(of_ball, guess, bounces.scene(of_ball, guess), 0).raw;
  CHECK_FALSE(bounces.slopes(of_ball, guess, every, 0, raw));
}

TEST_CASE("a mass and a spring that only their ratio shows are named, not returned as numbers", "[fit]") {
  const Scene truth = oscillator({});
  const FitProblem problem{
      .scene = oscillator,
      .measured = {measured(truth, truth.start, 1, {.rate = 100, .noise = 0.001, .seed = 5}, {"x"})},
      .free = {{.name = "m"}, {.name = "k"}, {.name = "x0"}},
      .set = {{"m", 3}}};
  const FitResult result = fit(problem);
  REQUIRE(result.fitted());
  for (const char* name : {"m", "k"}) {
    CHECK_FALSE(value_of(result, name).identifiable);
    CHECK(std::isnan(value_of(result, name).value));
  }
  REQUIRE(result.flat.size() == 1);
  CHECK_THAT(result.flat[0], Catch::Contains("m") && Catch::Contains("k") && !Catch::Contains("x0"));
  CHECK(holds(value_of(result, "x0"), 0.1));
}

TEST_CASE("friction that held throughout is only known to be enough", "[fit]") {
  const Scene truth = thrown_ball({{"mu", 0.6}});
  FitProblem problem = ball_problem(1);
  problem.measured = {measured(truth, truth.start, 0.5, {.seed = 2}, {"x", "y", "z", "wx", "wy", "wz"})};
  problem.free = {{.name = "mu"}, {.name = "e"}};
  problem.set = {{"mu", 0.9}, {"e", 0.5}};
  const FitResult result = fit(problem);
  CHECK_FALSE(value_of(result, "mu").identifiable);
  CHECK(holds(value_of(result, "e"), 0.6));
}

TEST_CASE("a clock's rate and the frame's shift are found with the parameters", "[fit]") {
  const Scene truth = thrown_ball({});
  FitProblem problem = ball_problem(1);
  MeasuredMotion motion = measured(truth, truth.start, 0.5, {.noise = 5e-3, .seed = 4}, {"x", "y", "z"});
  for (double& t : motion.t) t /= 1.02;
  motion.values.col(2).array() -= 0.004;
  problem.measured = {motion};
  problem.free = {{.name = "mu"}, {.name = "e"}, {.name = "clock.rate"}, {.name = "frame.z"}};
  const FitResult result = fit(problem);
  REQUIRE(result.fitted());
  CHECK(holds(value_of(result, "clock.rate"), 1.02));
  CHECK(holds(value_of(result, "frame.z"), -0.004));
  CHECK(holds(value_of(result, "e"), 0.6));
}

TEST_CASE("motions held back are predicted, and say how well", "[fit]") {
  const Scene truth = thrown_ball({});
  FitProblem problem = ball_problem(1);
  problem.measured.clear();
  for (unsigned seed = 1; seed <= 3; ++seed) {
    State start = truth.start;
    truth.model.set_velocity(start, truth.model.find_body("ball"), {2 + 0.5 * seed, 0.3 * seed, -1},
                             {0, -20, 5});
    problem.measured.push_back(
        measured(truth, start, 0.6, {.noise = 1e-3, .seed = seed}, {"x", "y", "z", "qw", "qx", "qy", "qz"}));
  }
  problem.hold_back = 0.34;
  problem.search_runs = 0;
  problem.h = 1e-3;
  problem.set = {{"mu", 0.2}, {"e", 0.5}};
  const FitResult result = fit(problem);
  REQUIRE(result.fitted());
  std::set<std::string> predicted;
  for (const PredictionError& p : result.prediction) {
    predicted.insert(p.motion);
    CHECK(p.rows > 20);
    if (p.what == "position") CHECK(p.largest < 0.02);  // m, of a path of 2 m; noise of 2 mm
  }
  CHECK(predicted.size() == 1);
  for (const FitResidual& r : result.residuals)
    if (r.held_back) CHECK(predicted.count(r.motion) == 1);
}

TEST_CASE("starts that come first are kept, and have no intervals", "[fit]") {
  FitProblem problem = ball_problem(1);
  const Scene truth = thrown_ball({});
  problem.measured = {measured(truth, truth.start, 0.5, {.noise = 1e-4, .seed = 6}, {"x", "y", "z"})};
  problem.free = {{.name = "mu"}, {.name = "e"}, {.name = "ball.vx"}};
  problem.set = {{"mu", 0.2}, {"e", 0.5}};
  problem.starts_first = true;
  problem.search_runs = 0;
  const FitResult result = fit(problem);
  REQUIRE(result.fitted());
  CHECK(value_of(result, "ball.vx").value == Approx(3).margin(2e-3));
  CHECK(std::isnan(value_of(result, "ball.vx").low));
  CHECK(value_of(result, "mu").value == Approx(0.15).margin(2e-3));
  CHECK(value_of(result, "mu").high > value_of(result, "mu").low);
}

TEST_CASE("a run that fails within a fit costs a penalty and is counted", "[fit]") {
  FitProblem problem = ball_problem(1);
  const auto scene = problem.scene;
  problem.free = {{.name = "mu"}};
  problem.h = 2e-3;
  problem.set = {{"mu", 0.2}};
  problem.scene = [scene](const SceneParameters& set) {
    Scene s = scene(set);
    if (s.parameters[0].value > 0.25)  // a load that no step can follow
      s.model.add_force(s.model.find_body("ball"), [](const Model&, const State& x) {
        return Wrench{.force = Vector3(x.t > 0.3 ? not_set : 0, 0, 0)};
      });
    return s;
  };
  const FitResult result = fit(problem);
  CHECK(result.failed > 0);
  CHECK(result.failed < result.runs);
  CHECK(value_of(result, "mu").value < 0.25);
}

TEST_CASE("a fit refuses names, bounds and columns that mean nothing", "[fit]") {
  const auto refused = [](auto change) {
    FitProblem problem = ball_problem(1);
    change(problem);
    try {
      (void)fit(problem);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK_THAT(refused([](FitProblem& p) { p.free = {{.name = "nu"}}; }),
             Catch::Contains("nu") && Catch::Contains("mu, e"));
  CHECK_THAT(refused([](FitProblem& p) {
               p.free = {{.name = "mu"}, {.name = "mu"}};
             }),
             Catch::Contains("once"));
  CHECK_THAT(refused([](FitProblem& p) { p.free = {{.name = "mu", .low = 1, .high = 0}}; }),
             Catch::Contains("lower bound"));
  CHECK_THAT(refused([](FitProblem& p) { p.free = {{.name = "ball.q", .low = 0, .high = 1}}; }),
             Catch::Contains("ball.q"));
  CHECK_THAT(refused([](FitProblem& p) { p.measured[0].columns[0] = "ball.u"; }), Catch::Contains("ball.u"));
  CHECK_THAT(refused([](FitProblem& p) { p.measured[0].t[1] = p.measured[0].t[0]; }),
             Catch::Contains("rise"));
  CHECK_THAT(refused([](FitProblem& p) { p.hold_back = 1; }), Catch::Contains("hold_back"));
  CHECK_THAT(refused([](FitProblem& p) { p.measured.clear(); }), Catch::Contains("one motion"));
}

TEST_CASE("curvature tells a flat direction from a long one", "[fit]") {
  Matrix J(3, 3);
  J << 10, -10, 0, 0, 0, 5, 20, -20, 1;  // x0 - x1 and x2 alone show
  const Curvature c = curvature(J.transpose() * J, Vector::Ones(3));
  REQUIRE(c.flat.size() == 1);
  CHECK(std::abs(c.flat[0].v[0]) == Approx(std::sqrt(0.5)));
  CHECK_FALSE(c.identifiable[0]);
  CHECK_FALSE(c.identifiable[1]);
  CHECK(c.identifiable[2]);
  Matrix K = J.leftCols(1);  // one unknown: the interval's formula
  const Curvature one = curvature(K.transpose() * K, Vector::Ones(1));
  CHECK(one.covariance(0, 0) == Approx(1 / (10. * 10 + 20 * 20)));
}

TEST_CASE("bounded least squares finds Rosenbrock's minimum, and a bound's where that is outside", "[fit]") {
  const auto residual = [](const Vector& x) { return Vector2(10 * (x[1] - x[0] * x[0]), 1 - x[0]); };
  LeastSquares problem{.low = Vector::Constant(2, -5),
                       .high = Vector::Constant(2, 5),
                       .scale = Vector::Ones(2),
                       .cost = {},
                       .normal_equations = {}};
  problem.cost = [&](const Vector& x) { return 0.5 * residual(x).squaredNorm(); };
  problem.normal_equations = [&](const Vector& x, Matrix& H, Vector& g) {
    Matrix J(2, 2);
    J << -20 * x[0], 10, -1, 0;
    H = J.transpose() * J;
    g = J.transpose() * residual(x);
  };
  const LeastSquaresEnd free = minimize(problem, Vector2(-1.2, 1), {.iterations = 200, .tolerance = 1e-20});
  CHECK(free.converged);
  CHECK((free.x - Vector2(1, 1)).norm() < 1e-8);
  problem.high = Vector2(0.5, 5);
  const LeastSquaresEnd bound = minimize(problem, Vector2(-1.2, 1), {.iterations = 200, .tolerance = 1e-20});
  CHECK(bound.x[0] == 0.5);
  CHECK(bound.x[1] == Approx(0.25).margin(1e-8));
}

TEST_CASE("each of NLopt's return codes has a sentence of its own", "[fit]") {
  std::set<std::string> sentences;
  const std::vector<int> codes{1, 2, 3, 4, 5, 6, -1, -2, -3, -4, -5};
  for (const int code : codes) {
    sentences.insert(sentence_of_nlopt(code));
    CHECK_THAT(sentence_of_nlopt(code), !Catch::Contains("code"));
  }
  CHECK(sentences.size() == codes.size());
  CHECK_THAT(sentence_of_nlopt(99), Catch::Contains("99"));
}

#ifdef PERP_HAS_NLOPT
TEST_CASE("the search finds the deepest of several minima, and what f throws comes out of it", "[fit]") {
  const auto f = [](const Vector& x) {
    return 0.05 * (x - Vector2(1, -1)).squaredNorm() - std::cos(3 * (x[0] - 1)) - std::cos(3 * (x[1] + 1));
  };
  const Vector low = Vector::Constant(2, -6), high = Vector::Constant(2, 6);
  const SearchEnd end = search(f, low, high, Vector2(5, 5), 600, 1);
  CHECK((end.x - Vector2(1, -1)).norm() < 0.1);
  CHECK(end.evaluations <= 600);
  CHECK_FALSE(end.sentence.empty());
  const auto thrower = [](const Vector&) -> double { throw std::runtime_error("no value"); };
  CHECK_THROWS_WITH(search(thrower, low, high, Vector2(5, 5), 60, 1), "no value");
}
#endif
