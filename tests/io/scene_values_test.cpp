#include "scene_texts.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "perp/instant/instant.hpp"
#include "perp/model/gaps.hpp"

using namespace perp;
using Catch::Contains;

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
