// Accuracy that is asked for against what is got, on scenes whose motion is known.
#include "perp/study/accuracy.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "perp/step/simulate.hpp"
#include "perp/study/error_measure.hpp"
#include "perp/study/scene.hpp"

namespace perp {
namespace {

struct Got {
  AccuracyChoice choice;
  double error = 0, estimate = 0;  ///< the largest over the rows of the run, true and said
};

Got get(const Scene& s, const char* method, double accuracy, double most_steps = 1e5) {
  Got got;
  got.choice = choose_for_accuracy(
      s.model, s.start, {.method = method, .accuracy = accuracy, .t_end = s.t_end, .most_steps = most_steps});
  if (!got.choice.reached) return got;
  const std::unique_ptr<Stepper> stepper = make_stepper(method, got.choice.options);
  const Trajectory rows = simulate(s.model, *stepper, s.start, {.t_end = s.t_end, .h = got.choice.h});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const State x = rows.state(i), exact = s.exact(x.t);
    if (!exact.q.allFinite()) continue;
    got.error = std::max(got.error, configuration_error(s.model, x, exact));
    got.estimate = std::max(got.estimate, got.choice.estimate(s.model, x));
  }
  return got;
}

constexpr double rounding = 1e-13;  // m, rad: errors below it are not told from each other

}  // namespace

TEST_CASE("A run is as accurate as was asked, and says how accurate, by every method", "[accuracy]") {
  const auto [method, accuracy] = GENERATE(table<const char*, double>({{"lcp", 3e-2},
                                                                       {"lcp-ap", 3e-2},
                                                                       {"ncp", 1e-2},
                                                                       {"ncp-start", 1e-2},
                                                                       {"ncp2", 1e-4},
                                                                       {"event", 1e-6},
                                                                       {"extrapolated", 1e-6},
                                                                       {"extrapolated", 1e-10}}));
  const char* name =
      GENERATE("seed-sphere", "oblique-sphere", "bowl", "friction-pendulum", "rolling-ellipse");
  if (std::string(method) == "event" && !has_sundials()) return;
  const Got got = get(scene(name), method, accuracy);
  CAPTURE(method, accuracy, name, got.choice.why, got.choice.error, got.choice.h);
  REQUIRE(got.choice.reached);
  CHECK(got.error <= accuracy);
  if (got.error < rounding) return;
  CHECK(got.estimate > 0.3 * got.error);
  CHECK(got.estimate < 30 * got.error);
}

TEST_CASE("lcp gets more edges where friction turns and its step is not what limits it", "[accuracy]") {
  const Scene s = scene("oblique-sphere");
  CHECK(get(s, "lcp", 1e-2, 2e4).choice.options.edges > 8);
  const Got fine = get(s, "lcp", 1e-4, 2e4);
  CHECK_FALSE(fine.choice.reached);
  CHECK_FALSE(fine.choice.why.empty());
}

TEST_CASE("An accuracy that a method cannot give is refused with the reason and what it can give",
          "[accuracy]") {
  const Got got = get(scene("bowl"), "ncp", 1e-9, 1e4);
  CHECK_FALSE(got.choice.reached);
  CHECK(got.choice.why.find("steps") != std::string::npos);
  CHECK(got.choice.error > 1e-9);
  CHECK_THROWS_AS(get(scene("bowl"), "ncp", 0), std::invalid_argument);
  CHECK_THROWS_AS(get(scene("bowl"), "ncp", -1), std::invalid_argument);
}

TEST_CASE("Asked against got: all scenes with a known motion, methods and accuracies", "[accuracy][slow]") {
  int asked = 0, kept = 0, cannot = 0, judged = 0, well_judged = 0;
  double worst = 0;
  for (const std::string& name : scene_names()) {
    const Scene s = scene(name);
    if (!s.exact) continue;
    for (const Method& m : methods()) {
      if (m.name == "event" && !has_sundials()) continue;
      if (!m.make({})->knows(s.model)) continue;
      for (double accuracy = 1e-3; accuracy > 0.5e-10; accuracy *= 0.1) {
        const bool beyond = (m.order == 1 && accuracy < 0.5e-4) || (m.order == 2 && accuracy < 0.5e-8);
        if (beyond) continue;
        const Got got = get(s, std::string(m.name).c_str(), accuracy, m.order == 1 ? 4e4 : 1e5);
        if (!got.choice.reached) {
          ++cannot;
          std::printf("%s %s %.0e: cannot: %s\n", name.c_str(), std::string(m.name).c_str(), accuracy,
                      got.choice.why.c_str());
          break;
        }
        ++asked;
        kept += got.error <= accuracy;
        worst = std::max(worst, got.error / accuracy);
        if (got.error > accuracy)
          std::printf("%s %s %.0e: got %.1e, said %.1e\n", name.c_str(), std::string(m.name).c_str(),
                      accuracy, got.error, got.estimate);
        if (got.error < rounding) continue;
        ++judged;
        const double ratio = got.estimate / got.error;
        well_judged += ratio > 0.3 && ratio < 30;
      }
    }
  }
  std::printf("asked %d, kept %d, worst %.2g of what was asked, cannot %d; estimates right %d of %d\n", asked,
              kept, worst, cannot, well_judged, judged);
  CHECK(kept >= 0.95 * asked);
  CHECK(worst <= 10);
  CHECK(well_judged >= 0.9 * judged);
}

}  // namespace perp
