#include "perp/step/sensitivity.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/methods.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

/// A built-in scene as a function of some of its parameters.
struct ParametricScene {
  std::string name;
  std::vector<std::string> parameters;
  double t_end, h;

  Vector theta() const {
    Vector values(static_cast<Eigen::Index>(parameters.size()));
    const Scene s = scene(name);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      for (const SceneParameter& p : s.parameters)
        if (p.name == parameters[i]) values[static_cast<Eigen::Index>(i)] = p.value;
    return values;
  }
  ModelAtStart operator()(const Vector& theta) const {
    SceneParameters set;
    for (std::size_t i = 0; i < parameters.size(); ++i)
      set[parameters[i]] = theta[static_cast<Eigen::Index>(i)];
    Scene s = scene(name, set);
    return {s.model, s.start};
  }
};

/// The derivative of the run's end by theta_j: central differences of fourth order, of runs.
Vector difference_of_runs(const std::function<State(double)>& end, double d, bool velocities) {
  const auto part = [&](double t) {
    const State x = end(t);
    return velocities ? x.nu : x.q;
  };
  return (8 * (part(d) - part(-d)) - (part(2 * d) - part(-2 * d))) / (12 * d);
}

struct Disagreement {
  double worst = 0, size = 0;  // of the derivatives, positions and velocities together
  void add(const Vector& mine, const Vector& theirs) {
    worst = std::max(worst, (mine - theirs).cwiseAbs().maxCoeff());
    size = std::max(size, theirs.cwiseAbs().maxCoeff());
  }
};

Disagreement with_differences(const ParametricScene& what, const std::string& method, double share) {
  MethodOptions options;
  if (method == "event") options.tolerance = 1e-12;
  const auto stepper = make_stepper(method, options);
  const double h = method == "event" ? not_set : what.h;
  const Vector theta = what.theta();
  const Sensitivity s = sensitivity(what, theta, *stepper, {.t_end = what.t_end, .h = h});
  for (const NoDerivative& missing : s.missing) FAIL_CHECK(missing.of << " " << missing.what);
  Disagreement all;
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    const auto end = [&](double d) {
      Vector there = theta;
      there[j] += d;
      const ModelAtStart at = what(there);
      const auto own = make_stepper(method, options);
      return simulate(at.model, *own, at.start, {.t_end = what.t_end, .h = h}).back();
    };
    const double d = share * std::max(0.01, std::abs(theta[j]));
    all.add(s.by_parameter.q.col(j), difference_of_runs(end, d, false));
    all.add(s.by_parameter.nu.col(j), difference_of_runs(end, d, true));
  }
  return all;
}

}  // namespace

TEST_CASE("the sensitivity of ncp, ncp-start and ncp2 is the derivative of their own runs to 1e-6",
          "[sensitivity]") {
  const auto what =
      GENERATE(ParametricScene{"seed-sphere", {"mu", "v0"}, 0.6, 0.01},            // slides, then rolls
               ParametricScene{"cross-incline", {"k", "theta", "v0"}, 0.4, 0.01},  // slides in a curve
               ParametricScene{"spring-block", {"friction", "x0"}, 2, 0.01},       // sticks and slips
               ParametricScene{"bouncing-ball", {"e", "height"}, 1, 0.01},         // impacts
               ParametricScene{"rocking-block", {"theta"}, 0.6, 0.005},            // of two corners
               ParametricScene{"slider-crank", {"friction", "rate"}, 0.1, 0.002},  // a loop, with friction
               ParametricScene{"four-bar", {"rate"}, 0.5, 0.01},  // one whose rows repeat each other
               ParametricScene{"friction-pendulum", {"friction", "angle"}, 2, 0.01},  // a joint's friction
               ParametricScene{"heavy-top", {"spin", "theta"}, 0.1, 0.002},           // turns in space
               ParametricScene{"sliding-cube", {"mu", "v0"}, 1, 0.01});  // four corners, which stop
  const std::string method = GENERATE("ncp", "ncp-start", "ncp2");
  const Disagreement d = with_differences(what, method, 1e-5);
  CAPTURE(what.name, method, d.size);
  CHECK(d.worst < 1e-6 * std::max(1.0, d.size));
}

