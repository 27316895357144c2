// References of scenes whose motion is not known to perp, against truths that these tests know.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/convergence.hpp"
#include "study/reference_motion.hpp"
#include "tests/cli/program.hpp"

namespace perp {
namespace {

std::string example(const std::string& name) {
  return (std::filesystem::path(PERP_TEST_FOLDER) / ".." / ".." / "examples" / "scenes" / (name + ".toml"))
      .lexically_normal()
      .string();
}

constexpr double g = 9.81;

/// The box of climbing-belt.toml: it speeds up by friction to the belt's speed, then rides.
State box_on_belt(const Scene& s, double t) {
  const double slope = 12 * M_PI / 180, mu = 0.45, v = 0.7, a = g * (mu * std::cos(slope) - std::sin(slope));
  const double sliding = std::min(t, v / a), way = a * sliding * sliding / 2 + v * (t - sliding);
  State x = s.start;
  x.t = t;
  x.q[0] += way * std::cos(slope);
  x.q[2] += way * std::sin(slope);
  return x;
}

/// The rod of leaning-rod.toml by Newton and Euler in its angle th from the vertical (and x, once it has left the wall): y = (th, th', x,
/// x'). Both ends slide: m x'' = W - mu F, m y'' = F + mu W - m g, J th'' = c (F (sin - mu cos) - W (cos + mu sin)).
State rod_on_wall(const Scene& s, double t) {
  const Real m = 1.2L, J = 0.1L, c = 0.5L, mu = 0.1L, G = 9.81L;
  struct Forces {
    Real wall, turn, along;
  };
  const auto leaning =
      [=](const Reals& y) {  // x'' = c (cos th'' - sin th'^2), y'' = -c (sin th'' + cos th'^2)
        const Real sn = std::sin(y[0]), cs = std::cos(y[0]), w2 = y[1] * y[1];
        Eigen::Matrix<Real, 3, 3> A;  // of th'', F, W
        A << m * c * cs, mu, -1, -m * c * sn, -1, -mu, J, -c * (sn - mu * cs), c * (cs + mu * sn);
        const RealVector3 b(m * c * sn * w2, m * c * cs * w2 - m * G, 0);
        const RealVector3 z = A.fullPivLu().solve(b);
        return Forces{.wall = z[2], .turn = z[0], .along = c * (cs * z[0] - sn * w2)};
      };
  const Stretch first{.rate =
                          [=](Real, const Reals& y, Reals& rate) {
                            const Forces f = leaning(y);
                            rate = {y[1], f.turn, y[3], f.along};
                          },
                      .guard = [=](Real, const Reals& y) { return leaning(y).wall; },
                      .next = [](Real, Reals&) { return 1; }};
  const Stretch second{.rate = [=](Real, const Reals& y, Reals& rate) {
    const Real sn = std::sin(y[0]), cs = std::cos(y[0]), arm = c * (sn - mu * cs);
    const Real turn = arm * m * (G - c * cs * y[1] * y[1]) / (J + m * c * sn * arm);
    const Real floor = turn * J / arm;
    rate = {y[1], turn, y[3], -mu * floor / m};
  }};
  const Real angle = 0.4L;
  const ReferenceMotion motion({{0, first}, {1, second}}, {angle, 0, c * std::sin(angle), 0}, 0);
  const Reals y = motion.at(t).y;
  CHECK(motion.switches(t).size() == 1);
  State x = s.start;
  x.t = t;
  x.q << double(y[2]), double(c * std::cos(y[0])), double(y[0]);
  return x;
}

std::vector<std::unique_ptr<Stepper>> four_methods(double rtol) {
  std::vector<std::unique_ptr<Stepper>> all;
  for (const char* name : {"lcp", "ncp", "ncp2", "event"})
    all.push_back(make_stepper(name, {.tolerance = rtol}));
  return all;
}

Scene pulse(double start, double width, const char* kind) {
  const std::string w = shortest(width), from = shortest(start);
  const std::string force = kind == std::string("step")
                                ? "10*(step(t - " + from + ") - step(t - " + from + " - " + w + "))/" + w
                                : "10*exp(-((t - " + from + ")/" + w + ")^2)/" + w;
  return read_scene(
      "gravity = [0, 0, 0]\nt_end = 30\n[[body]]\nname = \"p\"\nkind = \"particle\"\nmass = 1\n"
      "[[force]]\nbody = \"p\"\nforce = [\"" +
          force + "\", 0, 0]\n",
      "pulse.toml");
}

}  // namespace

TEST_CASE("errors of scenes without an exact motion are within a tenth of a truth that perp is not told",
          "[reference]") {
  if (!has_sundials()) return;
  for (const auto& [name, truth] :
       {std::pair{"climbing-belt", &box_on_belt}, std::pair{"leaning-rod", &rod_on_wall}}) {
    Scene s = load_scene(example(name));
    const State right = truth(s, s.t_end);
    ConvergenceStudy study{.scene = s, .steps = ladder(s.t_end, 20, 6)};
    int points = 0;
    for (const double rtol : {1e-4, 1e-6, 1e-8}) {
      const auto steppers = four_methods(rtol);
      std::vector<Stepper*> methods;
      for (const auto& stepper : steppers)
        if (rtol == 1e-4 || stepper->name() == "event") methods.push_back(stepper.get());
      const ConvergenceTable table = study.run(methods);
      CAPTURE(name, table.words);
      REQUIRE(table.reference == OrderReference::Event);
      CHECK(table.bar_q > 0);
      CHECK(table.bar_q < 1e-6);
      for (const OrderRow& row : table.orders) CHECK(row.reference == OrderReference::Event);
      for (const StudyRun& run : table.runs) {
        const double error = configuration_error(s.model, run.end, right);
        CAPTURE(run.method, run.h, run.rtol, run.error_q, error);
        if (run.error_q > table.bar_q) {
          CHECK(run.error_q == Approx(error).epsilon(0.1));
          ++points;
        } else {
          CHECK(error <= 1.1 * table.bar_q);
        }
      }
    }
    CHECK(points >= 18);
  }
}

TEST_CASE("a built-in scene written out as a file has the errors that it has built in", "[reference]") {
  if (!has_sundials()) return;
  const Scratch scratch("study-written");
  const Outcome text = run_perp(scratch, "scenes oblique-sphere --toml");
  REQUIRE(text.status == 0);
  std::ofstream(scratch / "written.toml") << text.out;
  const std::string rest =
      " --methods lcp,ncp2,event --steps T/20,T/40,T/80,T/160,T/320 --tolerances 1e-4,1e-6 --out ";
  REQUIRE(run_perp(scratch, "study oblique-sphere" + rest + (scratch / "a")).status == 0);
  REQUIRE(run_perp(scratch, "study " + (scratch / "written.toml") + rest + (scratch / "b")).status == 0);
  auto exact = columns(scratch / "a/study.csv"), found = columns(scratch / "b/study.csv");
  REQUIRE(exact["error_q"].size() == 12);
  int same = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    CHECK(exact["reference"][i] == "exact");
    CHECK(found["reference"][i] == "event");
    if (found["error_q"][i].empty()) continue;
    CHECK(std::stod(found["error_q"][i]) ==
          Approx(std::stod(exact["error_q"][i])).margin(1.1 * std::stod(found["bar_q"][i])));
    ++same;
  }
  CHECK(same >= 10);
  const std::string orders = contents(scratch / "b/orders.csv");
  CHECK(orders.find(",exact,") == std::string::npos);  // the polygon is held against event, and its own limit
  CHECK(orders.find("lcp,edges=8,event,") != std::string::npos);
  CHECK(orders.find("lcp,edges=8,limit,") != std::string::npos);
}

