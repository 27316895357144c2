// Robots from URDF files: what they become and how they move.
#include "robots.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "perp/instant/instant.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;
using Catch::Contains;
using Catch::StartsWith;

#ifndef PERP_HAS_URDFDOM

TEST_CASE("without urdfdom a robot is refused with the package that it needs", "[urdf]") {
  CHECK_THROWS_WITH(read_urdf("<robot name=\"r\"><link name=\"l\"/></robot>", "r.urdf"),
                    Contains("liburdfdom-dev"));
}

#else

namespace {

Scene example(const std::string& name, const SceneParameters& set = {}) {
  return load_scene((robots / (name + ".urdf")).string(), set);
}

State end_of(const Scene& s, Stepper& stepper, double t_end, double h) {
  return simulate(s.model, stepper, s.start, {.t_end = t_end, .h = h}).back();
}

/// Fixed-axis angles: Rz(yaw) Ry(pitch) Rx(roll), written out.
Matrix3 turned(double roll, double pitch, double yaw) {
  const double a = std::cos(roll), b = std::sin(roll), c = std::cos(pitch), d = std::sin(pitch),
               e = std::cos(yaw), f = std::sin(yaw);
  Matrix3 R;
  R << e * c, e * d * b - f * a, e * d * a + f * b,  //
      f * c, f * d * b + e * a, f * d * a - e * b,   //
      -d, c * b, c * a;
  return R;
}

}  // namespace

TEST_CASE("the double pendulum written as URDF moves as the built-in scene does", "[urdf]") {
  const Scene known = scene("double-pendulum");
  const std::string text =
      xml_link("world") +
      xml_link("upper", inertial(1, 2.0 / 9, 2.0 / 9, 0.1, "xyz=\"0 0 -0.6666666666666666\"")) +
      xml_link("lower", inertial(4.0 / 3, 0.25, 0.25, 0.1, "xyz=\"0 0 -0.75\"")) +
      xml_joint("shoulder", "continuous", "world", "upper", "<axis xyz=\"0 -1 0\"/>") +
      xml_joint("elbow", "continuous", "upper", "lower", "<origin xyz=\"0 0 -1\"/><axis xyz=\"0 -2 0\"/>");
  const Scene s = read(text, {{"q.shoulder", M_PI / 2}});
  const BodyId lower = s.model.find_body("lower"), same = known.model.find_body("lower");
  const double t = 0.5;
  Ncp2Stepper stepper;
  double errors[2];
  for (const int i : {0, 1}) {
    const double h = i == 0 ? 0.01 : 0.005;
    const Vector3 p = s.model.position(end_of(s, stepper, t, h), lower);
    const Vector3 q = known.model.position(end_of(known, stepper, t, h), same);
    CHECK((p - Vector3(q.x(), 0, q.y())).norm() < 1e-9);
    const Vector3 exact = known.model.position(known.exact(t), same);
    errors[i] = (p - Vector3(exact.x(), 0, exact.y())).norm();
  }
  CAPTURE(errors[0], errors[1]);
  CHECK(errors[0] / errors[1] > 3.6);  // of second order
  CHECK(errors[0] / errors[1] < 4.4);
}

TEST_CASE("a link's inertia is turned and moved as its origin says", "[urdf]") {
  const Matrix3 R = turned(0.3, -0.5, 1.1);
  const Scene s =
      read(xml_link("l", inertial(2, 0.03, 0.04, 0.05, "xyz=\"0.1 0.2 0.3\" rpy=\"0.3 -0.5 1.1\"")),
           {{"base.x", 1}, {"base.roll", 0.2}, {"base.pitch", 0.4}, {"base.yaw", -0.7}});
  const BodyId l = s.model.find_body("l");
  const Matrix3 J = R * Vector3(0.03, 0.04, 0.05).asDiagonal() * R.transpose();
  CHECK((s.model.body(l).J - J).norm() < 1e-15);
  CHECK(s.model.body(l).mass == 2);
  const Pose X = s.model.pose(s.start, l);
  const Matrix3 base = turned(0.2, 0.4, -0.7);
  CHECK((X.R() - base).norm() < 1e-15);  // axes of the link, not of the inertia
  CHECK((X.p - (Vector3(1, 0, 0) + base * Vector3(0.1, 0.2, 0.3))).norm() < 1e-15);
}

