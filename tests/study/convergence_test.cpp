#include "perp/study/convergence.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/study/work_precision.hpp"

namespace perp {
namespace {

/// A particle that stays where it is for t in [0, 1]; whatever a step adds to x is its error.
Scene still_particle() {
  Scene s;
  s.name = "still";
  s.model.set_gravity(Vector3::Zero());
  s.model.add_particle(1);
  s.start = s.model.rest();
  s.start.q[2] = 1;  // a length, for rounding to be relative to
  s.t_end = 1;
  s.exact = [start = s.start](double t) {
    State x = start;
    x.t = t;
    return x;
  };
  return s;
}

/// Reaches t = 1 with the error that `error` says for its step, in x and in its velocity; fails at once for h below `fails`.
class FakeStepper : public Stepper {
 public:
  using Error = double (*)(double h);
  explicit FakeStepper(Error error, const char* name = "fake", double fails = 0)
      : error_(error), name_(name), fails_(fails) {}
  std::string_view name() const override { return name_; }
  int order() const override { return 2; }

 private:
  void advance(const Model&, State& x, const StepRequest& request, StepReport& report) override {
    report.iterations = 3;
    if (request.h < fails_) {
      report.status = StepStatus::NotSolved;
      report.message = "as it was asked to";
      return;
    }
    x.t = request.t_end;
    x.q[0] += error_(request.h) * request.h;
    x.nu[1] = error_(request.h);
    report.status = StepStatus::Solved;
  }

