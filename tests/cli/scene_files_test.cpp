// perp check, perp scenes --toml, and scene files given to perp run.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/cli/program.hpp"

using namespace perp;
using Catch::Contains;
using Catch::StartsWith;

namespace {

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

const std::string examples = std::string(PERP_TEST_FOLDER) + "/../../examples/scenes/";

}  // namespace

TEST_CASE("a built-in scene printed as a file runs to the same bytes and prints itself again", "[check]") {
  const Scratch scratch("scene-files");
  const Outcome printed = run_perp(scratch, "scenes oblique-sphere --toml --set heading=0.3");
  REQUIRE(printed.status == 0);
  write(scratch / "s.toml", printed.out);
  CHECK(run_perp(scratch, "scenes " + (scratch / "s.toml") + " --toml").out == printed.out);
  const std::string rest = " --method lcp --step 0.01 --until 0.2 --out ";
  REQUIRE(run_perp(scratch, "run oblique-sphere --set heading=0.3" + rest + (scratch / "a")).status == 0);
  REQUIRE(run_perp(scratch, "run " + (scratch / "s.toml") + rest + (scratch / "b")).status == 0);
  for (const char* file : {"/trajectory.csv", "/contacts.csv", "/report.csv"})
    CHECK(contents((scratch / "a") + file) == contents((scratch / "b") + file));
}

TEST_CASE("perp check says what a scene has and that its start is consistent", "[check]") {
  const Scratch scratch("check");
  const Outcome belt = run_perp(scratch, "check " + examples + "box-on-belt.toml --set mu=0.7");
  CHECK(belt.status == 0);
  CHECK_THAT(belt.out, Contains("body belt: prescribed") &&
                           Contains("contact belt: box on belt, 8 points, mu = 0.7") &&
                           Contains("degrees of freedom 6"));
  CHECK_THAT(belt.out, Contains("the start is consistent"));
  const Outcome loop = run_perp(scratch, "check four-bar");
  CHECK_THAT(loop.out, Contains("degrees of freedom 1: 18 velocities, 20 joint equations of rank 17"));
}

TEST_CASE("perp check names joints that will contradict each other though they fit at the start", "[check]") {
  const Scratch scratch("check");
  const std::string file = scratch / "tied.toml";
  const auto write = [&](const char* tie) {
    std::ofstream(file)
        << "[[body]]\nname = 'slider'\nkind = 'spatial'\nmass = 1\n"
           "inertia = { shape = 'box', size = [0.1, 0.1, 0.1] }\n"
           "[[joint]]\nname = 'drive'\nkind = 'prismatic'\na = 'ground'\nb = 'slider'\naxis = [1, 0, 0]\n"
           "[[motor]]\njoint = 'drive'\nmotion = '0.1*sin(t)^2'\n"
        << tie;
  };
  write(
      "[[joint]]\nname = 'tie'\nkind = 'rod'\na = 'ground'\nb = 'slider'\npoint = [0, 1, 0]\npoint_b = [0, "
      "0, 0]\n");
  const Outcome bad = run_perp(scratch, "check " + file);
  CHECK(bad.status == 0);
  CHECK_THAT(bad.out, Contains("the start is consistent") && Contains("contradict each other at t = ") &&
                          Contains("'drive' by ") && Contains("'tie' by "));
  write("[[joint]]\nname = 'rail'\nkind = 'prismatic'\na = 'ground'\nb = 'slider'\naxis = [1, 0, 0]\n");
  CHECK_THAT(run_perp(scratch, "check " + file).out, !Contains("contradict"));  // redundant, and in agreement
}

TEST_CASE("perp check names what does not fit together at the start", "[check]") {
  const Scratch scratch("check-start");
  const Outcome sunk = run_perp(scratch, "check sunk-box");
  CHECK(sunk.status == 0);
  CHECK_THAT(sunk.out, Contains("inconsistent: contact floor.0 overlaps by 0.1 m") &&
                           Contains("the start is not consistent"));
  write(scratch / "open.toml",
        "[[body]]\nname = \"arm\"\nkind = \"planar\"\nmass = 1\ninertia = 1\nposition = [0, -1]\nstart = { "
        "position = [0, -1.5] }\n"
        "velocity = [2, 0]\n[[joint]]\nname = \"hinge\"\nkind = \"revolute\"\na = \"ground\"\nb = \"arm\"\n");
  const Outcome open = run_perp(scratch, "check " + (scratch / "open.toml"));
  CHECK_THAT(open.out, Contains("inconsistent: joint hinge is open by 0.5 m or rad") &&
                           Contains("inconsistent: joint hinge opens at 2 m/s"));
  write(scratch / "hit.toml",
        "[[body]]\nkind = \"particle\"\nmass = 1\nvelocity = [0, 0, -3]\n[[contact]]\nname = \"floor\"\na = "
        "\"ground\"\nb = \"body 1\"\n"
        "gap = { kind = \"particle_on_plane\" }\n");
  CHECK_THAT(run_perp(scratch, "check " + (scratch / "hit.toml")).out,
             Contains("inconsistent: contact floor is closed and closes at 3 m/s"));
}