TEST_CASE("a pulse has no false reference, however short it is", "[reference]") {
  if (!has_sundials()) return;
  int known = 0;
  for (const char* kind : {"step", "bump"})
    for (const double width : {1.0, 0.1, 0.01}) {
      const double area = kind == std::string("step") ? 10 : 10 * std::sqrt(M_PI);
      const double middle = kind == std::string("step") ? 20.3 + width / 2 : 20.3;
      const Reference found = confirmed_reference(pulse(20.3, width, kind), 30);
      CAPTURE(kind, width, found.words);
      if (!found) {
        CHECK(found.words.find("no reference: ") == 0);
        continue;
      }
      ++known;
      CHECK(std::abs(found.end.q[0] - area * (30 - middle)) <= 1.01 * found.bar_q + 1e-9);
    }
  CHECK(known >= 2);
}

TEST_CASE("where two computed motions disagree there is no reference, no error, and an exit status of 1",
          "[reference]") {
  if (!has_sundials()) return;
  const Scratch scratch("study-disagree");
  std::ofstream(scratch / "pulse.toml")
      << "gravity = [0, 0, 0]\nt_end = 30\n[[body]]\nname = \"p\"\nkind = \"particle\"\nmass = 1\n"
         "[[force]]\nbody = \"p\"\nforce = [\"10000*(step(t - 20) - step(t - 20.001))\", 0, 0]\n";
  const std::string study =
      "study " + (scratch / "pulse.toml") + " --methods ncp2,event --steps T/20,T/40,T/80 --tolerances 1e-6";
  const Outcome done = run_perp(scratch, study + " --out " + (scratch / "o"));
  CHECK(done.status == 1);
  CHECK(done.err.find("no reference: event and the limit of ncp2") != std::string::npos);
  CHECK(done.err.find("--reference own-limit") != std::string::npos);
  auto table = columns(scratch / "o/study.csv");
  CHECK(table["error_q"] == std::vector<std::string>(4));
  CHECK(table["reference"] == std::vector<std::string>(4, "none"));
  CHECK(contents(scratch / "o/study.html").find("no reference: event and") != std::string::npos);

  const Outcome own = run_perp(scratch, study + " --reference own-limit --out " + (scratch / "p"));
  CHECK(own.status == 0);
  auto limits = columns(scratch / "p/study.csv");
  CHECK(limits["reference"] == std::vector<std::string>(4, "own-limit"));
  CHECK_FALSE(limits["error_q"][0].empty());
  CHECK(limits["error_q"][3].empty());  // event tends to nothing here
  auto orders = columns(scratch / "p/orders.csv");
  CHECK(orders["reference"] == std::vector<std::string>{"limit", "none"});
  CHECK(own.out.find("each method against its own limit") != std::string::npos);
  CHECK(contents(scratch / "p/pulse-convergence.gnuplot").find("own limit") != std::string::npos);
}

