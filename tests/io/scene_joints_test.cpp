#include <catch2/catch.hpp>

#include "perp/io/scene_file.hpp"

using namespace perp;
using Catch::Contains;

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
  CHECK(model.joint({3}).frictions == std::vector{0.5});
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
