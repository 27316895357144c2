#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <locale>
#include <sstream>

#include "perp/instant/instant.hpp"
#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "scene_texts.hpp"

using namespace perp;
using Catch::Contains;
using Catch::StartsWith;

namespace {

const std::filesystem::path root = std::filesystem::path(PERP_TEST_FOLDER) / ".." / "..";

std::string contents(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The blocks between ```toml and ``` of a document.
std::vector<std::string> examples_in(const std::string& document) {
  std::vector<std::string> blocks;
  for (std::size_t at = 0; (at = document.find("```toml\n", at)) != std::string::npos;) {
    const std::size_t begin = at + 8;
    at = document.find("```\n", begin);
    blocks.push_back(document.substr(begin, at - begin));
  }
  return blocks;
}

/// A short run, up to where a step fails if one does.
Trajectory first_steps(const Scene& s, double until, double h) {
  LcpStepper lcp;
  NcpStepper ncp;
  Stepper& stepper = lcp.knows(s.model) ? static_cast<Stepper&>(lcp) : ncp;
  try {
    return simulate(s.model, stepper, s.start, {.t_end = until, .h = h});
  } catch (const StepFailure& failure) {
    return failure.trajectory;
  }
}

void check_same(const State& a, const State& b) {
  CHECK(a.t == b.t);
  REQUIRE(a.q.size() == b.q.size());
  CHECK(a.q == b.q);
  CHECK(a.nu == b.nu);
}

}  // namespace

TEST_CASE("every built-in scene reads back from its file to the same bits and prints the same file",
          "[scene_file]") {
  for (const std::string& name : scene_names()) {
    SceneParameters small;
    if (name == "pile" || name == "tower" || name == "arch") small = {{"count", 9}};
    const Scene built_in = scene(name, small);
    std::string text;
    try {
      text = write_scene(built_in);
    } catch (const std::invalid_argument& error) {
      CHECK_THAT(error.what(), StartsWith("scene '" + name + "': ") && Contains("which no file can say"));
      continue;
    }
    CAPTURE(name);
    const Scene again = read_scene(text, "file.toml");
    CHECK(write_scene(again) == text);
    CHECK(again.name == name);
    CHECK(again.t_end == built_in.t_end);
    check_same(again.start, built_in.start);
    check_same(again.model.rest(), built_in.model.rest());
    const Trajectory one = first_steps(built_in, 0.05, 0.01), other = first_steps(again, 0.05, 0.01);
    REQUIRE(one.size() == other.size());
    check_same(one.back(), other.back());
  }
}

TEST_CASE("all scenes of the seed's circle can be said in a file", "[scene_file]") {
  for (const char* name : {"seed-sphere",
                           "oblique-sphere",
                           "cross-incline",
                           "bouncing-ball",
                           "shaker",
                           "turntable",
                           "roller-in-cylinder",
                           "friction-pendulum",
                           "spring-block",
                           "heavy-top",
                           "slider-crank",
                           "bead-in-ring",
                           "rocking-block",
                           "painleve-rod",
                           "table",
                           "stack",
                           "four-bar",
                           "rolling-ellipse",
                           "rattleback",
                           "overhang",
                           "arch",
                           "card",
                           "euler-disk",
                           "peg"})
    CHECK_NOTHROW(write_scene(scene(name)));
}

TEST_CASE("set parameters reach the printed file", "[scene_file]") {
  const Scene again =
      read_scene(write_scene(scene("oblique-sphere", {{"heading", 0.7}, {"mu", 0.1}})), "f.toml");
  CHECK(again.model.contacts()[0].mu == 0.1);
  check_same(again.start, scene("oblique-sphere", {{"heading", 0.7}}).start);
  CHECK_THAT(again.what, Contains("(mu = 0.1, heading = 0.7)"));
}

TEST_CASE("every example of the document is a scene that runs and prints itself again", "[scene_file]") {
  const std::vector<std::string> blocks = examples_in(contents(root / "doc" / "scene-files.md"));
  REQUIRE(blocks.size() >= 8);
  for (const std::string& block : blocks) {
    CAPTURE(block);
    const Scene s = read_scene(block, "document.toml");
    CHECK(s.model.bodies().size() > 1);
    const std::string text = write_scene(s);
    const Scene again = read_scene(text, "document.toml");
    CHECK(write_scene(again) == text);
    if (s.model.nv() > 0)
      check_same(first_steps(s, 0.02, 0.005).back(), first_steps(again, 0.02, 0.005).back());
  }
}

TEST_CASE("the start of every example of the document is consistent", "[scene_file]") {
  for (const std::string& block : examples_in(contents(root / "doc" / "scene-files.md"))) {
    CAPTURE(block);
    const Scene s = read_scene(block, "document.toml");
    Instant now;
    evaluate(s.model, s.start, now);
    CHECK(now.joint_error() < 1e-15);
    CHECK(now.gap_min() > -1e-15);
    for (const JointRowInstant& row : now.joint_rows) CHECK(std::abs(row.velocity(s.start.nu)) < 1e-15);
  }
}
TEST_CASE("numbers are read alike in every locale", "[scene_file]") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::string text = with_ball("position = [1.5, 1e-3, -2_000.25]\nvelocity = [0x10, 1, 0]\n") +
                           "[[body]]\nkind = \"spatial\"\n";
  const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
  const std::string message = message_of(std::string(2000, '\n') + text);
  const Scene s = read_scene(text.substr(0, text.rfind("[[body]]")), "s.toml");
  const std::string written = write_scene(s);
  std::locale::global(before);
  CHECK(s.start.q.head<3>() == Vector3(1.5, 1e-3, -2000.25));
  CHECK(s.start.nu[0] == 16);
  CHECK_THAT(written, Contains("position = [1.5, 0.001, -2000.25]"));
  CHECK_THAT(message, StartsWith("s.toml:2008:1: "));
}

TEST_CASE("a scene is a built-in name or a file", "[scene_file]") {
  CHECK(load_scene("seed-sphere", {{"mu", 0.4}}).model.contacts()[0].mu == 0.4);
  CHECK(load_scene((root / "examples" / "scenes" / "box-on-belt.toml").string(), {{"mu", 0.1}})
            .model.contacts()[0]
            .mu == 0.1);
  CHECK_THROWS_WITH(load_scene("seed-spheer"), Contains("needs to be a file or one of seed-sphere, ") &&
                                                   Contains("(did you mean seed-sphere?)"));
  CHECK_THROWS_WITH(load_scene("nowhere/none.toml"),
                    StartsWith("nowhere/none.toml:1:1: a file that cannot be read"));
  CHECK_THROWS_WITH(load_scene(root.string() + "/"), Contains("a file that cannot be read"));
}

TEST_CASE("a scene with a gap of its own says which one no file can say", "[scene_file]") {
  Scene s = scene("seed-sphere");
  s.model.add_contact(ground, {1},
                      [](const Pose&, const Pose& X, double) { return ContactPoint{.gap = X.p.x()}; },
                      {.name = "wall"});
  CHECK_THROWS_WITH(
      write_scene(s),
      "scene 'seed-sphere': gap of contact 'wall' is a function of its own, which no file can say");
  Scene pushed = scene("seed-sphere");
  pushed.model.add_force({1}, [](const Model&, const State&) { return Wrench{}; });
  CHECK_THROWS_WITH(write_scene(pushed), Contains("force on 'ball'"));
}