TEST_CASE("a study's reference may be asked for, and is refused where there is none of it", "[reference]") {
  const Scratch scratch("study-asked");
  const std::string rest = " --methods ncp2 --steps T/20,T/40,T/80,T/160,T/320 --out " + (scratch / "o");
  const auto error = [&](const std::string& arguments) {
    const Outcome done = run_perp(scratch, "study " + arguments + rest);
    CHECK(done.status == 2);
    return done.err;
  };
  CHECK(error(example("climbing-belt") + " --reference exact").find("climbing-belt is none") !=
        std::string::npos);
  CHECK(error("seed-sphere --reference nearly").find("exact, event, extrapolated or own-limit") !=
        std::string::npos);
  if (!has_sundials()) return;
  REQUIRE(run_perp(scratch, "study double-pendulum --reference event" + rest).status == 0);
  auto found = columns(scratch / "o/orders.csv");
  CHECK(found["reference"][0] == "event");
  CHECK(std::stod(found["order"][0]) == Approx(2).margin(0.1));
  CHECK(std::stod(found["bar"][0]) < 1e-9);  // of a smooth motion: Richardson with h^2 and h^4
  REQUIRE(run_perp(scratch, "study double-pendulum --reference extrapolated" + rest).status == 0);
  auto other = columns(scratch / "o/orders.csv");
  CHECK(other["reference"][0] == "extrapolated");
  CHECK(std::stod(other["bar"][0]) < 1e-9);
  REQUIRE(run_perp(scratch, "study double-pendulum --reference event" + rest).status == 0);
  const std::string chart = contents(scratch / "o/double-pendulum-convergence.gnuplot");
  CHECK(chart.find("reference's bar") != std::string::npos);  // a floor, with its value
  CHECK(chart.find("from event") != std::string::npos);
}

}  // namespace perp