  Error error_;
  const char* name_;
  double fails_;
};

double square(double h) { return 3 * h * h; }

ConvergenceStudy study_of(Scene scene, int levels = 8) {
  ConvergenceStudy study{.scene = std::move(scene)};
  study.steps = halvings(0.1, levels);
  return study;
}

}  // namespace

TEST_CASE("a study finds err = 3 h^2, with its sizes", "[convergence]") {
  FakeStepper fake(square);
  const ConvergenceTable table = study_of(still_particle()).run({&fake});
  CHECK(table.scene == "still");
  REQUIRE(table.runs.size() == 8);
  for (const StudyRun& run : table.runs) {
    CHECK(run.error_q == Approx(3 * run.h * run.h).epsilon(1e-9));
    CHECK(run.error_v == Approx(3 * run.h * run.h).epsilon(1e-9));
    CHECK(run.h * run.n == Approx(1));
    CHECK(run.steps == run.n);
    CHECK(run.iterations == 3 * run.n);
    CHECK(run.failed == 0);
    CHECK(run.seconds > 0);
  }
  REQUIRE(table.orders.size() == 1);
  CHECK(table.orders[0].reference == OrderReference::Exact);
  CHECK(table.orders[0].expected == 2);
  CHECK(table.order("fake") == Approx(2).epsilon(1e-6));
  CHECK(table.orders[0].v.order == Approx(2).epsilon(1e-6));
  CHECK_THROWS_AS(table.order("another"), std::invalid_argument);
}

TEST_CASE("a study tells a method that diverges and one that stalls from one that converges",
          "[convergence]") {
  FakeStepper diverges([](double h) { return 1e-4 / h; }, "diverges");
  FakeStepper stalls([](double h) { return 1e-3 + 3 * h * h; }, "stalls");
  FakeStepper exact([](double) { return 0.0; }, "exact");
  const ConvergenceTable table = study_of(still_particle()).run({&diverges, &stalls, &exact});
  CHECK(table.order("diverges") == Approx(-1).epsilon(1e-6));
  CHECK(std::isnan(table.order("stalls")));
  CHECK(table.orders[1].q.note == "stalls at 0.001");
  CHECK(std::isnan(table.order("exact")));
  CHECK(table.orders[2].q.note == "exact to round-off");
}

TEST_CASE("a run that fails is a row with what it said, and the others still show the order",
          "[convergence]") {
  FakeStepper fails(square, "fails", 0.002);
  const ConvergenceTable table = study_of(still_particle()).run({&fails});
  REQUIRE(table.runs.size() == 8);
  CHECK(table.failed() == 2);  // h = 0.1/64, 0.1/128
  const StudyRun& last = table.runs.back();
  CHECK(last.failed == 1);
  CHECK(last.steps == 0);
  CHECK(std::isnan(last.error_q));
  CHECK(last.message.find("as it was asked to") != std::string::npos);
  CHECK(table.orders[0].failed == 2);
  CHECK(table.orders[0].q.note == "2 of 8 without an answer");
  CHECK(table.order("fails") == Approx(2).epsilon(1e-6));
}

TEST_CASE("a method is held against its own limit where that is asked for", "[convergence]") {
  Scene s = still_particle();
  s.exact = {};
  FakeStepper fake(square);
  ConvergenceStudy study = study_of(std::move(s));
  study.reference = ReferenceChoice::OwnLimit;
  const ConvergenceTable table = study.run({&fake});
  CHECK(table.reference == OrderReference::Limit);
  REQUIRE(table.orders.size() == 1);
  CHECK(table.orders[0].reference == OrderReference::Limit);
  CHECK(table.orders[0].q.points == 6);  // the two smallest steps made the limit
  CHECK(table.order("fake") == Approx(2).epsilon(1e-6));
  CHECK(table.runs[0].error_q == Approx(0.03).epsilon(1e-6));
  CHECK(table.runs[0].error_limit == table.runs[0].error_q);
}

TEST_CASE("an envelope takes the largest error among step counts spread over [n, 1.25 n]", "[convergence]") {
  // right for even n alone: halvings of 0.1 never see it
  FakeStepper fake([](double h) { return std::lround(1 / h) % 2 == 0 ? h * h * h : h; });
  ConvergenceStudy study = study_of(still_particle());
  CHECK(study.run({&fake}).order("fake") == Approx(3).epsilon(1e-6));
  study.envelope = 16;
  const ConvergenceTable table = study.run({&fake});
  CHECK(table.order("fake") == Approx(1).margin(0.05));
  for (const StudyRun& run : table.runs) {
    CHECK(run.n >= 10 << run.level);
    CHECK(4 * run.n <= 5 * (10 << run.level));
  }
  CHECK(std::count_if(table.runs.begin(), table.runs.end(), [](auto& r) { return r.level == 0; }) == 3);
  CHECK(std::count_if(table.runs.begin(), table.runs.end(), [](auto& r) { return r.level == 7; }) == 16);
}

TEST_CASE("the LCP step's orders are those of theory: program 5 of the interface", "[convergence]") {
  LcpStepper stepper({.edges = 8});
  const ConvergenceStudy study{.scene = scene("seed-sphere"), .t_end = 0.6, .steps = halvings(0.1, 8)};
  const ConvergenceTable table = study.run({&stepper});
  CHECK(table.order("lcp") == Approx(1).margin(0.1));
  CHECK(table.orders.size() == 1);  // friction along x, a vertex: the polygon is exact
}

TEST_CASE(
    "where friction turns a polygonal method stalls against the exact motion and converges to its own limit",
    "[convergence]") {
  const char* name = GENERATE("oblique-sphere", "cross-incline");
  LcpStepper lcp({.edges = 8}), ap({.edges = 8, .anitescu_potra = true});
  ConvergenceStudy study{.scene = scene(name)};
  const ConvergenceTable table = study.run({&lcp, &ap});
  REQUIRE(table.orders.size() == 4);
  for (const std::size_t i : {0U, 2U}) {
    CHECK(table.orders[i].reference == OrderReference::Exact);
    CHECK_FALSE(table.orders[i].q.known());
    CHECK(table.orders[i].q.floor > 0.005);
    CHECK(std::isnan(table.orders[i].expected));
    CHECK(table.orders[i + 1].reference == OrderReference::Limit);
    CHECK(table.orders[i + 1].q.order == Approx(1).margin(0.1));
    CHECK(table.orders[i + 1].expected == 1);
  }
  CHECK(table.order("lcp") == table.orders[1].q.order);
}

TEST_CASE("a bead in a ring: order 2 in position for the LCP step, 1 for Anitescu and Potra's",
          "[convergence]") {
  LcpStepper lcp({.edges = 8}), ap({.edges = 8, .anitescu_potra = true});
  const ConvergenceTable table = ConvergenceStudy{.scene = scene("bead-in-ring")}.run({&lcp, &ap});
  REQUIRE(table.orders.size() == 2);
  CHECK(table.order("lcp") == Approx(2).margin(0.1));
  CHECK(table.orders[0].expected == 2);
  CHECK(table.order("lcp-ap") == Approx(1).margin(0.1));
  CHECK(table.orders[1].expected == 1);
}

TEST_CASE("a method may be there with several polygons, told apart by their edges", "[convergence]") {
  LcpStepper four({.edges = 4}), eight({.edges = 8});
  ConvergenceStudy study{.scene = scene("oblique-sphere")};
  study.steps = halvings(0.05, 5);
  const ConvergenceTable table = study.run({&four, &eight});
  CHECK(table.runs[0].parameter == "edges=4");
  CHECK(table.runs[5].parameter == "edges=8");
  CHECK(table.order("lcp", "edges=4") != table.order("lcp", "edges=8"));
  CHECK(table.order("lcp") == table.order("lcp", "edges=4"));
  CHECK_THROWS_AS(table.order("lcp", "edges=5"), std::invalid_argument);
}

TEST_CASE("a friction polygon is exact where friction keeps to its vertices", "[convergence]") {
  CHECK(polygon_is_exact(scene("seed-sphere"), 4, 0.6));
  CHECK_FALSE(polygon_is_exact(scene("seed-sphere"), 5, 0.6));  // no vertex at -x
  CHECK(polygon_is_exact(scene("bead-in-ring"), 8, 1));
  CHECK_FALSE(polygon_is_exact(scene("oblique-sphere"), 64, 2));
  CHECK(polygon_is_exact(scene("oblique-sphere", {{"mu", 0}}), 3, 2));  // no friction
  CHECK(polygon_is_exact(scene("bouncing-ball"), 3, 1));
}

TEST_CASE("velocity in L1 across impacts converges with order 1", "[convergence]") {
  LcpStepper lcp;
  ConvergenceStudy study{.scene = scene("bouncing-ball", {{"e", 0.5}})};
  study.steps = ladder(1, 40, 6);
  study.velocity = GENERATE(VelocityMeasure::L1, VelocityMeasure::Graph);
  const ConvergenceTable table = study.run({&lcp});
  CHECK(table.orders[0].v.order == Approx(1).margin(0.2));
}

TEST_CASE("a work-precision line has a point for each level: its error and the CPU time of one run",
          "[convergence]") {
  FakeStepper fake(square, "fake"), fails(square, "fails", 0.002);
  WorkPrecision work{.study = study_of(still_particle())};
  work.timing = {.spend = 1e-3, .least_span = 1e-4};
  const std::vector<WorkLine> lines = work.run({&fake, &fails});
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].label() == "fake");
  REQUIRE(lines[0].error.size() == 8);
  CHECK(lines[1].error.size() == 6);  // without the runs that failed
  CHECK(lines[0].error[1] == Approx(3 * 0.05 * 0.05).epsilon(1e-9));
  CHECK(lines[0].seconds[7] > lines[0].seconds[0]);  // 1280 steps against 10
  CHECK(lines[0].error_within(1) == lines[0].error[7]);
  CHECK(lines[0].error_within(0) == infinity);
}

