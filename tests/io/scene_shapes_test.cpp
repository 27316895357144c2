#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <set>

#include "perp/instant/instant.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "scene_texts.hpp"

using namespace perp;
using Catch::Contains;

namespace {

const std::string floor_and_brick = R"([parameters]
x = 0
[[body]]
name = "brick"
kind = "spatial"
position = ["x", 0, 0.01]
[[shape]]
body = "brick"
kind = "box"
size = [0.2, 0.1, 0.02]
material = "clay"
density = 2400
[[shape]]
body = "ground"
kind = "box"
name = "table"
size = [2, 1, 0.4]
position = [-1, 0, -0.2]
material = "wood"
[[material_pair]]
a = "clay"
b = "wood"
mu = 0.3
)";

/// Pairs of bodies that have a gap at the start.
std::size_t pairs_in_sight(const Scene& s) {
  Instant now;
  evaluate(s.model, s.start, now);
  std::set<int> contacts;
  for (const ContactInstant& c : now.contacts) contacts.insert(c.contact);
  return contacts.size();
}

std::string with(const std::string& more) { return message_of(floor_and_brick + more); }

}  // namespace

TEST_CASE("shapes of a scene file give a body its mass and find its contacts", "[scene]") {
  const Scene s = read_scene(floor_and_brick, "s.toml");
  const Body& brick = s.model.body({1});
  CHECK(brick.mass == Approx(0.96));
  CHECK(brick.J(2, 2) == Approx(0.96 / 12 * (0.04 + 0.01)));
  CHECK(pairs_in_sight(s) == 1);
  Instant now;
  evaluate(s.model, s.start, now);
  CHECK(std::abs(now.gap_min()) < 1e-15);
  for (const ContactInstant& c : now.contacts) {
    CHECK(c.mu == 0.3);
    CHECK_THAT((*s.model.point_names())[static_cast<std::size_t>(c.point)],
               Catch::StartsWith("ground.table|brick.box|"));
  }
}

TEST_CASE("a brick over a table's edge rests while its centre is a millionth inside, and tips off outside",
          "[scene]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2");
  INFO(method);
  for (const double x : {-1e-6, 1e-6}) {
    const Scene s = read_scene(floor_and_brick, "s.toml", {{"x", x}});
    const auto stepper = make_stepper(method);
    const Trajectory run = simulate(s.model, *stepper, s.start, {.t_end = x < 0 ? 1.5 : 2.5, .h = 0.005});
    const double start = s.model.energy(s.start), end = s.model.energy(run.back());
    const double z = s.model.position(run.back(), {1}).z();
    CHECK(end <= start + 1e-6);
    if (x < 0)
      CHECK(std::abs(z - 0.01) < 1e-9);
    else
      CHECK(z < -0.1);
  }
}

TEST_CASE("joined, listed and overlapping shapes have no contact", "[scene]") {
  const auto contacts = [](const std::string& more) {
    return pairs_in_sight(read_scene(floor_and_brick + more, "s.toml"));
  };
  CHECK(contacts("") == 1);
  CHECK(contacts("[[no_contact]]\na = \"ground\"\nb = \"brick\"\n") == 0);
  CHECK(contacts("[[joint]]\nname = \"hinge\"\nkind = \"revolute\"\na = \"ground\"\nb = \"brick\"\n") == 0);
  CHECK(contacts("[[no_contact]]\noverlapping = \"at the start\"\n") == 1);
  const Scene sunk = read_scene(floor_and_brick +
                                    "[[shape]]\nbody = \"brick\"\nkind = \"sphere\"\nradius = "
                                    "0.1\n[[no_contact]]\noverlapping = \"at the start\"\n",
                                "s.toml");
  CHECK(pairs_in_sight(sunk) == 1);
  REQUIRE(sunk.unused.size() == 1);
  CHECK_THAT(sunk.unused[0], Contains("ground.table|brick.sphere") && Contains("overlap at the start"));
}

TEST_CASE("a planar body has planar shapes", "[scene]") {
  const Scene s = read_scene(R"(gravity = [0, -9.81]
[[body]]
name = "roof"
kind = "planar"
position = [0, 1.5]
[[shape]]
body = "roof"
kind = "polygon"
vertices = [[-1, -1], [1, -1], [0, 2]]
density = 3
[[shape]]
body = "ground"
kind = "line"
)",
                             "s.toml");
  CHECK(s.model.body({1}).mass == Approx(9));
  Instant now;
  evaluate(s.model, s.start, now);
  CHECK(now.gap_min() == Approx(0.5));
}

