// Torsion, rolling and friction axes under the time-stepping LCP: polytopes in the place of ellipsoids.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "perp/instant/friction_polygon.hpp"
#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"
#include "step/certificate/certificate.hpp"

namespace perp {
namespace {

constexpr double g = 9.81, mu = 0.3, J = 0.005;

/// A disc without height on the plane: it slides at v and spins at w.
struct SlidingDisc {
  Model model;
  BodyId disc;
  State start;
  SlidingDisc(ContactOptions options, const Vector3& v, double w) {
    disc = model.add_body(Inertia::principal(1, {J / 2, J / 2, J}), {.name = "disc"});
    model.add_contact(ground, disc, point_on_plane(Vector3::Zero()), options);
    start = model.rest();
    model.set_velocity(start, disc, v, {0, 0, w});
  }
  State at(double T, int steps, int edges) const {
    LcpStepper lcp({.edges = edges});
    return simulate(model, lcp, start, {.t_end = T, .h = T / steps}).back();
  }
};

}  // namespace

TEST_CASE("the friction polytope lies in the unit ball, and its gauge and support are those of its vertices",
          "[lcp][moments]") {
  std::mt19937_64 draw(5);
  std::normal_distribution<double> normal;
  for (const int edges : {3, 4, 6, 8, 13, 16}) {
    const std::vector<Vector3> d = friction_polytope(edges);
    CAPTURE(edges);
    for (const Vector3& v : d) {
      CHECK(v.norm() == Approx(1).epsilon(1e-14));
      CHECK(polytope_gauge(edges, v) == Approx(1).epsilon(1e-13));
    }
    for (int i = 0; i < 200; ++i) {
      const Vector3 y(normal(draw), normal(draw), normal(draw)), p(normal(draw), normal(draw), normal(draw));
      double largest = 0;
      for (const Vector3& v : d) largest = std::max(largest, v.dot(y));
      CHECK(polytope_support(edges, y) == Approx(largest).epsilon(1e-13));
      CHECK(polytope_gauge(edges, p) * polytope_support(edges, y) >= p.dot(y) * (1 - 1e-13));
      // the face that p/gauge lies on has a normal with which the two are equal: found by differences of the gauge
      Vector3 face;
      for (int k = 0; k < 3; ++k) {
        const Vector3 e = 1e-6 * Vector3::Unit(k);
        face[k] = (polytope_gauge(edges, p + e) - polytope_gauge(edges, p - e)) / 2e-6;
      }
      CHECK(polytope_support(edges, face) == Approx(1).epsilon(1e-4));
    }
  }
}

TEST_CASE(
    "under lcp a disc that slides and spins tends to the ellipsoid's motion as the polytope gets more "
    "vertices",
    "[lcp][moments]") {
  const double gamma = 0.0212, T = 0.3;
  const SlidingDisc disc({.mu = mu, .torsion = gamma}, {1, 0.3, 0}, 12);
  NcpStepper ncp;
  const State exact = simulate(disc.model, ncp, disc.start, {.t_end = T, .h = T / 800}).back();
  const auto error = [&](int edges) { return (disc.at(T, 800, edges).nu - exact.nu).norm(); };
  const double coarse = error(8), fine = error(24);
  CAPTURE(coarse, fine);
  CHECK(coarse > 1e-3);
  CHECK(fine < 0.3 * coarse);
}

TEST_CASE("lcp has order 1 against the limit of its own polytope", "[lcp][moments]") {
  const SlidingDisc disc({.mu = mu, .torsion = 0.0212}, {1, 0.3, 0}, 12);
  const double T = 0.3;
  Vector before;
  std::vector<double> change;
  for (int steps = 50; steps <= 800; steps *= 2) {
    const State x = disc.at(T, steps, 8);
    if (before.size() > 0) change.push_back((x.q - before).norm());
    before = x.q;
  }
  const double order = std::log2(change.front() / change.back()) / static_cast<double>(change.size() - 1);
  CHECK(order == Approx(1).margin(0.2));
}

TEST_CASE("under lcp friction axes slow a block along each by its own coefficient", "[lcp][moments]") {
  const SlidingDisc along({.friction_axes = FrictionAxes{.mu = {0.2, 0.5}}}, {1, 0, 0}, 0),
      across({.friction_axes = FrictionAxes{.mu = {0.2, 0.5}}}, {0, 1, 0}, 0);
  const double T = 0.1;
  CHECK(along.model.velocity(along.at(T, 10, 8), along.disc).x() == Approx(1 - 0.2 * g * T).epsilon(1e-10));
  CHECK(across.model.velocity(across.at(T, 10, 8), across.disc).y() ==
        Approx(1 - 0.5 * g * T).epsilon(1e-10));
}

TEST_CASE("lcp's certificate sees a moment that is wrong by a millionth", "[lcp][moments]") {
  const Scene sphere = scene("spun-sphere"), wheel = scene("coasting-wheel", {{"rolling", 0.02}});
  for (const Scene* s : {&sphere, &wheel}) {
    LcpStepper lcp;
    State x = s->start;
    const StepReport report = lcp.step(s->model, x, 1e-2);
    REQUIRE(report.advanced());
    CHECK(report.residuals.friction < 1e-12);
    CHECK(report.contacts[0].moment.norm() > 0);
    Instant start, end;
    evaluate(s->model, s->start, start);
    evaluate(s->model, x, end);
    for (const double lie : {-1e-6, 1e-6}) {
      StepAnswer answer = *lcp.answer();
      for (Acting& a : answer.first)
        if (a.of == Reaction::Of::Moments) a.p *= 1 + lie;
      StepReport again = report;
      (void)Certificate().certify(s->model, start, s->start, s->model.energy(s->start), end, x, answer,
                                  again);
      CAPTURE(lie, s->name);
      CHECK(std::max(again.residuals.friction, again.residuals.newton_euler) > 1e-10);
      CHECK(again.residuals.friction > 1e-10);
    }
  }
}

TEST_CASE("least reactions and the mixed form refuse contacts with moments by name", "[lcp][moments]") {
  const Scene s = scene("spun-sphere");
  LcpStepper least({.reactions = Reactions::MinimumNorm}), mixed({.form = LcpForm::Mixed});
  State x = s.start;
  CHECK_THROWS_WITH((void)least.step(s.model, x, 0.01), Catch::Contains("minimum-norm"));
  CHECK_THROWS_WITH((void)mixed.step(s.model, x, 0.01), Catch::Contains("mixed"));
}

}  // namespace perp