TEST_CASE("the sensitivity of event is the derivative of its own runs to 1e-7", "[sensitivity]") {
  const auto what = GENERATE(ParametricScene{"seed-sphere", {"mu", "v0"}, 0.6, 0},
                             ParametricScene{"cross-incline", {"k", "theta", "v0"}, 0.4, 0},
                             ParametricScene{"spring-block", {"friction", "x0"}, 2, 0},
                             ParametricScene{"bouncing-ball", {"e", "height"}, 1, 0},
                             ParametricScene{"rocking-block", {"theta"}, 0.6, 0},
                             ParametricScene{"slider-crank", {"friction", "rate"}, 0.1, 0},
                             ParametricScene{"friction-pendulum", {"friction", "angle"}, 2, 0});
  const Disagreement d = with_differences(what, "event", 3e-4);
  CAPTURE(what.name, d.size);
  CHECK(d.worst < 1e-7 * std::max(1.0, d.size));
}

TEST_CASE("event's sensitivity of a ball that slides, rolls and was dropped is that of the closed forms",
          "[sensitivity]") {
  const auto stepper = make_stepper("event", {.tolerance = 1e-12});
  constexpr double g = 9.81, mu = 0.2, v0 = 2, t = 0.6;
  const ParametricScene sliding{"seed-sphere", {"mu", "v0"}, t, 0};
  const Sensitivity s = sensitivity(sliding, sliding.theta(), *stepper, {.t_end = t});
  REQUIRE(s.exists());
  // x(t) = 5/7 v0 t + 2 v0^2/(49 mu g) once it rolls, at 5/7 v0
  CHECK(s.by_parameter.q(0, 0) == Approx(-2 * v0 * v0 / (49 * mu * mu * g)).epsilon(1e-8));
  CHECK(s.by_parameter.q(0, 1) == Approx(5 * t / 7 + 4 * v0 / (49 * mu * g)).epsilon(1e-8));
  CHECK(std::abs(s.by_parameter.nu(0, 0)) < 1e-8);
  CHECK(s.by_parameter.nu(0, 1) == Approx(5.0 / 7).epsilon(1e-8));

  const ParametricScene falling{"bouncing-ball", {"e", "height"}, 1, 0};
  const Sensitivity b = sensitivity(falling, falling.theta(), *stepper, {.t_end = 1});
  REQUIRE(b.exists());
  // z = e v1 s - g s^2/2, s = 1 - v1/g, v1 = sqrt(2 g height), between the first two impacts
  const double v1 = std::sqrt(2 * g), e = 0.8, since = 1 - v1 / g, dv1 = g / v1, ds = -dv1 / g;
  CHECK(b.by_parameter.q(2, 0) == Approx(v1 * since).epsilon(1e-8));
  CHECK(b.by_parameter.q(2, 1) == Approx(e * (dv1 * since + v1 * ds) - g * since * ds).epsilon(1e-8));
  CHECK(b.by_parameter.nu(2, 1) == Approx(e * dv1 - g * ds).epsilon(1e-8));
}

TEST_CASE("the sensitivity by the start is the derivative by displaced starts, of rotations too",
          "[sensitivity]") {
  const std::string method = GENERATE("ncp", "ncp2", "event");
  const Scene s = scene("oblique-sphere");
  const double h = method == "event" ? not_set : 0.01, t_end = 0.8;
  MethodOptions options;
  if (method == "event") options.tolerance = 1e-12;
  const auto stepper = make_stepper(method, options);
  const Sensitivity by = sensitivity(s.model, *stepper, s.start, {.t_end = t_end, .h = h});
  REQUIRE(by.exists());
  REQUIRE(by.by_start.q.cols() == 2 * s.model.nv());
  REQUIRE(by.by_parameter.q.cols() == 0);
  Disagreement all;
  for (int j = 0; j < 2 * s.model.nv(); ++j) {
    if (j == 2 || j == 8) continue;  // across the floor
    const auto end = [&](double d) {
      State x = s.start;
      Vector xi = Vector::Zero(s.model.nv());
      if (j < s.model.nv()) {
        xi[j] = d;
        move(s.model, xi, 1, x.q);
      } else {
        x.nu[j - s.model.nv()] += d;
      }
      const auto own = make_stepper(method, options);
      return simulate(s.model, *own, x, {.t_end = t_end, .h = h}).back();
    };
    all.add(by.by_start.q.col(j), difference_of_runs(end, 1e-4, false));
    all.add(by.by_start.nu.col(j), difference_of_runs(end, 1e-4, true));
  }
  CAPTURE(method, all.size);
  CHECK(all.worst < 1e-6 * std::max(1.0, all.size));
}

