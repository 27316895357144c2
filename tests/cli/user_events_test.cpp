// perp run with events of the scene's, and runs read back from their folders.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "perp/io/saved_run.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/solve/friction_io.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "tests/cli/program.hpp"

namespace perp {
namespace {

void write(const std::string& file, const std::string& text) { std::ofstream(file) << text; }

const std::string falling =
    "t_end = 2\n[[body]]\nname = \"ball\"\nkind = \"particle\"\nmass = 1\nposition = [0, 0, 5]\n"
    "[[event]]\nname = \"half\"\nwhen = \"ball.z - 2.5\"\n"
    "[[event]]\nname = \"low\"\nwhen = \"ball.z - 1\"\ndirection = -1\nthen = \"stop\"\n";

}  // namespace

TEST_CASE("perp run ends where an event of the scene says so, with a whole run and a sentence", "[events]") {
  const std::string method = GENERATE("event", "ncp2 --step 1e-3", "lcp --step 1e-3");
  if (method == "event" && !has_sundials()) return;
  const Scratch scratch("user-events");
  write(scratch / "falls.toml", falling);
  const Outcome o = run_perp(
      scratch, "run " + (scratch / "falls.toml") + " --method " + method + " --out " + (scratch / "out"));
  CHECK(o.status == 0);
  CHECK(o.err.empty());
  CHECK_THAT(o.out, Catch::StartsWith("event 'low' ended the run at t = 0.90"));
  const double falls = std::sqrt(2 * 4 / 9.81), error = method[0] == 'l' ? 1e-3 : 1e-12;
  const auto events = columns(scratch / "out/events.csv");
  CHECK(events.at("kind") == std::vector<std::string>{"user", "user"});
  CHECK(events.at("contact") == std::vector<std::string>{"half", "low"});
  CHECK(std::abs(std::stod(events.at("t")[1]) - falls) < error);
  const auto rows = columns(scratch / "out/trajectory.csv");
  CHECK(rows.at("t").back() == events.at("t")[1]);
  CHECK(std::abs(std::stod(rows.at("ball.z").back()) - 1) < error);
  const auto json = nlohmann::json::parse(contents(scratch / "out/run.json"));
  CHECK(json.at("exit_status") == 0);
  CHECK_THAT(json.at("ended").get<std::string>(), Catch::StartsWith("ended by event 'low' at t = 0.90"));
  const Outcome again = run_perp(scratch, "run --resume " + (scratch / "out"));
  CHECK(again.status == 0);
  CHECK_THAT(again.out, Catch::Contains("is complete: ended by event 'low'"));
}

TEST_CASE("perp run looks at loads as often as it is asked to, and says how often that is", "[events]") {
  if (!has_sundials()) return;
  const Scratch scratch("look");
  write(scratch / "pushed.toml",
        "t_end = 30\ngravity = [0, 0, 0]\n[[body]]\nname = \"p\"\nkind = \"particle\"\nmass = 1\n"
        "[[force]]\nbody = \"p\"\nforce = [\"exp(-((t - 17.3)/1e-3)^2)\", 0, 0]\n");
  const std::string run = "run " + (scratch / "pushed.toml") + " --method event --out " + (scratch / "out");
  const Outcome plain = run_perp(scratch, run), looked = run_perp(scratch, run + " --look 1e-3");
  CHECK_THAT(plain.out, Catch::Contains("loads that change with time were looked at every 0.0073 s"));
  CHECK_THAT(looked.out, Catch::Contains("loads that change with time were looked at every 0.001 s"));
  const double v = std::stod(columns(scratch / "out/trajectory.csv").at("p.vx").back());
  CHECK(std::abs(v - 1e-3 * std::sqrt(std::numbers::pi)) < 1e-9);
  CHECK(nlohmann::json::parse(contents(scratch / "out/run.json")).at("run").at("look") == 1e-3);
  const Outcome none =
      run_perp(scratch, "run double-pendulum --until 0.1 --method event --out " + (scratch / "b"));
  CHECK_THAT(none.out, !Catch::Contains("--look"));
  CHECK_THAT(run_perp(scratch, run + " --look 0").err,
             Catch::Contains("--look is 0, needs to be positive [s]"));
  CHECK_THAT(
      run_perp(scratch, "run double-pendulum --method ncp2 --step 0.1 --look 1 --out " + (scratch / "c")).err,
      Catch::Contains("--look is 1, needs a method that chooses its steps: event"));
}

TEST_CASE("A run read back from its folder has the states of the run, between rows too", "[events]") {
  const std::string method = GENERATE("event", "ncp2"), format = GENERATE("csv", "hdf5");
  if ((method == "event" && !has_sundials()) || (format == "hdf5" && !has_hdf5())) return;
  const std::string name = GENERATE("heavy-top", "double-pendulum", "bouncing-ball");
  const Scratch scratch("saved-run");
  const bool adaptive = method == "event";
  const double until = 0.6, h = 5e-3;
  const Outcome o = run_perp(scratch, "run " + name + " --until 0.6 --method " + method +
                                          (adaptive ? " --tolerance 1e-10" : " --step 5e-3") + " --format " +
                                          format + " --out " + (scratch / "out"));
  REQUIRE(o.status == 0);
  const SavedRun saved = read_saved_run(scratch / "out");
  CHECK(saved.method == method);
  CHECK(saved.complete);
  CHECK(saved.ended == "reached T");
  const Scene s = load_scene(name);
  const auto stepper = make_stepper(method, {.tolerance = 1e-10});
  const Trajectory run = simulate(s.model, *stepper, s.start, {.t_end = until, .h = adaptive ? not_set : h});
  REQUIRE(saved.run.size() == run.size());
  REQUIRE(saved.run.events.size() == run.events.size());
  for (std::size_t i = 0; i < run.events.size(); ++i) {
    CHECK(saved.run.events[i].t == run.events[i].t);
    CHECK(saved.run.events[i].kind == run.events[i].kind);
    CHECK(saved.run.events[i].after == run.events[i].after);
  }
  for (std::size_t i = 0; i < run.size(); ++i) {
    CHECK(saved.run.state(i).q == run.state(i).q);
    CHECK((saved.run.state(i).nu - run.state(i).nu).norm() <= 1e-14 * run.state(i).nu.norm());
  }
  CHECK(saved.run.figures(3).energy == run.figures(3).energy);
  CHECK(saved.run.figures(3).h == run.figures(3).h);
  double error = 0;
  for (double t = 0.0123; t < until; t += 0.0171)
    error = std::max(error, (saved.run.at(t).q - run.at(t).q).norm());
  CAPTURE(method, name, error);
  CHECK(error < (adaptive ? 1e-8 : 1e-13));
}

TEST_CASE("States between every tenth row are of order 4 in the time between rows", "[events]") {
  const Scratch scratch("saved-order");
  const auto error_of = [&](const std::string& every) {
    const std::string out = scratch / every;
    const Outcome o = run_perp(scratch, "run double-pendulum --until 1 --method ncp2 --step 1e-3 --every " +
                                            every + " --out " + out);
    REQUIRE(o.status == 0);
    return read_saved_run(out).run;
  };
  const Trajectory all = error_of("1"), some = error_of("20"), few = error_of("40");
  double fine = 0, coarse = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    fine = std::max(fine, (some.at(all.t(i)).q - all.state(i).q).norm());
    coarse = std::max(coarse, (few.at(all.t(i)).q - all.state(i).q).norm());
  }
  const double order = std::log2(coarse / fine);
  CAPTURE(coarse, fine);
  CHECK(order > 3.7);
  CHECK(order < 4.3);
}