TEST_CASE("a mistake in a scene file ends every command with status 2 and its place", "[check]") {
  const Scratch scratch("mistake");
  write(scratch / "bad.toml", "what = \"no mass\"\n[[body]]\nkind = \"particle\"\n");
  const std::vector<std::string> commands{
      "check SCENE", "run SCENE --method lcp --step 0.1 --out " + (scratch / "out"), "scenes SCENE --toml"};
  for (const std::string& command : commands) {
    std::string line = command;
    line.replace(line.find("SCENE"), 5, scratch / "bad.toml");
    const Outcome outcome = run_perp(scratch, line);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.err, StartsWith("perp: " + (scratch / "bad.toml") +
                                       ":2:1: a table without the key 'mass', needs it"));
    CHECK(outcome.out.empty());
  }
  CHECK_FALSE(std::filesystem::exists(scratch / "out"));
  CHECK_THAT(run_perp(scratch, "check " + examples + "box-on-belt.toml --set muu=1").err,
             Contains("did you mean mu?"));
  CHECK(run_perp(scratch, "check nothing").status == 2);
}

#ifdef PERP_HAS_URDFDOM

TEST_CASE("a robot's file is run, checked, studied and printed as a scene file that runs to the same bytes",
          "[check]") {
  const Scratch scratch("robot");
  const std::string robot = std::string(PERP_TEST_FOLDER) + "/../../examples/robots/arm.urdf";
  const Outcome check = run_perp(scratch, "check " + robot + " --set q.shoulder=1.2");
  CHECK(check.status == 0);
  CHECK(check.err.empty());
  CHECK_THAT(check.out,
             Contains("body forearm: spatial, 1.4 kg") && Contains("joint shoulder: ground to upper_arm") &&
                 Contains("not used: " + robot + ":12: effort in <limit> of joint 'shoulder'") &&
                 Contains("6 things of the file are not used") && Contains("the start is consistent"));
  const std::string rest = " --method lcp --step 0.01 --until 0.2 --out ", set = " --set q.shoulder=1.2 ";
  const Outcome run = run_perp(scratch, "run " + robot + set + rest + (scratch / "a"));
  CHECK(run.status == 0);
  CHECK_THAT(run.out, Contains("6 things of the file are not used: perp check lists them"));
  write(scratch / "arm.toml", run_perp(scratch, "scenes " + robot + set + " --toml").out);
  REQUIRE(run_perp(scratch, "run " + (scratch / "arm.toml") + rest + (scratch / "b")).status == 0);
  for (const char* file : {"/trajectory.csv", "/contacts.csv", "/joints.csv", "/report.csv"})
    CHECK(contents((scratch / "a") + file) == contents((scratch / "b") + file));
  CHECK(run_perp(scratch, "study " + robot + set +
                              " --methods lcp,ncp2 --steps 0.02,0.01,0.005 --until 0.2 --out " +
                              (scratch / "study"))
            .status == 0);
}

TEST_CASE("a robot's file with a mistake ends with status 2 and one line that says where", "[check]") {
  const Scratch scratch("bad-robot");
  write(scratch / "bad.urdf",
        "<robot name=\"r\">\n<link name=\"a\"/>\n<joint name=\"j\" type=\"fixed\">\n</joint></robot>\n");
  const Outcome bad = run_perp(
      scratch, "run " + (scratch / "bad.urdf") + " --method lcp --step 0.1 --out " + (scratch / "out"));
  CHECK(bad.status == 2);
  CHECK(bad.out.empty());
  CHECK_THAT(bad.err, StartsWith("perp: " + (scratch / "bad.urdf") + ":3:1: "));
  CHECK(std::count(bad.err.begin(), bad.err.end(), '\n') == 1);  // urdfdom prints nothing of its own
  CHECK(run_perp(scratch, "check nothing.urdf").status == 2);
}

#endif