TEST_CASE("links that fixed joints hold together are one body with their common inertia", "[urdf]") {
  // two balls of 1 and 3 kg, 0.8 m apart along x of the first; the second hangs on a flange without inertia
  const Scene s = read(
      xml_link("a", inertial(1, 0.1, 0.1, 0.1)) + xml_link("flange") +
      xml_link("b", inertial(3, 0.2, 0.3, 0.4)) +
      xml_joint("j", "fixed", "a", "flange", "<origin xyz=\"0.3 0 0\" rpy=\"0 0 1.5707963267948966\"/>") +
      xml_joint("k", "fixed", "flange", "b", "<origin xyz=\"0 -0.5 0\"/>"));
  REQUIRE(s.model.bodies().size() == 2);
  const Body& body = s.model.bodies()[1];
  CHECK(body.name == "a");
  CHECK(body.mass == 4);
  CHECK((body.rest.p - Vector3(0.6, 0, 0)).norm() < 1e-15);  // (3 * 0.8)/4
  const double apart = 0.75 * 0.64;                          // m1 m2/(m1 + m2) d^2
  CHECK((body.J - Matrix3(Vector3(0.1 + 0.3, 0.1 + 0.2 + apart, 0.1 + 0.4 + apart).asDiagonal())).norm() <
        1e-15);
  CHECK(s.unused.empty());
}

TEST_CASE("a joint's dry friction is a moment of a revolute and a force of a prismatic joint", "[urdf]") {
  const double h = 1e-3;
  LcpStepper stepper;
  // about a vertical axis 0.5 m from the centre: I = 0.1 + 2 * 0.25, it stops after I w^2/(2 c)
  const Scene turns = read(held("revolute", inertial(2, 0.1, 0.1, 0.1, "xyz=\"0.5 0 0\""),
                                "<axis xyz=\"0 0 1\"/><dynamics friction=\"0.4\"/>" + stops_far),
                           {{"v.j", 2}});
  const State stopped = end_of(turns, stepper, 4, h);
  CHECK(turns.model.coordinate(stopped, {0}) == Approx(0.6 * 4 / 0.8).margin(2 * h));
  CHECK(std::abs(turns.model.coordinate_rate(stopped, {0})) < 1e-10);
  // along x, it stops after m v^2/(2 c)
  const Scene slides = read(held("prismatic", inertial(2, 0.1, 0.1, 0.1, "xyz=\"0.5 0 0\""),
                                 "<dynamics friction=\"0.4\"/>" + stops_far),
                            {{"v.j", 1}});
  const State still = end_of(slides, stepper, 6, h);
  CHECK(slides.model.coordinate(still, {0}) == Approx(2 / 0.8).margin(h));
  CHECK(std::abs(slides.model.coordinate_rate(still, {0})) < 1e-10);
}

TEST_CASE("a joint's damping takes its speed exponentially", "[urdf]") {
  Ncp2Stepper stepper;
  const Scene s =
      read(held("continuous", inertial(2, 0.1, 0.1, 0.1), "<axis xyz=\"0 0 1\"/><dynamics damping=\"0.2\"/>"),
           {{"v.j", 2}});
  const State x = end_of(s, stepper, 1, 0.01);
  CHECK(s.model.coordinate_rate(x, {0}) == Approx(2 * std::exp(-0.2 / 0.1)).margin(1e-4));
}

