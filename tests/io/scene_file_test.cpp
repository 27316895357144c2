#include "perp/io/scene_file.hpp"

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
#include "perp/step/simulate.hpp"

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
  LcpStepper stepper;
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

std::string message_of(const std::string& text, const SceneParameters& set = {}) {
  try {
    static_cast<void>(read_scene(text, "s.toml", set));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "read";
}

/// A scene that a body's other lines and more tables make complete.
std::string with_ball(const std::string& more = "") {
  return "[[body]]\nname = \"ball\"\nkind = \"spatial\"\nmass = 1\ninertia = { shape = \"solid_sphere\", "
         "radius = 0.1 }\n" +
         more;
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

TEST_CASE("a parameter is a number, a quantity or an expression of those above it", "[scene_file]") {
  const std::string text =
      "[parameters]\nradius = \"50 mm\"\ndouble = \"2*radius\"\nmu = { value = 0.3, what = \"friction\" }\n" +
      with_ball("position = [0, 0, \"double + radius\"]\n");
  const Scene s = read_scene(text, "s.toml");
  CHECK(s.start.q[2] == 0.1 + 0.05);
  REQUIRE(s.parameters.size() == 3);
  CHECK(s.parameters[2].name == "mu");
  CHECK(s.parameters[2].value == 0.3);
  CHECK(s.parameters[2].what == "friction");
  CHECK(read_scene(text, "s.toml", {{"radius", 1}}).start.q[2] == 3);
  CHECK(read_scene(text, "s.toml", {{"double", 1}}).start.q[2] == 1.05);
  CHECK_THAT(message_of(text, {{"radus", 1}}), Contains("radus") && Contains("did you mean radius?"));
  CHECK_THAT(message_of(text, {{"mu", infinity}}), Contains("mu is inf"));
}

TEST_CASE("quantities come in SI units and only in those of what is measured", "[scene_file]") {
  const Scene s =
      read_scene("t_end = \"5 ms\"\n" +
                     with_ball("position = [\"3 mm\", \"1 cm\", \"2 km\"]\nvelocity = [\"36 km/h\", 0, 0]\n"
                               "angular_velocity = [0, 0, \"30 rpm\"]\n"),
                 "s.toml");
  CHECK(s.t_end == 0.005);
  CHECK(s.start.q.head<3>() == Vector3(0.003, 0.01, 2000));
  CHECK(s.start.nu[0] == 10);
  CHECK(s.start.nu[5] == Approx(M_PI).epsilon(1e-15));
  CHECK(message_of(with_ball("position = [0, \"1 kg\", 0]\n")) ==
        "s.toml:6:19: position has the unit 'kg', needs a length in one of m, km, cm, mm, um");
  CHECK(message_of("[parameters]\nr = \"1 kg\"\n" + with_ball("position = [\"r\", 0, 0]\n")) ==
        "s.toml:8:13: position is the parameter 'r', a mass, needs a length");
}

TEST_CASE("every shape gives its inertia", "[scene_file]") {
  const auto J = [](const std::string& inertia) -> Matrix3 {
    return read_scene("[[body]]\nkind = \"spatial\"\nmass = 2\ninertia = " + inertia, "s.toml")
        .model.bodies()[1]
        .J;
  };
  CHECK(J("{ shape = \"solid_sphere\", radius = 0.1 }") == Inertia::solid_sphere(2, 0.1).tensor());
  CHECK(J("{ shape = \"hollow_sphere\", radius = 0.1 }") == Inertia::hollow_sphere(2, 0.1).tensor());
  CHECK(J("{ shape = \"box\", size = [1, 2, 3] }") == Inertia::solid_box(2, {1, 2, 3}).tensor());
  CHECK(J("{ shape = \"cylinder\", radius = 0.1, length = 2 }") ==
        Inertia::solid_cylinder(2, 0.1, 2).tensor());
  CHECK(J("{ shape = \"ellipsoid\", semi_axes = [1, 2, 3] }") ==
        Inertia::solid_ellipsoid(2, {1, 2, 3}).tensor());
  CHECK(J("{ moments = [1, 2, 2.5] }") == Inertia::principal(2, {1, 2, 2.5}).tensor());
  Matrix3 tensor;
  tensor << 2, -0.1, 0, -0.1, 3, 0.2, 0, 0.2, 4;
  CHECK(J("{ tensor = [[2, -0.1, 0], [-0.1, 3, 0.2], [0, 0.2, 4]] }") == tensor);
}

TEST_CASE("a body starts at its position unless start says otherwise", "[scene_file]") {
  const Scene s = read_scene(with_ball("position = [1, 2, 3]\nstart = { position = [4, 5, 6] }\n"
                                       "orientation = { axis = [0, 0, 2], angle = \"90 deg\" }\n"
                                       "angular_velocity = [1, 0, 0]\n"),
                             "s.toml");
  CHECK(s.model.bodies()[1].rest.p == Vector3(1, 2, 3));
  CHECK(s.start.q.head<3>() == Vector3(4, 5, 6));
  CHECK(s.model.pose(s.start, {1}).q.angularDistance(rotation({0, 0, M_PI / 2})) < 1e-15);
  CHECK((s.model.angular_velocity(s.start, {1}) - Vector3(1, 0, 0)).norm() < 1e-15);
  CHECK((s.start.nu.tail<3>() - Vector3(0, -1, 0)).norm() < 1e-15);  // body axes
  const Scene turned = read_scene(
      "[[body]]\nkind = \"planar\"\nmass = 1\ninertia = 1\nangle = 7\nstart = { angle = -8 }", "s.toml");
  CHECK(turned.start.q[2] == -8);  // whole turns count
}

TEST_CASE("the velocity of a motion in expressions or a table is the derivative of its pose",
          "[scene_file]") {
  const std::string motion = GENERATE(
      "{ kind = \"function\", position = [\"0.1*sin(3*t)\", \"t^2\", \"exp(-t)\"], rotation = [\"t\", "
      "\"0.3*t^2\", \"cos(2*t)\"] }",
      "{ kind = \"table\", t = [0, 0.3, 0.5, 1], position = [[0, 0, 0], [1, 2, 3], [0, 1, 0], [0, 0, 1]], "
      "rotation = [[0, 0, 0], "
      "[1, 0, 0.2], [1, 1, 0], [0, 1, 0]] }",
      "{ kind = \"shaker\", amplitude = [0.1, 0, 0.2], rate = 5, phase = 0.3 }",
      "{ kind = \"turntable\", axis = [1, 2, 3], rate = 2 }");
  const Scene s = read_scene(
      "[[body]]\nkind = \"prescribed\"\nposition = [1, 2, 3]\norientation = { axis = [1, 1, 0], angle = 0.4 "
      "}\nmotion = " +
          motion,
      "s.toml");
  const PrescribedMotion& m = s.model.bodies()[1].motion;
  for (const double t : {-0.2, 0.0, 0.1, 0.3, 0.42, 0.9, 1.3}) {
    const double h = 1e-5;
    const Pose before = m.pose(t - h), after = m.pose(t + h);
    CAPTURE(motion, t);
    CHECK(((after.p - before.p) / (2 * h) - m.twist(t).v).norm() < 1e-7);
    CHECK((rotation_vector(after.q * before.q.conjugate()) / (2 * h) - m.twist(t).w).norm() < 1e-7);
  }
}

TEST_CASE("a table's motion passes through its points without a jump of its acceleration", "[scene_file]") {
  const Scene s = read_scene(
      "[[body]]\nkind = \"prescribed\"\nmotion = { kind = \"table\", t = [0, 0.4, 0.5, 1], position = [[0, "
      "0, 0], [1, 0, 3], [0, 1, 0], [0, 0, 1]] }",
      "s.toml");
  const PrescribedMotion& m = s.model.bodies()[1].motion;
  CHECK((m.pose(0.4).p - Vector3(1, 0, 3)).norm() < 1e-15);
  CHECK((m.pose(1).p - Vector3(0, 0, 1)).norm() < 1e-15);
  const double h = 1e-4;
  for (const double t : {0.0, 0.4, 0.5, 1.0}) {  // the acceleration from both sides
    const Vector3 left = (m.twist(t).v - m.twist(t - h).v) / h, right = (m.twist(t + h).v - m.twist(t).v) / h;
    CAPTURE(t);
    CHECK((left - right).norm() < 1.0);  // its slope times h; a jump would be about 1000
  }
  CHECK((m.twist(2).v - m.twist(1).v).norm() == 0);  // straight on
}

TEST_CASE("a belt's surface may run faster and faster", "[scene_file]") {
  const Scene s = read_scene(
      "[[body]]\nkind = \"prescribed\"\nmotion = { kind = \"function\", surface = [\"2*t\", 0, 0] }",
      "s.toml");
  CHECK(s.model.bodies()[1].motion.surface(3, Vector3::Zero()) == Vector3(6, 0, 0));
  CHECK(s.model.bodies()[1].motion.pose(3).p == Vector3::Zero());
}

TEST_CASE("forces depend on time and on the body's own motion, and act where they are said to",
          "[scene_file]") {
  const Scene s =
      read_scene("[parameters]\nk = 4\n" +
                     with_ball("position = [1, 2, 3]\nvelocity = [4, 5, 6]\nangular_velocity = [7, 8, 9]\n"
                               "[[force]]\nbody = \"ball\"\nforce = [\"-k*x + t\", \"vy*z\", \"wx + "
                               "1\"]\nmoment = [\"wz\", 0, \"y\"]\n"
                               "at = [0, 0, 0.5]\n"),
                 "s.toml");
  State x = s.start;
  x.t = 10;
  const Wrench w = s.model.forces()[0].wrench(s.model, x);
  CHECK(w.force == Vector3(6, 15, 8));
  CHECK(w.moment == Vector3(9, 0, 2) + Vector3(0, 0, 0.5).cross(Vector3(6, 15, 8)));
}

TEST_CASE("a planar body's force and moment are in its plane", "[scene_file]") {
  const Scene s = read_scene(
      "[[body]]\nname = \"disc\"\nkind = \"planar\"\nmass = 1\ninertia = 1\nangle = 0.3\nangular_velocity = "
      "2\n"
      "[[force]]\nbody = \"disc\"\nforce = [\"angle\", 1]\nmoment = \"-3*omega\"\n",
      "s.toml");
  const Wrench w = s.model.forces()[0].wrench(s.model, s.start);
  CHECK(w.force == Vector3(0.3, 1, 0));
  CHECK(w.moment == Vector3(0, 0, -6));
}

TEST_CASE("each mistake is said with its place, what was found and what is allowed", "[scene_file]") {
  CHECK_THAT(message_of(with_ball("mas = 1\n")),
             StartsWith("s.toml:6:1: the key 'mas', needs one of name, kind, mass, ") &&
                 Contains("(did you mean mass?)"));
  CHECK(message_of("[[body]]\nkind = \"spatial\"\n") ==
        "s.toml:1:1: a table without the key 'mass', needs it");
  CHECK(message_of("[[body]]\nkind = \"spatail\"\n") ==
        "s.toml:2:8: kind is 'spatail', needs one of spatial, planar, particle, prescribed (did you mean "
        "spatial?)");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = -1\n") ==
        "s.toml:3:8: add_particle: mass is -1, needs to be positive [kg]");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = \"heavy\"\n")
            .starts_with("s.toml:3:9: mass has the name 'heavy', needs one of pi, sin"));
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = [1]\n") ==
        "s.toml:3:8: mass is a list of 1, needs a mass: a number or a text with an expression");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = \"1 + (2\"\n") ==
        "s.toml:3:15: mass has the end of the expression, needs ')'");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = \"1/0\"\n") ==
        "s.toml:3:8: mass = inf, needs to be finite");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = inf\n") ==
        "s.toml:3:8: inf, needs to be a finite number that double can hold");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = 1\nposition = [1, 2, 3, 4]\n") ==
        "s.toml:4:12: position is a list of 4, needs a list of 3 numbers, or of 2 in the xy plane");
  CHECK(message_of("gravity = 9.81\n") ==
        "s.toml:1:11: gravity is the number 9.81, needs a list of 3 numbers, or of 2 in the xy plane");
  CHECK(message_of("t_end = -1\n") == "s.toml:1:9: the time -1, needs to be positive [s]");
  CHECK(message_of(with_ball("[[body]]\nname = \"ball\"\nkind = \"particle\"\nmass = 1\n")) ==
        "s.toml:7:8: add_particle: name is ball, is taken already");
  CHECK(
      message_of(with_ball(
          "[[contact]]\na = \"ground\"\nb = \"bal\"\ngap = { kind = \"sphere_on_plane\", radius = 1 }\n")) ==
      "s.toml:8:5: b is the body 'bal', needs one of ground, ball (did you mean ball?)");
  CHECK(message_of(with_ball("[[contact]]\na = \"ground\"\nb = \"ball\"\ngap = { kind = \"sphere_on_plane\", "
                             "radius = -1 }\n")) ==
        "s.toml:9:44: sphere_on_plane: radius is -1, needs to be positive and finite [m]");
  CHECK(message_of(with_ball("[[contact]]\na = \"ground\"\nb = \"ball\"\nmu = -1\ngap = { kind = "
                             "\"sphere_on_plane\", radius = 1 }\n")) ==
        "s.toml:9:6: contact 'contact 1': mu is -1, needs to be >= 0 and finite");
  CHECK_THAT(
      message_of(with_ball("[[joint]]\nkind = \"ball\"\na = \"ground\"\nb = \"ball\"\nfriction = 1\n")),
      StartsWith("s.toml:10:12: joint 'joint 1': friction is 1, needs a joint"));
  CHECK_THAT(message_of(with_ball("[[body]]\nkind = \"prescribed\"\nmotion = { kind = \"function\", position "
                                  "= [\"step(t)\", 0, 0] }\n")),
             StartsWith("s.toml:8:42: the expression \"step(t)\" with a step"));
  CHECK_THAT(
      message_of("[parameters]\nx = 1\n" + with_ball("[[force]]\nbody = \"ball\"\nforce = [\"x\", 0, 0]\n")),
      StartsWith("s.toml:10:9: the parameter 'x', needs another name"));
  CHECK_THAT(message_of("[parameters]\nsin = 1\n"),
             StartsWith("s.toml:2:1: the parameter 'sin', needs a name"));
  CHECK_THAT(message_of("[body]\nkind = \"particle\"\n"),
             StartsWith("s.toml:1:1: body is a table, needs tables, each under the line [[body]]"));
  CHECK_THAT(message_of("mass = 1\n[[body]]\nkind = \"particle\"\nmass = 1\n"),
             StartsWith("s.toml:1:1: the key 'mass', needs one of name, what"));
}

