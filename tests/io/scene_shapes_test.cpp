#include <catch2/catch.hpp>

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

std::string with(const std::string& more) { return message_of(floor_and_brick + more); }

}  // namespace

TEST_CASE("shapes of a scene file give a body its mass and find its contacts", "[scene]") {
  const Scene s = read_scene(floor_and_brick, "s.toml");
  const Body& brick = s.model.body({1});
  CHECK(brick.mass == Approx(0.96));
  CHECK(brick.J(2, 2) == Approx(0.96 / 12 * (0.04 + 0.01)));
  REQUIRE(s.model.contacts().size() == 1);
  CHECK(s.model.contacts()[0].name == "ground.table|brick.box");
  CHECK(s.model.contacts()[0].mu == 0.3);
  Instant now;
  evaluate(s.model, s.start, now);
  CHECK(std::abs(now.gap_min()) < 1e-15);
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
    return read_scene(floor_and_brick + more, "s.toml").model.contacts().size();
  };
  CHECK(contacts("[[no_contact]]\na = \"ground\"\nb = \"brick\"\n") == 0);
  CHECK(contacts("[[joint]]\nname = \"hinge\"\nkind = \"revolute\"\na = \"ground\"\nb = \"brick\"\n") == 0);
  CHECK(contacts("[[no_contact]]\noverlapping = \"at the start\"\n") == 1);
  const Scene sunk = read_scene(floor_and_brick +
                                    "[[shape]]\nbody = \"brick\"\nkind = \"sphere\"\nradius = "
                                    "0.1\n[[no_contact]]\noverlapping = \"at the start\"\n",
                                "s.toml");
  CHECK(sunk.model.contacts().size() == 1);
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