TEST_CASE("a joint's limits stop it, and a start that they leave out moves between them", "[urdf]") {
  LcpStepper stepper;
  const std::string limit =
      "<axis xyz=\"0 0 1\"/><limit lower=\"-0.25\" upper=\"0.5\" effort=\"1\" velocity=\"1\"/>";
  for (const double rate : {2.0, -2.0}) {
    const Scene s = read(held("revolute", inertial(2, 0.1, 0.1, 0.1), limit), {{"v.j", rate}});
    const State x = end_of(s, stepper, 1, 1e-3);
    CHECK(s.model.coordinate(x, {0}) == Approx(rate > 0 ? 0.5 : -0.25).margin(1e-12));
    CHECK(std::abs(s.model.coordinate_rate(x, {0})) < 1e-12);
  }
  const Scene above = read(held("revolute", inertial(2, 0.1, 0.1, 0.1),
                                "<limit lower=\"0.5\" upper=\"1.5\" effort=\"1\" velocity=\"1\"/>"));
  CHECK(above.model.coordinate(above.start, {0}) == Approx(1));
}

TEST_CASE("starts of joints are consistent: coordinates as asked, turns counted, no joint open or opening",
          "[urdf]") {
  const std::string text =
      xml_link("base", inertial(1, 0.1, 0.1, 0.1)) +
      xml_link("a", inertial(1, 0.1, 0.1, 0.1, "xyz=\"0.1 0.2 0\"")) +
      xml_link("b", inertial(1, 0.1, 0.1, 0.1, "xyz=\"0 0.2 0.1\"")) +
      xml_link("c", inertial(1, 0.1, 0.1, 0.1)) +
      xml_joint("j", "continuous", "base", "a",
                "<origin xyz=\"0.3 0 0.1\" rpy=\"0.4 0.2 0.1\"/><axis xyz=\"1 2 3\"/>") +
      xml_joint("k", "prismatic", "a", "b",
                "<origin xyz=\"0 0.5 0\" rpy=\"1 0 0\"/><axis xyz=\"0 1 -1\"/>" + stops_far) +
      xml_joint("l", "planar", "b", "c", "<origin xyz=\"0 0 0.2\"/><axis xyz=\"0 0 1\"/>");
  const Scene s =
      read(text, {{"q.j", 9}, {"v.j", -2}, {"q.k", 0.3}, {"v.k", 0.7}, {"base.vx", 1}, {"base.wz", 3}});
  const auto j = s.model.find_joint("j"), k = s.model.find_joint("k");
  CHECK(s.model.coordinate(s.start, j) == Approx(9).margin(1e-13));
  CHECK(s.model.coordinate_rate(s.start, j) == Approx(-2).margin(1e-13));
  CHECK(s.model.coordinate(s.start, k) == Approx(0.3).margin(1e-14));
  CHECK(s.model.coordinate_rate(s.start, k) == Approx(0.7).margin(1e-13));
  CHECK(s.model.velocity(s.start, s.model.find_body("base")) == Vector3(1, 0, 0));
  CHECK(s.model.angular_velocity(s.start, s.model.find_body("base")).isApprox(Vector3(0, 0, 3)));
  CHECK(s.model.joint(s.model.find_joint("l")).kind == JointKind::Planar);
  Instant now;
  evaluate(s.model, s.start, now);
  CHECK(now.joint_rows.size() == 13);
  for (const JointRowInstant& row : now.joint_rows) {
    CHECK(std::abs(row.psi_b) < 1e-14);
    CHECK(std::abs(row.velocity(s.start.nu)) < 1e-13);
  }
}

