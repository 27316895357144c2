// Every scene's exact() against the model's own equations of motion.
#include <catch2/catch.hpp>

#include "tests/study/equations_of_motion.hpp"

namespace perp {
namespace {

/// A motion to test: up to `until` (0: the scene's own), away from its switches.
struct Motion {
  const char* scene;
  double until = 0;
  std::vector<double> switches = {};
  SceneParameters set = {};
  double size = 1;    ///< of forces and velocities, to which the residuals are relative
  int touching = -1;  ///< points that touch all along, if always the same
};

void check(const Motion& motion, const EquationsOfMotionOptions& options = {}) {
  const Scene s = scene(motion.scene, motion.set);
  const double until = motion.until > 0 ? motion.until : s.t_end, margin = 5 * options.delta;
  CAPTURE(motion.scene);
  for (int i = 0; i < 50; ++i) {
    double t = margin + (until - margin) * (i + 0.5) / 50;
    for (const double at : motion.switches)
      if (std::abs(t - at) < margin) t = at + margin;
    const EquationsOfMotion e = equations_of_motion(s, t, options);
    CAPTURE(t, e.newton_euler, e.kinematic, e.joints, e.overlap, e.sliding);
    REQUIRE(e.newton_euler < 1e-10 * motion.size);
    REQUIRE(e.kinematic < 1e-11 * motion.size);
    REQUIRE(e.joints < 1e-14 * motion.size);
    REQUIRE(e.overlap < 1e-14);
    if (motion.touching >= 0) REQUIRE(e.touching == motion.touching);
  }
}

}  // namespace

TEST_CASE("the exact motion of a sphere that slides and rolls satisfies the equations of motion", "[exact]") {
  check({.scene = "seed-sphere", .switches = {0.29125}, .touching = 1});
  check({.scene = "oblique-sphere", .switches = {0.65125}, .touching = 1});
  check({.scene = "oblique-sphere", .switches = {0.65125}, .set = {{"heading", 0.7}}, .touching = 1});
  check({.scene = "turntable", .touching = 1});
}

TEST_CASE("the exact motion of a block on a slope satisfies the equations of motion", "[exact]") {
  check({.scene = "incline-block", .touching = 1});
  check({.scene = "incline-block", .switches = {0.2185}, .set = {{"v0", -2}}, .touching = 1});
  check({.scene = "incline-block", .set = {{"mu", 0.6}}, .touching = 1});
  check({.scene = "cross-incline", .touching = 1});
  check({.scene = "cross-incline", .until = 2, .set = {{"k", 1}}, .touching = 1});
  check({.scene = "cross-incline", .until = 0.6, .switches = {0.4893}, .set = {{"k", 1.5}}, .touching = 1});
}

TEST_CASE("the exact motion of a particle on a shaken plate satisfies the equations of motion", "[exact]") {
  check({.scene = "shaker", .until = 1, .switches = {0.06246, 0.35169, 0.58605, 0.87529}});
}

TEST_CASE("the exact motion of a bead on a circular wall satisfies the equations of motion", "[exact]") {
  check({.scene = "bead-in-ring", .touching = 1});
  check({.scene = "bead-in-ring", .set = {{"mu", 0}, {"radius", 3}}, .touching = 1});
}

TEST_CASE("the exact motion of a roller in a cylinder satisfies the equations of motion", "[exact]") {
  check({.scene = "roller-in-cylinder", .until = 3, .touching = 1});
  check({.scene = "roller-in-cylinder", .until = 3, .set = {{"lambda", 1}}, .touching = 1});
}

TEST_CASE("the exact motion of a pendulum with dry friction satisfies the equations of motion", "[exact]") {
  check({.scene = "friction-pendulum",
         .until = 12,
         .switches = {1.0918, 2.1640, 3.2203, 4.2635, 5.2958, 6.3194, 7.3360, 8.3473, 9.3547, 10.3596,
                      11.3634}});
}

TEST_CASE("the exact motion of a block on a spring and a rough guide satisfies the equations of motion",
          "[exact]") {
  const double half = 0.628318530717958648;
  check({.scene = "spring-block",
         .until = 5,
         .switches = {half, 2 * half, 3 * half, 4 * half, 5 * half, 6 * half}});
}

TEST_CASE("the exact motion of a free body satisfies the equations of motion", "[exact]") {
  check({.scene = "dzhanibekov", .until = 12, .size = 10});
}

TEST_CASE(
    "the exact motion of a ball that rolls, slips and flies off a sphere satisfies the equations of motion",
    "[exact]") {
  check({.scene = "ball-on-sphere", .until = 1.4, .switches = {1.16953, 1.21841}});
  check({.scene = "ball-on-sphere", .until = 1, .set = {{"mu", 0.2}}, .touching = 1});
}

TEST_CASE("the exact motion of a marble in a bowl satisfies the equations of motion", "[exact]") {
  check({.scene = "bowl", .until = 3, .size = 10, .touching = 1});
}

TEST_CASE("the exact motion of a bouncing ball satisfies the equations of motion between impacts",
          "[exact]") {
  check({.scene = "bouncing-ball", .switches = {0.451524}});
  check({.scene = "three-balls"});
}

TEST_CASE("the exact motion of a heavy top satisfies the equations of motion", "[exact]") {
  check({.scene = "heavy-top", .size = 1e4}, {.delta = 1e-4});
}

TEST_CASE("the exact motion of a stiff free body satisfies the equations of motion", "[exact]") {
  check({.scene = "free-spin", .until = 1e-2, .size = 1e8}, {.delta = 1e-6});
}

TEST_CASE("the exact motion of a slider-crank satisfies the equations of motion", "[exact]") {
  check({.scene = "slider-crank", .until = 1.3, .switches = {1.18675}, .size = 100});
  const double pi = std::acos(-1.0);
  const Scene s = scene("slider-crank", {{"guide", 0.5}});
  std::vector<double> kinks;
  for (double t = 0; t < 1.1; t += 1e-4)  // where the slider turns, and where all stops
    if (std::floor(s.exact(t).q[2] / pi) != std::floor(s.exact(t + 1e-4).q[2] / pi) ||
        (s.exact(t).nu[2] > 0 && s.exact(t + 1e-4).nu[2] == 0))
      kinks.push_back(t);
  CHECK(kinks.size() == 3);
  check({.scene = "slider-crank", .until = 1.2, .switches = kinks, .set = {{"guide", 0.5}}, .size = 100});
}

TEST_CASE("the exact motion of a rocking block satisfies the equations of motion between impacts",
          "[exact]") {
  check({.scene = "rocking-block", .until = 0.9, .switches = {0.4938}, .touching = 1});
}

TEST_CASE("the exact motion of a rod that turns about its tip satisfies the equations of motion", "[exact]") {
  check({.scene = "painleve-rod", .touching = 1});
}

TEST_CASE("the exact motion of a four-bar satisfies the equations of motion", "[exact]") {
  check({.scene = "four-bar", .until = 5, .size = 10});
}

TEST_CASE("the exact motion of Bennett's linkage satisfies the equations of motion", "[exact]") {
  check({.scene = "bennett", .until = 5, .size = 10});
}

TEST_CASE("the exact motion of a double pendulum satisfies the equations of motion", "[exact]") {
  check({.scene = "double-pendulum", .until = 3, .size = 10});
  check({.scene = "double-pendulum", .until = 10, .set = {{"angle1", 0.5}, {"angle2", -0.3}}});
}

TEST_CASE("the exact motion of a cube that slides to rest satisfies the equations of motion", "[exact]") {
  check({.scene = "sliding-cube", .switches = {1.22324}, .touching = 4});
}

TEST_CASE("the exact motion of an ellipse that rolls on a line satisfies the equations of motion",
          "[exact]") {
  check({.scene = "rolling-ellipse", .until = 2, .size = 10, .touching = 1});
  check({.scene = "rolling-ellipse", .until = 2, .set = {{"angle", -1.2}}, .size = 10, .touching = 1});
}

TEST_CASE("the exact motion of a rattleback satisfies the equations of motion", "[exact]") {
  check({.scene = "rattleback", .until = 3, .size = 100, .touching = 1}, {.delta = 1e-4});
  check({.scene = "rattleback", .until = 1, .set = {{"spin", 5}}, .size = 100, .touching = 1},
        {.delta = 1e-4});
}

TEST_CASE("the exact motion of a coin that rolls on its rim satisfies the equations of motion", "[exact]") {
  check({.scene = "euler-disk", .size = 1e4, .touching = 1}, {.delta = 1e-4});
  check({.scene = "euler-disk", .set = {{"alpha", 1}}, .size = 1e4, .touching = 1}, {.delta = 1e-4});
}

TEST_CASE("the exact motions of a spun sphere and a coasting wheel satisfy the equations of motion",
          "[exact]") {
  check({.scene = "spun-sphere", .until = 0.8, .switches = {0.61162}, .touching = 1});
  check({.scene = "spun-sphere", .until = 0.8, .switches = {0.61162}, .set = {{"spin", -30}}, .touching = 1});
  check({.scene = "coasting-wheel", .until = 2.5, .set = {{"rolling", 0.005}}, .touching = 1});
  check({.scene = "coasting-wheel", .switches = {1.52905}, .set = {{"rolling", 0.02}}, .touching = 1});
  check(
      {.scene = "coasting-wheel", .switches = {1.02221}, .set = {{"slope", 0.1}, {"v0", -1}}, .touching = 1});
}

TEST_CASE("a block too steep to lock falls out of a V as if there were none", "[exact]") {
  check({.scene = "wedge", .switches = {0}, .set = {{"mu", 0.3}}, .touching = 0});
}

TEST_CASE("leaning, overhanging and piled blocks at rest satisfy the equations of motion", "[exact]") {
  check({.scene = "card", .touching = 2});
  check({.scene = "card", .set = {{"lean", 1}, {"mu", 0.779}}, .touching = 2});
  check({.scene = "overhang", .set = {{"count", 3}}});
  check({.scene = "tower", .until = 0.1, .set = {{"count", 4}}, .touching = 16});
  check({.scene = "tower", .until = 0.1, .set = {{"count", 3}, {"planks", 2}}});
}

TEST_CASE("boxes at rest satisfy the equations of motion", "[exact]") {
  check({.scene = "creep", .until = 1, .touching = 4});
  check({.scene = "table", .touching = 4});
  check({.scene = "stack", .set = {{"ratio", 1}}});
  check({.scene = "stack", .set = {{"ratio", 1e6}, {"count", 5}}, .size = 1e7});
}

}  // namespace perp