TEST_CASE("a sensitivity that does not exist is said to, by the contact and the time", "[sensitivity]") {
  const std::string method = GENERATE("ncp", "ncp2", "event");
  CAPTURE(method);
  const double h = method == "event" ? not_set : 0.01;
  const auto stepper = make_stepper(method, {});

  SECTION("a block that friction just holds") {
    const auto at = [](const Vector& theta) {
      Scene s = scene("incline-block", {{"mu", theta[0]}, {"theta", std::atan(0.5)}});
      return ModelAtStart{s.model, s.start};
    };
    const Sensitivity s = sensitivity(at, Vector::Constant(1, 0.5), *stepper, {.t_end = 0.1, .h = h});
    REQUIRE_FALSE(s.exists());
    CHECK_FALSE(s.missing.front().of.empty());
    CHECK(s.missing.front().what.find("bound of its friction") != std::string::npos);
    CHECK(sensitivity(at, Vector::Constant(1, 0.6), *stepper, {.t_end = 0.1, .h = h}).exists());
  }
  SECTION("a ball that flies along a plane without weight") {
    Model model;
    model.set_gravity(Vector3::Zero());
    const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1), {.name = "ball"});
    model.add_contact(ground, ball, sphere_on_plane(1), {.mu = 0.2, .name = "floor"});
    State x = model.rest();
    model.set_position(x, ball, {0, 0, 1});
    model.set_velocity(x, ball, {1, 0, 0});
    if (method == "event") return;  // it has the contact closed, without force
    const Sensitivity s = sensitivity(model, *stepper, x, {.t_end = 0.1, .h = h});
    REQUIRE_FALSE(s.exists());
    CHECK(s.missing.front().of == "floor");
    CHECK(s.missing.front().what.find("without a load") != std::string::npos);
  }
}

TEST_CASE("sensitivity refuses methods and models that it does not know, by name", "[sensitivity]") {
  const ParametricScene what{"seed-sphere", {"mu"}, 0.1, 0.01};
  const auto lcp = make_stepper("lcp", {});
  CHECK_THROWS_WITH(sensitivity(what, what.theta(), *lcp, {.t_end = 0.1, .h = 0.01}),
                    Catch::Contains("stepper is lcp") && Catch::Contains("ncp2"));
  const ParametricScene spun{"spun-sphere", {"mu"}, 0.1, 0.01};
  const auto ncp2 = make_stepper("ncp2", {});
  CHECK_THROWS_WITH(sensitivity(spun, spun.theta(), *ncp2, {.t_end = 0.1, .h = 0.01}),
                    Catch::Contains("torsion"));
  CHECK_THROWS_WITH(
      sensitivity(what, what.theta(), *ncp2, {.t_end = 0.1, .h = 0.01, .scale = Vector::Ones(2)}),
      Catch::Contains("scale"));
  const auto other = [](const Vector& theta) {
    Scene s = scene("stack", {{"count", theta[0] > 2 ? 3.0 : 2.0}});
    return ModelAtStart{s.model, s.start};
  };
  CHECK_THROWS_WITH(sensitivity(other, Vector::Constant(1, 2), *ncp2, {.t_end = 0.1, .h = 0.01}),
                    Catch::Contains("other bodies"));
}

}  // namespace perp
