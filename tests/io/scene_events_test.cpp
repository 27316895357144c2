// [[event]] of scene files: what may stand there, what it means, and what is refused.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/io/scene_file.hpp"
#include "scene_texts.hpp"

using namespace perp;
using Catch::Contains;
using Catch::StartsWith;

namespace {

const std::string bodies =
    "[[body]]\nname = \"cube\"\nkind = \"spatial\"\nmass = 2\ninertia = { shape = \"box\", size = [1, 1, 1] "
    "}\n"
    "position = [1, 2, 3]\nvelocity = [4, 5, 6]\nangular_velocity = [0.1, 0.2, 0.3]\norientation = { axis = "
    "[0, 0, "
    "1], angle = 1 }\n"
    "[[body]]\nname = \"rod\"\nkind = \"planar\"\nmass = 1\ninertia = 1\nposition = [7, 8]\nangle = 0.5\n"
    "velocity = [9, 10]\nangular_velocity = 11\n"
    "[[body]]\nname = \"dot\"\nkind = \"particle\"\nmass = 1\nposition = [12, 13, 14]\nvelocity = [15, 16, "
    "17]\n"
    "[[joint]]\nname = \"slide\"\nkind = \"cylindrical\"\na = \"ground\"\nb = \"cube\"\npoint = [1, 2, "
    "3]\naxis = "
    "[0, 0, 1]\n"
    "[[joint]]\nname = \"pin\"\nkind = \"revolute\"\na = \"ground\"\nb = \"rod\"\npoint = [7, 8, 0]\n";

std::string event(const std::string& when, const std::string& more = "") {
  return "[[event]]\nwhen = \"" + when + "\"\n" + more;
}

double value(const std::string& when) {
  const Scene s = read_scene(bodies + event(when), "s.toml");
  return s.events.at(0).when(s.model, s.start);
}

}  // namespace

TEST_CASE("an event may name every coordinate and velocity that files of a run name", "[scene_file]") {
  const std::pair<const char*, double> all[] = {{"t - 0.5", -0.5},
                                                {"cube.x", 1},
                                                {"cube.y", 2},
                                                {"cube.z", 3},
                                                {"cube.vx", 4},
                                                {"cube.vy", 5},
                                                {"cube.vz", 6},
                                                {"cube.wx", 0.1},
                                                {"cube.wy", 0.2},
                                                {"cube.wz", 0.3},
                                                {"cube.qw", std::cos(0.5)},
                                                {"cube.qz", std::sin(0.5)},
                                                {"cube.qx", 0},
                                                {"cube.qy", 0},
                                                {"rod.x", 7},
                                                {"rod.y", 8},
                                                {"rod.angle", 0.5},
                                                {"rod.vx", 9},
                                                {"rod.vy", 10},
                                                {"rod.omega", 11},
                                                {"dot.x", 12},
                                                {"dot.y", 13},
                                                {"dot.z", 14},
                                                {"dot.vx", 15},
                                                {"dot.vy", 16},
                                                {"dot.vz", 17},
                                                {"pin.coordinate", 0},
                                                {"pin.rate", 11},
                                                {"slide.slide.rate", 6},
                                                {"slide.angle.rate", 0.3}};
  for (const auto& [when, right] : all) {
    CAPTURE(when);
    CHECK(std::abs(value(when) - right) < 1e-14);
  }
  CHECK(std::abs(value("cube.x*dot.vx - hypot(rod.x, rod.y)*sin(t)") - 15) < 1e-14);
}

TEST_CASE("an event has a name, a direction, and an end or a mark", "[scene_file]") {
  const Scene s = read_scene("[parameters]\nedge = 2\n" + bodies + event("dot.x - edge") +
                                 event("dot.y", "name = \"low\"\ndirection = -1\nthen = \"stop\"\n") +
                                 event("dot.z", "direction = 1\nthen = \"mark\"\n"),
                             "s.toml", {{"edge", 3}});
  REQUIRE(s.events.size() == 3);
  CHECK(s.events[0].name == "event-1");
  CHECK(s.events[0].direction == 0);
  CHECK_FALSE(s.events[0].then);
  CHECK(s.events[0].when(s.model, s.start) == 9);
  CHECK(s.events[1].name == "low");
  CHECK(s.events[1].direction == -1);
  State x = s.start;
  REQUIRE(s.events[1].then);
  CHECK(s.events[1].then(s.model, x) == AfterEvent::Stop);
  CHECK(s.events[2].name == "event-3");
  CHECK(s.events[2].direction == 1);
  CHECK_FALSE(s.events[2].then);

  const std::string text = write_scene(s);
  const Scene again = read_scene(text, "s.toml");
  CHECK(write_scene(again) == text);
  REQUIRE(again.events.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(again.events[i].name == s.events[i].name);
    CHECK(again.events[i].direction == s.events[i].direction);
    CHECK(static_cast<bool>(again.events[i].then) == static_cast<bool>(s.events[i].then));
    CHECK(again.events[i].when(again.model, again.start) == s.events[i].when(s.model, s.start));
  }
  Scene own = s;
  own.events[0].recipe = {};
  CHECK_THROWS_WITH(write_scene(own), Contains("event 'event-1'") && Contains("which no file can say"));
}

TEST_CASE("what is no event is refused where it stands", "[scene_file]") {
  CHECK_THAT(message_of(with_ball("[[event]]\n")),
             StartsWith("s.toml:6:1: a table without the key 'when', needs it"));
  CHECK_THAT(message_of(with_ball(event("ball.xx - 1"))),
             StartsWith("s.toml:7:9: when has the name 'ball.xx', needs one of t, ball.x") &&
                 Contains("(did you mean ball.x?)"));
  CHECK_THAT(message_of(with_ball(event("1 + bal.x"))),
             StartsWith("s.toml:7:13: when has the name 'bal.x', needs one of "));
  CHECK_THAT(message_of(with_ball(event("ball.x -"))),
             StartsWith("s.toml:7:17: when has the end of the expression, needs a number"));
  CHECK_THAT(message_of(with_ball(event("1 + 1"))),
             StartsWith("s.toml:7:8: \"1 + 1\", which never changes, needs t, or a coordinate"));
  CHECK_THAT(message_of(with_ball(event("ball.x", "direction = 2\n"))),
             StartsWith("s.toml:8:13: the direction 2, needs to be 1 (rising), -1 (falling) or 0 (either)"));
  CHECK_THAT(message_of(with_ball(event("ball.x", "then = \"halt\"\n"))),
             StartsWith("s.toml:8:8: then is 'halt', needs one of stop, mark"));
  CHECK_THAT(message_of(with_ball(event("ball.x", "name = \"a\"\n") + event("ball.y", "name = \"a\"\n"))),
             StartsWith("s.toml:11:8: the event 'a' a second time, needs a name of its own"));
  CHECK_THAT(message_of(with_ball(event("ball.x", "them = \"stop\"\n"))),
             StartsWith("s.toml:8:1: the key 'them', needs one of name, when, direction, then"));
}