TEST_CASE("mistakes in shapes are placed by line and key", "[scene]") {
  CHECK_THAT(with("[[shape]]\nbody = \"brick\"\nkind = \"sphere\"\nradius = -1\n"),
             Contains("s.toml:27:") && Contains("radius"));
  CHECK_THAT(with("[[shape]]\nbody = \"brick\"\nkind = \"sfere\"\nradius = 1\n"),
             Contains("s.toml:26:") && Contains("sfere"));
  CHECK_THAT(with("[[shape]]\nbody = \"brik\"\nkind = \"sphere\"\nradius = 1\n"),
             Contains("s.toml:25:") && Contains("brik"));
  CHECK_THAT(with("[[shape]]\nbody = \"brick\"\nkind = \"sphere\"\nradius = 1\nsize = 2\n"),
             Contains("s.toml:28:") && Contains("size"));
  CHECK_THAT(with("[[material_pair]]\na = \"clay\"\nb = \"wod\"\n"),
             Contains("s.toml:26:") && Contains("wod"));
  CHECK_THAT(with("[[shape]]\nbody = \"brick\"\nkind = \"box\"\nsize = [1, 1, 1]\nposition = [1, 0, "
                  "0]\ndensity = 1\n"),
             Contains("centre of mass"));
  CHECK_THAT(message_of("[[body]]\nname = \"a\"\nkind = \"spatial\"\n"), Contains("mass"));
  CHECK_THAT(message_of("[[body]]\nname = \"a\"\nkind = \"spatial\"\n[[shape]]\nbody = \"a\"\nkind = "
                        "\"sphere\"\nradius = 1\n"),
             Contains("density"));
}

TEST_CASE("a gear whose wheel sits on a moving arm is refused by name", "[scene]") {
  const auto body = [](const std::string& name) {
    return "[[body]]\nname = \"" + name +
           "\"\nkind = \"spatial\"\nmass = 1\ninertia = { moments = [1, 1, 1] }\n";
  };
  const auto joint = [](const std::string& kind, const std::string& a, const std::string& b) {
    return "[[joint]]\nname = \"" + a + b + "\"\nkind = \"" + kind + "\"\na = \"" + a + "\"\nb = \"" + b +
           "\"\n";
  };
  const std::string wheels = body("arm") + body("planet") + body("sun") + joint("revolute", "ground", "arm") +
                             joint("revolute", "ground", "sun");
  const std::string gear = joint("gear", "sun", "planet") + "ratio = -2\n";
  CHECK(message_of(wheels + joint("revolute", "ground", "planet") + gear) == "read");
  CHECK_THAT(message_of(wheels + joint("revolute", "arm", "planet") + gear),
             Contains("'planet'") && Contains("'arm'") && Contains("axle that does not move"));
}

TEST_CASE("a scene of shapes is written as a file that makes the same scene", "[scene]") {
  const Scene spatial = read_scene(floor_and_brick + R"([[body]]
name = "wedge"
kind = "spatial"
position = [0, 2, 1]
[[shape]]
body = "wedge"
name = "left"
kind = "polyhedron"
vertices = [[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1], [0.1, 0.1, 0.01], [0.3, 0.2, 0], [0, 0.2, 0.1]]
density = 1000
material = "clay"
position = [0.1, 0, 0]
[[shape]]
body = "wedge"
name = "right"
kind = "polyhedron"
vertices = [[0, 0, 0], [-0.3, 0, 0], [0, -0.2, 0], [0, 0, 0.1], [-0.3, -0.2, 0], [0, -0.2, 0.1]]
density = 1000
position = [-0.1, 0, 0]
orientation = { axis = [0, 0, 1], angle = 0 }
[[shape]]
body = "wedge"
kind = "capsule"
radius = 0.05
length = 0.3
position = [0, 0, 0.2]
orientation = { axis = [1, 2, 0], angle = 0.3 }
[[shape]]
body = "wedge"
kind = "sphere"
radius = 0.1
[[shape]]
body = "brick"
name = "knob"
kind = "sphere"
radius = 0.013
[[no_contact]]
a = "wedge.sphere"
b = "ground.table"
[[no_contact]]
a = "wedge.sphere"
b = "brick.box"
[[no_contact]]
overlapping = "at the start"
)",
                                   "s.toml");
  CHECK(spatial.model.shapes().size() == 7);
  CHECK(spatial.model.shapes_apart().size() == 3);
  const std::string text = write_scene(spatial);
  const Scene again = read_scene(text, "again.toml");
  CHECK(write_scene(again) == text);
  CHECK(again.model.contact_points() == spatial.model.contact_points());
  CHECK(*again.model.point_names() == *spatial.model.point_names());
  CHECK(again.model.shapes_apart() == spatial.model.shapes_apart());
  const auto stepper = make_stepper("lcp");
  const SimulateOptions options{.t_end = 1, .h = 0.01};
  CHECK(simulate(spatial.model, *stepper, spatial.start, options).back().q ==
        simulate(again.model, *stepper, again.start, options).back().q);
}