TEST_CASE("what is not TOML is refused with its line and column", "[scene_file]") {
  CHECK_THAT(message_of("name = \n"), StartsWith("s.toml:1:"));
  CHECK_THAT(message_of("\n\nname \"a\"\n"), StartsWith("s.toml:3:"));
  CHECK_THAT(message_of("[[body]]\nkind = \"particle\"\nmass = [1, 2\n"),
             StartsWith("s.toml:4:1: missing array separator"));
  CHECK(message_of("t_end = 1\nt_end = 2\n") ==
        "s.toml:2:9: value (\"t_end\") already exists: value defined twice, needs to be TOML");
  CHECK_THAT(message_of("what = \"a"), StartsWith("s.toml:1:"));
  CHECK_THAT(message_of(std::string("what = \"a\0b\"", 12)), StartsWith("s.toml:1:10: the byte 0, "));
  CHECK_THAT(message_of("\xff\xfe"), StartsWith("s.toml:1:1: the byte 255, "));
  CHECK_THAT(message_of(std::string(100000, '[')),
             StartsWith("s.toml:1:33: tables or lists that nest deeper than 32"));
  CHECK_THAT(message_of("x = " + std::string(100000, '[')), Contains("nest deeper than 32"));
  std::string dots = "a";
  for (int i = 0; i < 100000; ++i) dots += ".a";
  CHECK_THAT(message_of(dots + " = 1"), Contains("nest deeper than 32"));
  CHECK_THAT(message_of(std::string(100'000'001, ' ')), Contains("100 MB at most"));
  CHECK_THAT(message_of("[[body]]\nkind = \"a\\nb\"\n"),
             StartsWith("s.toml:2:8: kind is 'a b', needs one of"));
  CHECK(message_of("") == "read");
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

namespace {

/// Every kind of joint with a stop, a motor, a motion and a spring, as the file that says it.
const char* const many_joints = R"(
[[body]]
name = "a"
kind = "spatial"
mass = 1
inertia = { shape = "solid_sphere", radius = 1 }
[[body]]
name = "b"
kind = "spatial"
mass = 1
inertia = { shape = "solid_sphere", radius = 1 }
position = [1, 2, 3]
[[joint]]
name = "pipe"
kind = "cylindrical"
a = "a"
b = "b"
axis = [1, 1, 0]
[[joint]]
name = "cross"
kind = "universal"
a = "a"
b = "b"
axis_b = [0, 2, 0]
[[joint]]
name = "table"
kind = "planar"
a = "a"
b = "b"
[[joint]]
name = "thread"
kind = "screw"
a = "a"
b = "b"
lead = "2 mm"
friction = 0.5
[[joint]]
name = "strut"
kind = "rod"
a = "a"
b = "b"
point_b = [1, 0, 0]
[[joint]]
name = "teeth"
kind = "gear"
a = "a"
b = "b"
axis_b = [1, 0, 0]
ratio = -2
[[limit]]
joint = "pipe"
coordinate = "slide"
lower = "-1 cm"
upper = 0.25
e = 0.5
[[limit]]
joint = "thread"
upper = "90 deg"
[[motor]]
joint = "pipe"
coordinate = "angle"
effort = "sin(t) - 2*coordinate - 3*rate"
[[motor]]
joint = "cross"
coordinate = "angle_b"
motion = "0.1*t^2"
[[joint_spring]]
joint = "thread"
stiffness = 3
damping = 0.2
rest = 0.1
)";

}  // namespace