TEST_CASE("a root floats if it has inertia, unless it is the world or told not to", "[urdf]") {
  const std::string heavy = inertial(1, 0.1, 0.1, 0.1);
  const auto bodies = [](const std::string& text, const SceneParameters& set = {}) {
    return read(text, set).model.bodies().size() - 1;
  };
  const auto on = [&](const std::string& root, const std::string& what) {
    return xml_link(root, what) + xml_link("l", heavy) + xml_joint("j", "continuous", root, "l");
  };
  CHECK(bodies(on("base", heavy)) == 2);
  CHECK(bodies(on("base", heavy), {{"base.fixed", 1}}) == 1);
  CHECK(bodies(on("base", "")) == 1);
  CHECK(bodies(on("world", heavy)) == 1);
  CHECK(bodies(on("world", heavy), {{"base.fixed", 0}}) == 2);
  CHECK_THAT(read(on("world", heavy)).unused.at(0),
             Contains("<inertial> of link 'world', which is fixed to the world"));
  CHECK_THROWS_WITH(read(on("base", ""), {{"base.fixed", 0}}), Contains("root link 'base' without inertia"));
  const Scene floating = read(xml_link("world") + xml_link("l", heavy) +
                              xml_joint("j", "floating", "world", "l", "<origin xyz=\"0 0 2\"/>"));
  CHECK(floating.model.joints().empty());
  CHECK(floating.model.position(floating.start, floating.model.find_body("l")).z() == 2);
}

TEST_CASE("links without inertia are left out at the end of a chain and refused within it", "[urdf]") {
  const std::string heavy = inertial(1, 0.1, 0.1, 0.1);
  const Scene s = read(xml_link("base", heavy) + xml_link("a") + xml_link("b") +
                       xml_joint("j", "continuous", "base", "a") + xml_joint("k", "fixed", "a", "b"));
  CHECK(s.model.joints().empty());
  REQUIRE(s.unused.size() == 1);
  CHECK(s.unused[0] == "r.urdf:2: link 'a' and joint 'j': it has no inertia and carries nothing");
  CHECK_THROWS_WITH(
      read(xml_link("base", heavy) + "\n" + xml_link("a") + xml_link("b", heavy) +
           xml_joint("j", "continuous", "base", "a") + xml_joint("k", "continuous", "a", "b")),
      StartsWith("r.urdf:3:1: link 'a' without inertia between the joints 'j' and 'k', needs an <inertial>"));
}

TEST_CASE("shapes touch the floor and each other where they stand in their links", "[urdf]") {
  const auto shape = [](const std::string& geometry, const std::string& origin) {
    return "<collision><origin " + origin + "/><geometry>" + geometry + "</geometry></collision>";
  };
  const std::string heavy = inertial(1, 0.1, 0.1, 0.1, "xyz=\"0.1 0.1 0.1\"");
  const Scene s = read(xml_link("base", heavy + shape("<box size=\"2 1 0.4\"/>", "xyz=\"0 0 1\"")) +
                           xml_link("a", heavy + shape("<cylinder radius=\"0.2\" length=\"0.6\"/>",
                                                       "xyz=\"0 0 1\" rpy=\"1.5707963267948966 0 0\"")) +
                           xml_link("b", heavy + shape("<sphere radius=\"0.1\"/>", "xyz=\"0.2 0 1.5\"") +
                                             shape("<sphere radius=\"0.1\"/>", "xyz=\"0 0 1\"")) +
                           xml_link("c", heavy + shape("<sphere radius=\"0.3\"/>", "xyz=\"0 3 1\"")) +
                           xml_joint("j", "continuous", "base", "a") +
                           xml_joint("k", "continuous", "a", "b") + xml_joint("l", "continuous", "b", "c"),
                       {{"mu", 0.3}, {"e", 0.1}, {"base.z", 0.5}});
  const auto gap = [&](const std::string& name) {
    Instant now;
    evaluate(s.model, s.start, now);
    double least = infinity;
    for (const ContactInstant& c : now.contacts)
      if (s.model.contact_name(c.contact) == name) {
        least = std::min(least, c.psi_n);
        CHECK(c.mu == 0.3);
        CHECK(c.e == 0.1);
      }
    return least;
  };
  CHECK(gap("ground.floor|base.base") == Approx(1.3));
  CHECK(gap("ground.floor|a.a") == Approx(1.3));  // it lies: its axis is along y
  CHECK(gap("ground.floor|b.b") == Approx(1.9));
  CHECK(gap("ground.floor|b.b_2") == Approx(1.4));
  CHECK(gap("ground.floor|c.c") == Approx(1.2));
  CHECK(gap("base.base|b.b") == Approx(0.2));        // 1.5 - 0.1 over 1.2
  CHECK(gap("base.base|c.c") == Approx(2.5 - 0.3));  // beside the face y = 0.5
  CHECK(gap("base.base|a.a") == infinity);           // joined, as a and b, b and c
  CHECK(gap("base.base|b.b_2") == infinity);         // it is in the box
  CHECK(gap("a.a|c.c") == infinity);                 // no gap of a cylinder and a sphere
  REQUIRE(s.unused.size() == 2);
  CHECK_THAT(s.unused[0], Contains("1 pair of collision shapes"));
  CHECK_THAT(s.unused[1], Contains("contact 'base.base|b.b_2': the shapes overlap at the start"));
  CHECK(write_scene(read_scene(write_scene(s), "again.toml")) == write_scene(s));
}