TEST_CASE("the best CPU time of work that spins for a millisecond is a millisecond, alone or in batches",
          "[convergence]") {
  const auto spin = [](double seconds) {
    const double begin = thread_cpu_seconds();
    while (thread_cpu_seconds() - begin < seconds) continue;
  };
  int calls = 0;
  const double once = best_cpu_seconds([&] { spin(1e-3), ++calls; }, {.spend = 0});
  CHECK(calls == 1);
  CHECK(once >= 1e-3);
  const double best = best_cpu_seconds([&] { spin(1e-4), ++calls; }, {.spend = 0.01, .least_span = 1e-3});
  CHECK(best >= 1e-4);
  CHECK(best < 3e-4);
  CHECK(calls > 30);
}

TEST_CASE("a study refuses what it cannot run", "[convergence]") {
  FakeStepper fake(square);
  ConvergenceStudy study = study_of(still_particle());
  CHECK_THROWS_AS(study.run({nullptr}), std::invalid_argument);
  study.steps = {0.1, -0.1};
  CHECK_THROWS_AS(study.run({&fake}), std::invalid_argument);
  study.steps = {0.1};
  study.envelope = 0;
  CHECK_THROWS_AS(study.run({&fake}), std::invalid_argument);
  study.envelope = 1;
  study.t_end = 0;
  CHECK_THROWS_AS(study.run({&fake}), std::invalid_argument);
}