TEST_CASE("scene files say every kind of joint, stops, motors and springs, and write them back",
          "[scene_file]") {
  const Scene s = read_scene(many_joints, "s.toml");
  const Model& model = s.model;
  REQUIRE(model.joints().size() == 6);
  CHECK(model.joint({3}).asked.lead == 0.002);
  CHECK(model.joint({3}).friction == 0.5);
  CHECK(model.joint({5}).asked.ratio == -2);
  REQUIRE(model.contacts().size() == 3);
  CHECK(model.contacts()[0].name == "pipe.slide.lower");
  CHECK(model.contacts()[0].stop.limit == -0.01);
  CHECK(model.contacts()[1].stop.limit == 0.25);
  CHECK(model.contacts()[1].e == 0.5);
  CHECK(model.contacts()[2].name == "thread.upper");
  REQUIRE(model.motors().size() == 1);
  CHECK(model.motors()[0].effort(model, s.start, 1, 1) == -5);
  REQUIRE(model.joint({1}).motions[1].has_value());
  CHECK(model.joint({1}).motions[1]->rate(3) == Approx(0.6));
  CHECK(model.joint({1}).motions[1]->acceleration_at(3) == Approx(0.2));
  REQUIRE(model.joint_springs().size() == 1);
  CHECK(model.joint_springs()[0].rest == 0.1);
  const std::string text = write_scene(s);
  CHECK(write_scene(read_scene(text, "again.toml")) == text);
}

TEST_CASE("mistakes in joints, stops and motors are named with their place", "[scene_file]") {
  const auto message = [](const std::string& more) {
    try {
      (void)read_scene(many_joints + more, "s.toml");
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(message("[[limit]]\njoint = \"pip\"\n"),
             Contains("s.toml:73:9: ") && Contains("did you mean pipe?"));
  CHECK_THAT(message("[[limit]]\njoint = \"pipe\"\nupper = 1\n"), Contains("coordinate"));
  CHECK_THAT(message("[[limit]]\njoint = \"strut\"\nupper = 1\n"), Contains("has a coordinate"));
  CHECK_THAT(message("[[limit]]\njoint = \"thread\"\nlower = 2\nupper = 1\n"),
             Contains("s.toml:74:9: ") && Contains("<= upper"));
  CHECK_THAT(message("[[motor]]\njoint = \"thread\"\n"), Contains("neither effort nor motion"));
  CHECK_THAT(message("[[motor]]\njoint = \"thread\"\nmotion = \"step(t)\"\n"), Contains("continuous"));
  CHECK_THAT(message("[[joint]]\nkind = \"ball\"\na = \"a\"\nb = \"b\"\nlead = 1\n"),
             Contains("the key 'lead'"));
}