TEST_CASE("boxes of links that no joint joins meet each other", "[urdf]") {
  const auto box = [](const std::string& origin) {
    return "<collision><origin " + origin + "/><geometry><box size=\"0.4 0.4 0.4\"/></geometry></collision>";
  };
  const std::string heavy = inertial(1, 0.1, 0.1, 0.1);
  const Scene s = read(xml_link("base", heavy) + xml_link("a", heavy + box("xyz=\"0 0 0.5\"")) +
                       xml_link("b", heavy + box("xyz=\"0.7 0 0.5\"")) +
                       xml_joint("j", "continuous", "base", "a") + xml_joint("k", "continuous", "base", "b"));
  Instant now;
  evaluate(s.model, s.start, now);
  double least = infinity;
  for (const ContactInstant& c : now.contacts)
    if (s.model.contact_name(c.contact) == "a.a|b.b") least = std::min(least, c.psi_n);
  CHECK(least == Approx(0.3));
  CHECK(s.unused.empty());
}

TEST_CASE("meshes of a robot are their convex hulls, and what this adds or leaves out is said", "[urdf]") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "perp-urdf-mesh-test";
  std::filesystem::create_directories(folder / "meshes");
  std::ofstream(folder / "meshes" / "wedge.obj")
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  std::ofstream(folder / "meshes" / "flat.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n";
  const auto robot_of = [&](const std::string& mesh) {
    return read_urdf(
        robot(xml_link("base", inertial(1, 0.1, 0.1, 0.1) + "<collision><origin xyz=\"0 0 1\"/><geometry>" +
                                   mesh + "</geometry></collision>")),
        (folder / "r.urdf").string());
  };
  const auto least = [](const Scene& s) {
    Instant now;
    evaluate(s.model, s.start, now);
    return now.gap_min();
  };
  const Scene wedge = robot_of("<mesh filename=\"package://r/meshes/wedge.obj\" scale=\"1 1 0.5\"/>");
  REQUIRE(wedge.model.shapes().size() == 2);
  CHECK(wedge.model.shapes()[0].shape.volume() == Approx(0.5 / 6));
  CHECK(least(wedge) == Approx(1).epsilon(1e-12));
  CHECK(wedge.unused.empty());  // it is its own hull
  const auto said = [&](const std::string& mesh) {
    const Scene s = robot_of(mesh);
    std::string all;
    for (const std::string& what : s.unused) all += what + "\n";
    return all;
  };
  CHECK_THAT(said("<mesh filename=\"meshes/none.stl\"/>"),
             Contains("none.stl") && Contains("left without any shape"));
  CHECK_THAT(said("<mesh filename=\"meshes/flat.obj\"/>"), Contains("flat"));
  CHECK_THAT(said("<mesh filename=\"meshes/wedge.obj\" scale=\"1 -1 1\"/>"), Contains("mirrors"));
  CHECK_THAT(said("<mesh filename=\"meshes/wedge.dae\"/>"), Contains(".stl or .obj"));
  const Scene capsule = robot_of("<capsule radius=\"0.2\" length=\"1\"/>");
  CHECK(least(capsule) == Approx(0.3));
  CHECK(capsule.unused.empty());
}