TEST_CASE("local slopes go from the largest steps to the smallest, with the range of the fit",
          "[convergence]") {
  const std::vector<double> h = {0.1, 0.05, 0.025, 0.0125}, error = {8e-2, 2e-2, 1e-2, 5e-3};
  const ObservedOrder order = observed_order(h, error, std::vector<double>(4, 0));
  REQUIRE(order.local.size() == 3);
  CHECK(order.local[0] == Approx(2));
  CHECK(order.local[1] == Approx(1));
  CHECK(order.local[2] == Approx(1));
  CHECK(order.h_least == 0.0125);
  CHECK(order.h_most == 0.1);
  const ObservedOrder barred = observed_order(h, error, std::vector<double>(4, 0), {.bar = 6e-3});
  CHECK(barred.note == "1 of 4 within the reference's bar");
  CHECK(barred.points == 3);
  CHECK(barred.h_least == 0.025);
}

TEST_CASE("an order that is not the expected one says why, and one that is says nothing", "[convergence]") {
  OrderRow row{.method = "m", .parameter = "", .expected = 2};
  StudyRun smooth, jumping;
  jumping.switches = 3;
  const auto why = [&](double order, std::vector<double> local, const std::string& note,
                       const StudyRun& run) {
    row.q.order = order;
    row.q.local = std::move(local);
    row.q.note = note;
    return why_not_expected(row, {&run});
  };
  CHECK(why(2.05, {1, 3}, "", jumping).empty());
  CHECK(why(1.44, {0.4, 2.5, 1.5}, "", jumping).find("events within h: modes change up to 3 times") == 0);
  CHECK(why(1.44, {0.9, 1.5, 1.95}, "", smooth).find("the slope of the smallest is 1.95") !=
        std::string::npos);
  CHECK(why(1.2, {2, 1.2, 0.3}, "", smooth).find("a floor comes near") == 0);
  CHECK(why(1.5, {1.6, 1.5, 1.4}, "3 of 8 at round-off", smooth).find("round-off: ") == 0);
  CHECK(why(1.5, {1.6, 1.5, 1.4}, "3 of 8 within the reference's bar", smooth).find("reference's bar: ") ==
        0);
  CHECK(why(1.5, {1.6, 1.5, 1.4}, "", smooth) == "no event, floor, polygon, round-off or bar explains it");
  CHECK(why(not_set, {}, "2 of 4 without an answer; too few points for an order", smooth) ==
        "runs that failed leave fewer points");
  row.q.floor = 0.06;
  CHECK(why(not_set, {}, "stalls at 0.06", smooth) == "floor: smaller steps do not help below 0.06");
  row.q.floor = not_set;
  row.expected = not_set;
  row.parameter = "edges=8";
  CHECK(why(0.2, {}, "", smooth).find("a polygon (edges=8) has a motion of its own") != std::string::npos);
}

}  // namespace perp