TEST_CASE("a planar scene of shapes is written as it was read", "[scene]") {
  const Scene s = read_scene(R"(gravity = [0, -9.81]
[[body]]
name = "roof"
kind = "planar"
position = [0, 1.5]
[[shape]]
body = "roof"
kind = "polygon"
vertices = [[-1, -1], [1, -1], [0, 2]]
density = 3
[[body]]
name = "wheel"
kind = "planar"
position = [4, 1]
[[shape]]
body = "wheel"
kind = "disc"
radius = 1
density = 2
material = "rubber"
[[shape]]
body = "ground"
kind = "line"
material = "road"
[[shape]]
body = "ground"
kind = "box"
width = 1
height = 0.5
angle = 0.1
position = [9, 0]
[[material_pair]]
a = "road"
b = "rubber"
mu = 0.7
e = 0.25
[[no_contact]]
a = "roof"
b = "wheel"
)",
                             "s.toml");
  const std::string text = write_scene(s);
  CHECK(write_scene(read_scene(text, "s.toml")) == text);
  CHECK_THAT(text, Contains("mu = 0.7") && Contains("a = \"roof\"\nb = \"wheel\""));
}

TEST_CASE("a pair of shapes that do not touch is named by body and shape", "[scene]") {
  CHECK_THAT(with("[[no_contact]]\na = \"brick.box\"\nb = \"ground\"\n"),
             Contains("s.toml:26:") && Contains("'ground'") && Contains("BODY.SHAPE"));
  CHECK_THAT(with("[[no_contact]]\na = \"brick.ball\"\nb = \"ground.table\"\n"),
             Contains("s.toml:25:") && Contains("brick.ball") && Contains("needs to be one of: box"));
  CHECK(read_scene(floor_and_brick + "[[no_contact]]\na = \"brick.box\"\nb = \"ground.table\"\n", "s.toml")
            .model.shapes_apart()
            .size() == 1);
}

TEST_CASE("superquadrics, ellipses, formulas and hulls of mesh files are shapes of a file", "[scene]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "perp-scene-shapes-test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "t.obj")
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const Scene s = read_scene(R"([parameters]
R = 1
[[body]]
name = "pebble"
kind = "spatial"
position = [0, 0, 5]
[[shape]]
body = "pebble"
kind = "superquadric"
semi_axes = [0.3, 0.2, 0.1]
exponents = [0.8, 1.2]
density = 1000
[[body]]
name = "tip"
kind = "spatial"
position = [5, 0, 5]
[[shape]]
body = "tip"
kind = "polyhedron"
file = "t.obj"
density = 6
[[body]]
name = "marble"
kind = "spatial"
position = [0.3, 0, 0]
[[shape]]
body = "marble"
kind = "sphere"
radius = 0.1
density = 1000
[[shape]]
body = "ground"
kind = "formula"
f = "R^2 - x^2 - y^2 - z^2"
[[no_contact]]
a = "ground"
b = "pebble"
[[no_contact]]
a = "ground"
b = "tip"
[[no_contact]]
a = "tip"
b = "pebble"
)",
                             (folder / "s.toml").string());
  CHECK(s.model.body({2}).mass == Approx(1));
  Instant now;
  evaluate(s.model, s.start, now);
  double least = infinity;
  for (const ContactInstant& c : now.contacts)
    if (c.W.a == 0 && c.W.b == 3) least = std::min(least, c.psi_n);
  CHECK(least == Approx(0.6).epsilon(1e-12));
  const std::string text = write_scene(s);
  CHECK(write_scene(read_scene(text, "again.toml")) == text);
  CHECK_THAT(message_of("[[shape]]\nbody = \"ground\"\nkind = \"polyhedron\"\nfile = \"none.stl\"\n"),
             Contains("none.stl"));
  CHECK_THAT(message_of("[[shape]]\nbody = \"ground\"\nkind = \"formula\"\nf = \"x +\"\n"),
             Contains("s.toml:4:"));
}

TEST_CASE("a gap's shapes stand in their bodies where a file places them", "[scene]") {
  const Scene s = read_scene(R"([[body]]
name = "ball"
kind = "spatial"
mass = 1
inertia = { shape = "solid_sphere", radius = 0.1 }
position = [0, 0, 2]
[[contact]]
a = "ground"
b = "ball"
gap = { kind = "sphere_on_sphere", radius_a = 0.5, radius_b = 0.1, place_a = { position = [0, 0, 0.1] }, place_b = { position = [0, 0, 0.25] } }
)",
                             "s.toml");
  Instant now;
  evaluate(s.model, s.start, now);
  CHECK(now.gap_min() == Approx(2.25 - 0.1 - 0.6));
  CHECK(write_scene(read_scene(write_scene(s), "again.toml")) == write_scene(s));
}