TEST_CASE("a joint that mimics another on the ground is geared to it, and others are said not to be",
          "[urdf]") {
  const std::string heavy = inertial(1, 0.1, 0.1, 0.1);
  const auto two = [&](const std::string& parent, const std::string& mimic) {
    return xml_link("world") + xml_link("a", heavy) + xml_link("b", heavy) +
           xml_joint("j", "continuous", "world", "a", "<axis xyz=\"0 0 1\"/>") +
           xml_joint("k", "continuous", parent, "b",
                     "<axis xyz=\"0 0 1\"/><mimic joint=\"j\" " + mimic + "/>");
  };
  LcpStepper stepper;
  const Scene s = read(two("world", "multiplier=\"-3\""), {{"v.j", 2}});
  const State x = end_of(s, stepper, 3, 0.01);
  CHECK(s.model.coordinate(x, s.model.find_joint("j")) == Approx(6));
  CHECK(s.model.coordinate(x, s.model.find_joint("k")) == Approx(-18));
  for (const Scene& other : {read(two("a", "")), read(two("world", "offset=\"1\""))}) {
    CHECK(other.model.joints().size() == 2);
    CHECK_THAT(other.unused.at(0), Contains("<mimic> of joint 'k'"));
  }
}

TEST_CASE("the example's arm swings down against its friction, stays within its stops, and hangs still",
          "[urdf]") {
  const Scene s = example("arm", {{"q.shoulder", 1.2}, {"q.elbow", 1.0}});
  LcpStepper stepper;
  const Trajectory run = simulate(s.model, stepper, s.start, {.t_end = 8, .h = 2e-3});
  const JointId shoulder = s.model.find_joint("shoulder"), elbow = s.model.find_joint("elbow");
  bool stopped = false;
  double energy = s.model.energy(s.start);
  for (std::size_t i = 0; i < run.steps(); ++i) {
    const StepReport report = run.report(i);
    stopped = stopped || report.contact("elbow.lower").p_n > 0;
    CHECK(report.gap_min > -1e-12);
    CHECK(report.energy < energy + 1e-2);
    energy = report.energy;
  }
  CHECK(stopped);
  const State& x = run.back();
  CHECK(std::abs(s.model.coordinate_rate(x, shoulder)) < 1e-9);
  CHECK(std::abs(s.model.coordinate_rate(x, elbow)) < 1e-9);
  CHECK(std::abs(s.model.coordinate(x, shoulder)) < 0.1);  // where friction holds it
}

TEST_CASE("the example's cart lands rolling and is slowed by its axles as mechanics says", "[urdf]") {
  const double m = 5.8, r = 0.1, I = 3 * 0.003, v0 = 1.5, fall = std::sqrt(2 * 0.02 / 9.81), t = 1, h = 1e-3;
  const double m_rolling = m + I / (r * r);
  const double landed = v0 * m / m_rolling;  // wheels spun up by friction, which is enough
  const double slowing = 3 * 0.05 / r / m_rolling;
  for (const bool implicit : {false, true}) {
    LcpStepper lcp;
    Ncp2Stepper ncp2;
    const Scene s = example("cart", {{"base.z", 0.12}, {"base.vx", v0}});
    const State x = end_of(s, implicit ? static_cast<Stepper&>(ncp2) : lcp, t, h);
    const BodyId chassis = s.model.find_body("chassis");
    CHECK(s.model.velocity(x, chassis).x() == Approx(landed - slowing * (t - fall)).margin(slowing * h));
    CHECK(s.model.position(x, chassis).z() == Approx(0.1).margin(1e-10));
    CHECK(std::abs(s.model.position(x, chassis).y()) < 1e-9);
    const double rate = s.model.coordinate_rate(x, s.model.find_joint("axle_left"));
    CHECK(rate == Approx(s.model.velocity(x, chassis).x() / r).margin(1e-9));
  }
}

#endif