TEST_CASE("A folder that holds no run, or not that of its scene, is refused with its place", "[events]") {
  const Scratch scratch("saved-mistakes");
  CHECK_THROWS_WITH(read_saved_run(scratch / "nowhere"),
                    Catch::Contains("needs to be a folder that perp run wrote"));
  REQUIRE(run_perp(scratch, "run heavy-top --until 0.1 --method ncp2 --step 0.01 --out " + (scratch / "out"))
              .status == 0);
  const std::string file = scratch / "out/trajectory.csv", text = contents(file);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    const std::size_t at = other.find(from);
    REQUIRE(at != std::string::npos);
    write(file, other.replace(at, from.size(), to));
  };
  changed("top.vx", "top.ux");
  CHECK_THROWS_WITH(read_saved_run(scratch / "out"),
                    Catch::Contains("trajectory.csv: there is no column 'top.vx'"));
  changed("\n0.05,", "\n0.01,");
  CHECK_THROWS_WITH(read_saved_run(scratch / "out"),
                    Catch::Contains("row 6, column t: 0.01, needs to be no earlier"));
  changed("\n0.05,", "\n0.055,");
  CHECK_THROWS_WITH(read_saved_run(scratch / "out"),
                    Catch::Contains("needs to be that of the trajectory's row, 0.055"));
}

}  // namespace perp
