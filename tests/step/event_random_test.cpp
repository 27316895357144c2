// Random starts of small scenes: whatever happens, a run ends at its time or says why it does not.
#include <chrono>
#include <cstdio>
#include <map>
#include <span>

#include "perp/step/event_driven.hpp"
#include "perp/step/simulate.hpp"
#include "tests/step/random_starts.hpp"

namespace perp {
namespace {

struct Family {
  const char* name;
  Start (*make)(Draw&);
  int quick, slow;  // starts in the quick set, and of the 10,000
};

const Family families[] = {{"rod", rod_start, 150, 2500},
                           {"box", box_start, 40, 2000},
                           {"two spheres", two_spheres_start, 100, 2500},
                           {"four-bar on the floor", four_bar_start, 30, 500},
                           {"ellipsoid", ellipsoid_start, 100, 2500}};

/// Where one answer is hard to come by: redundant contacts, brakes, equations that lose their solution.
const Family hard_families[] = {{"chain", chain_start, 3, 2000},
                                {"braked cart", braked_cart_start, 10, 2500},
                                {"coin", coin_start, 2, 500},
                                {"stack of three", stack_start, 1, 500},
                                {"rod into A = 0", painleve_start, 20, 4500}};

/// What came of the starts of a family.
struct Outcomes {
  std::map<std::string, int> ends;  // "ended", or the report of those that stopped
  std::map<std::string_view, long> events;
  long evaluations = 0;
  int carried = 0;   // runs with a step of the time-stepping method
  double grown = 0;  // the largest growth of energy in a row, over the run's largest energy [-]
};

constexpr double tolerance = 1e-8;

/// A run of a second: no NaN, no energy but for the integrator's error, an end that is reached or explained.
void run_one(const Start& start, Outcomes& outcomes) {
  EventDriven stepper({.rtol = tolerance, .max_evaluations = 300'000});
  Trajectory run;
  std::string end = "ended";
  try {
    run = simulate(start.model, stepper, start.x, {.t_end = 1});
    CHECK(run.back().t == 1);
  } catch (const StepFailure& failure) {
    end = failure.report.message;
    CHECK_FALSE(end.empty());
    run = failure.trajectory;
  }
  ++outcomes.ends[end];
  outcomes.evaluations += run.evaluations;
  for (const Event& e : run.events) ++outcomes.events[name_of(e.kind)];

  double energy = start.model.energy(start.x), growth = 0;
  const double scale = std::max(1.0, std::abs(energy));
  bool carried = false;
  for (std::size_t i = 0; i < run.steps(); ++i) {
    const State x = run.state(i + 1);
    REQUIRE(x.q.allFinite());
    REQUIRE(x.nu.allFinite());
    const StepFigures& row = run.figures(i);
    const bool smooth = row.h > 0 && row.solver != "inelastic-step";
    carried = carried || (row.h > 0 && !smooth);
    // nothing but the integrator's error may add energy: not what happens at an event, nor a step across
    CHECK(row.energy <= energy + (smooth ? 10 * tolerance : 1e-10) * scale);
    growth = std::max(growth, (row.energy - energy) / scale);
    energy = row.energy;
  }
  outcomes.grown = std::max(outcomes.grown, growth);
  outcomes.carried += carried ? 1 : 0;
}

}  // namespace

TEST_CASE("Runs from random starts end, or say why they do not, and gain no energy", "[event]") {
  if (!has_sundials()) return;
  const Family& family = families[static_cast<std::size_t>(GENERATE(0, 1, 2, 3, 4))];
  const Outcomes outcomes = run_all<Outcomes>(family.name, family.make, run_one, family.quick);
  CHECK(outcomes.ends.at("ended") == family.quick);
}

void ends_well(std::size_t number) {
  if (!has_sundials()) return;
  const Family& family = hard_families[number];
  const Outcomes outcomes = run_all<Outcomes>(family.name, family.make, run_one, family.quick);
  CHECK(10 * outcomes.ends.at("ended") >= 9 * family.quick);  // brakes: doc/methods/event-driven.md
}

TEST_CASE("Runs from random starts of chains, brakes and coins end and gain no energy", "[event]") {
  ends_well(GENERATE(0U, 1U, 2U));
}

TEST_CASE("Runs from random starts of stacks end and gain no energy", "[event]") { ends_well(3U); }

TEST_CASE("Runs from random starts of Painleve rods end and gain no energy", "[event]") { ends_well(4U); }

TEST_CASE("A box that slides on four corners, one of which its least forces would pull, goes on", "[event]") {
  if (!has_sundials()) return;
  Outcomes outcomes;
  for (const unsigned seed : {741U, 1235U}) {
    Draw draw(seed);
    run_one(box_start(draw), outcomes);
  }
  CHECK(outcomes.ends.at("ended") == 2);
}

TEST_CASE("Sliding that turns back for a part of a step gains no energy from its friction", "[event]") {
  if (!has_sundials()) return;
  Outcomes outcomes;
  Draw draw(1871);
  run_one(four_bar_start(draw), outcomes);
  CHECK(outcomes.ends.at("ended") == 1);
}

namespace {

/// All of them, with what came of them printed; at most one in a hundred ends early, `most_across` need a step across.
void run_and_tell(std::span<const Family> all, int most_across) {
  int across = 0;
  for (const Family& family : all) {
    const auto begin = std::chrono::steady_clock::now();
    const Outcomes outcomes = run_all<Outcomes>(family.name, family.make, run_one, family.slow);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    std::printf("%s: %.0f s, %ld evaluations, %d carried across, energy grew by %.1e at most\n", family.name,
                taken.count(), outcomes.evaluations, outcomes.carried, outcomes.grown);
    for (const auto& [end, runs] : outcomes.ends) std::printf("  %5d %s\n", runs, end.c_str());
    for (const auto& [kind, events] : outcomes.events)
      std::printf("  %7ld %s\n", events, std::string(kind).c_str());
    CHECK(outcomes.ends.at("ended") >= family.slow * 99 / 100);
    across += outcomes.carried;
  }
  CHECK(across <= most_across);
}

}  // namespace

TEST_CASE("Runs from 10,000 random starts end, or say why they do not, and gain no energy", "[event][slow]") {
  if (has_sundials()) run_and_tell(families, 80);
}

TEST_CASE("Runs from 10,000 random starts of hard scenes end, or say why they do not", "[event][slow]") {
  if (has_sundials()) run_and_tell(hard_families, 10'000);
}

}  // namespace perp
