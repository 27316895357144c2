// One rule for redundant contacts and joints, the same in all methods: the limit of rows that give a little, all alike.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "perp/io/scene_file.hpp"
#include "perp/model/gaps.hpp"
#include "perp/step/cp1.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

constexpr double g = 9.81, pi = 3.14159265358979323846;

/// A body of 45 g between two pads on slides, which the force `squeeze` presses on it: it stays while 2 mu squeeze > m g.
Scene grip(bool capsule, double squeeze) {
  const std::string body = capsule ? R"(inertia = { shape = "cylinder", radius = 0.004, length = 0.03 }
orientation = { axis = [1, 0, 0], angle = "90 deg" })"
                                   : R"(inertia = { shape = "box", size = [0.008, 0.03, 0.03] })";
  const std::string gap = capsule ? R"(kind = "capsule_on_plane", radius = 0.004, length = 0.03)"
                                  : R"(kind = "box_on_plane", size = [0.008, 0.03, 0.03])";
  std::string text = "[parameters]\nsqueeze = 12\n";
  for (const auto& [name, sign] : {std::pair("left", 1), std::pair("right", -1)}) {
    const std::string x = std::to_string(-0.014 * sign), s = std::to_string(sign);
    text += "[[body]]\nname = \"" + std::string(name) +
            "\"\nkind = \"spatial\"\nmass = 0.1\ninertia = { shape = \"box\", size = [0.02, 0.06, 0.06] "
            "}\nposition = [" +
            x + ", 0, 0]\n[[joint]]\nname = \"slide-" + name +
            "\"\nkind = \"prismatic\"\na = \"ground\"\nb = \"" + name +
            "\"\naxis = [1, 0, 0]\n[[joint_spring]]\njoint = \"slide-" + name +
            "\"\ndamping = 5\n[[force]]\nbody = \"" + name + "\"\nforce = [\"" + s + " * squeeze\", 0, 0]\n";
  }
  text += "[[body]]\nname = \"held\"\nkind = \"spatial\"\nmass = 0.045\n" + body + "\n";
  for (const auto& [name, sign] : {std::pair("left", 1), std::pair("right", -1)}) {
    const std::string s = std::to_string(sign);
    text += "[[contact]]\na = \"" + std::string(name) + "\"\nb = \"held\"\ngap = { " + gap + ", normal = [" +
            s + ", 0, 0], point = [" + std::to_string(0.01 * sign) + ", 0, 0] }\nmu = 0.7\n";
  }
  return read_scene(text, "grip.toml", {{"squeeze", squeeze}});
}

const double least_squeeze = 0.045 * g / (2 * 0.7);

/// The state at T of a scene's start, with its steps' length (not read by event).
State end_of(const Scene& s, const std::string& method, double T, double h, int edges = 8) {
  const auto stepper = make_stepper(method, {.edges = edges});
  if (method == "event") return simulate(s.model, *stepper, s.start, {.t_end = T}).back();
  return simulate(s.model, *stepper, s.start, {.t_end = T, .h = h}).back();
}

/// A block 1 x 0.8 x 0.5 that slides on feet, mu = 0.3: `feet` are its lower corners in an order of one's choice, then perhaps the middle.
struct Block {
  Scene s;
  BodyId body;
  static constexpr double height = 0.25, mu = 0.3;
  std::vector<Vector3> feet;

  explicit Block(bool middle, double heading = 0, std::array<int, 4> order = {0, 1, 2, 3}) {
    const Quaternion R(Eigen::AngleAxisd(heading, Vector3::UnitZ()));
    const Vector3 corners[] = {
        {0.5, 0.4, -height}, {-0.5, 0.4, -height}, {-0.5, -0.4, -height}, {0.5, -0.4, -height}};
    for (const int i : order) feet.push_back(corners[i]);
    if (middle) feet.push_back({0, 0, -height});
    body = s.model.add_body(Inertia::solid_box(2, {1, 0.8, 0.5}), {.pose = {.p = {0, 0, height}, .q = R}});
    for (const Vector3& foot : feet) s.model.add_contact(ground, body, point_on_plane(foot), {.mu = mu});
    s.start = s.model.rest();
  }
  void push(const Vector3& v, double turning, double heading = 0) {
    s.model.set_velocity(s.start, body, Eigen::AngleAxisd(heading, Vector3::UnitZ()) * v, {0, 0, turning});
  }
};

/// The same block by itself: loads of feet are affine in where they stand (what gives alike and is rigid above), in balance with
/// weight and friction; Runge and Kutta's method in x, y, angle. Shares no code with perp.
struct BlockAlone {
  std::vector<Vector3> feet;
  Eigen::Matrix<double, 6, 1> rate(const Eigen::Matrix<double, 6, 1>& y) const {
    const double m = 2, J = m * (1 + 0.64) / 12;
    const Eigen::Rotation2Dd R(y[2]);
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    std::vector<Vector2> r, d;
    for (const Vector3& foot : feet) {
      r.push_back(R * Vector2(foot.head<2>()));
      const Vector2 u = y.segment<2>(3) + y[5] * Vector2(-r.back().y(), r.back().x());
      d.push_back(u.normalized());
      const Eigen::RowVector3d load(1, r.back().x(), r.back().y());
      A.row(0) += load;
      for (int k = 0; k < 2; ++k)
        A.row(1 + k) += (r.back()[k] - Block::height * Block::mu * d.back()[k]) * load;
    }
    const Eigen::Vector3d share = A.partialPivLu().solve(Eigen::Vector3d(m * g, 0, 0));
    Eigen::Matrix<double, 6, 1> f;
    f << y[3], y[4], y[5], 0, 0, 0;
    for (std::size_t i = 0; i < feet.size(); ++i) {
      const Vector2 force = -Block::mu * (share[0] + share.tail<2>().dot(r[i])) * d[i];
      f.segment<2>(3) += force / m;
      f[5] += (r[i].x() * force.y() - r[i].y() * force.x()) / J;
    }
    return f;
  }
  Eigen::Matrix<double, 6, 1> at(double T, const Vector3& v, double turning) const {
    Eigen::Matrix<double, 6, 1> y;
    y << 0, 0, 0, v.x(), v.y(), turning;
    constexpr int steps = 4000;
    const double h = T / steps;
    for (int i = 0; i < steps; ++i) {
      const auto a = rate(y), b = rate(y + h / 2 * a), c = rate(y + h / 2 * b), e = rate(y + h * c);
      y += h / 6 * (a + 2 * b + 2 * c + e);
    }
    return y;
  }
};

/// How far a block is from x, y, angle [m, rad].
double off(const Block& block, const State& x, const Eigen::Matrix<double, 6, 1>& y) {
  const Pose X = block.s.model.pose(x, block.body);
  const double angle = 2 * std::atan2(X.q.z(), X.q.w());
  return std::max({std::abs(X.p.x() - y[0]), std::abs(X.p.y() - y[1]), std::abs(angle - y[2])});
}

/// Where a gripped body is at T, and whether it stays down to a millionth above the limit and slips a millionth below.
void hold(const std::string& method, bool capsule, double T, double h) {
  CAPTURE(method, capsule);
  for (const double margin : {30.0, 1e-2, 1e-6}) {
    CAPTURE(margin);
    const Scene s = grip(capsule, least_squeeze * (1 + margin));
    const Vector3 held = s.model.position(end_of(s, method, T, h), s.model.find_body("held"));
    CHECK(held.tail<2>().norm() < 1e-12);  // along x nothing holds pads and body but their dampers
  }
  if (method == "event") return;  // which takes minutes to slip at a millionth of g
  const Scene s = grip(capsule, least_squeeze * (1 - 1e-6));
  const double fallen = s.model.position(end_of(s, method, 5, h), s.model.find_body("held")).z();
  const double slipped = -0.5 * 1e-6 * g * 25;  // m g less 2 mu squeeze
  CHECK(fallen < 0.98 * slipped);
  if (capsule) CHECK(fallen == Approx(slipped).epsilon(0.02));  // a plate turns as it slips
}

}  // namespace

TEST_CASE("what is gripped stays to 1e-12 m while friction can bear it, and slips when it can't",
          "[redundant]") {
  hold(GENERATE("lcp", "ncp", "ncp2", "event"), GENERATE(true, false), 5, 0.02);
}

TEST_CASE("what is gripped stays for 100 s", "[redundant][slow]") {
  hold(GENERATE("lcp", "ncp", "ncp2", "event"), GENERATE(true, false), 100, 0.01);
}

TEST_CASE("the four feet of a table at rest carry a quarter each", "[redundant]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp-start", "ncp2", "event");
  CAPTURE(method);
  Model model;
  const BodyId table = model.add_body(Inertia::solid_box(3, {1, 0.8, 0.1}), {.pose = {.p = {0, 0, 0.5}}});
  const Vector3 feet[] = {{0.5, 0.4, -0.5}, {-0.5, 0.4, -0.5}, {-0.5, -0.4, -0.5}, {0.5, -0.4, -0.5}};
  for (int i = 0; i < 4; ++i)
    model.add_contact(ground, table, point_on_plane(feet[i]),
                      {.mu = 0.5, .name = "foot" + std::to_string(i)});
  State x = model.rest();
  const double h = 0.01;
  if (method == "event") {
    for (const Cp1Contact& c : solve_cp1(model, x).contacts)
      CHECK((c.force - Vector3(0, 0, 3 * g / 4)).norm() < 1e-9);
    return;
  }
  const auto stepper = make_stepper(method);
  for (int k = 0; k < 3; ++k) {
    const StepReport report = stepper->step(model, x, h);
    REQUIRE(report.advanced());
    for (int i = 0; i < 4; ++i)
      CHECK((report.contact("foot" + std::to_string(i)).impulse / h - Vector3(0, 0, 3 * g / 4)).norm() <
            1e-9);
  }
}

TEST_CASE("a block that slides and turns goes as its feet share its weight, four or five", "[redundant]") {
  const bool middle = GENERATE(false, true);
  CAPTURE(middle);
  const double T = 0.4;
  Block block(middle);
  block.push({1.5, 0.3, 0}, 2);
  const auto right = BlockAlone{block.feet}.at(T, {1.5, 0.3, 0}, 2);
  CHECK(off(block, end_of(block.s, "event", T, 0), right) < 1e-8);
  std::vector<double> errors;
  for (const double h : {0.02, 0.01, 0.005})
    errors.push_back(off(block, end_of(block.s, "ncp2", T, h), right));
  CAPTURE(errors);
  CHECK(std::log2(errors[1] / errors[2]) == Approx(2).margin(0.15));
  CHECK(std::log2(errors[0] / errors[1]) == Approx(2).margin(0.3));
  const double e1 = off(block, end_of(block.s, "ncp", T, 0.01), right),
               e2 = off(block, end_of(block.s, "ncp", T, 0.005), right);
  CHECK(std::log2(e1 / e2) == Approx(1).margin(0.25));
  // lcp but for its polygon
  const double l1 = off(block, end_of(block.s, "lcp", T, 0.002, 8), right),
               l2 = off(block, end_of(block.s, "lcp", T, 0.002, 64), right);
  CHECK(l1 < 0.02);
  CHECK(l2 < 3e-3);
}

TEST_CASE("a foot in the middle changes nothing at rest and straight on, and slows a turn less",
          "[redundant]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2", "event");
  CAPTURE(method);
  const auto end = [&](bool middle, const Vector3& v, double turning) {
    Block block(middle);
    block.push(v, turning);
    return end_of(block.s, method, 0.3, 0.01);
  };
  CHECK((end(true, {0, 0, 0}, 0).q - end(false, {0, 0, 0}, 0).q).norm() < 1e-12);
  CHECK((end(true, {1.5, 0, 0}, 0).q - end(false, {1.5, 0, 0}, 0).q).norm() < 1e-10);
  CHECK((end(true, {0, 0, 0}, 3).q - end(false, {0, 0, 0}, 3).q).norm() > 1e-3);
}

TEST_CASE("contacts in another order, or the scene turned, make the same motion", "[redundant]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2", "event");
  CAPTURE(method);
  const Vector3 v(1.2, 0.5, 0);
  const double T = 0.3, h = 0.01;
  Block first(false), second(false, 0, {2, 0, 3, 1});
  first.push(v, 2);
  second.push(v, 2);
  const State a = end_of(first.s, method, T, h), b = end_of(second.s, method, T, h);
  CHECK((a.q - b.q).norm() < 1e-10);
  CHECK((a.nu - b.nu).norm() < 1e-10);
  // turned by a polygon's angle, so that lcp's polygon turns too
  const double heading = pi / 4;
  Block turned(false, heading);
  turned.push(v, 2, heading);
  const State c = end_of(turned.s, method, T, h);
  const Vector3 there = Eigen::AngleAxisd(heading, Vector3::UnitZ()) * first.s.model.position(a, first.body);
  CHECK((turned.s.model.position(c, turned.body) - there).norm() < 1e-10);
}

TEST_CASE("four driven wheels carry a car alike, whatever the method", "[redundant][joint]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2");
  const double effort = GENERATE(0.5, -0.4);  // N m a wheel: driven from rest, braked from 3 m/s
  CAPTURE(method, effort);
  Model model;
  const BodyId chassis =
      model.add_body(Inertia::solid_box(10, {0.8, 0.4, 0.1}), {.pose = {.p = {0, 0, 0.1}}});
  const Quaternion across(Eigen::AngleAxisd(-pi / 2, Vector3::UnitX()));
  std::vector<BodyId> wheels;
  for (const double x : {0.3, -0.3})
    for (const double y : {0.25, -0.25}) {
      const Vector3 p(x, y, 0.1);
      const BodyId wheel =
          model.add_body(Inertia::solid_cylinder(0.5, 0.1, 0.02), {.pose = {.p = p, .q = across}});
      const JointId hinge = model.add_joint(revolute(chassis, wheel, {.point = p, .axis = {0, 1, 0}}));
      model.add_motor(
          {.joint = hinge, .effort = [=](const Model&, const State&, double, double) { return effort; }});
      model.add_contact(ground, wheel, disc_on_plane(0.1), {.mu = 0.8});
      wheels.push_back(wheel);
    }
  State x = model.rest();
  const double v0 = effort < 0 ? 3 : 0;
  model.set_velocity(x, chassis, {v0, 0, 0});
  for (const BodyId wheel : wheels) model.set_velocity(x, wheel, {v0, 0, 0}, {0, v0 / 0.1, 0});
  const auto stepper = make_stepper(method);
  const State end = simulate(model, *stepper, x, {.t_end = 1, .h = 0.005}).back();
  // 4 torque/r = (m + 4 J/r^2) a, J = m_w r^2/2
  const double a = 4 * effort / 0.1 / (12 + 4 * 0.25);
  CHECK(model.velocity(end, chassis).x() == Approx(v0 + a).epsilon(1e-10));
  CHECK(std::abs(model.position(end, chassis).y()) < 1e-10);
}

TEST_CASE("light feet under a heavy block carry a quarter each", "[redundant]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2");
  const double light = GENERATE(1e-3, 1e-6);
  CAPTURE(method, light);
  Model model;
  const BodyId block = model.add_body(Inertia::solid_box(1, {1, 0.8, 0.5}), {.pose = {.p = {0, 0, 0.45}}});
  for (int i = 0; i < 4; ++i) {
    const Vector3 corner(i < 2 ? 0.5 : -0.5, i % 2 == 0 ? 0.4 : -0.4, -0.25);
    const BodyId foot = model.add_particle(light, {.pose = {.p = {corner.x(), corner.y(), 0.1}}});
    model.add_contact(ground, foot, sphere_on_plane(0.1), {.mu = 0.5, .name = "under" + std::to_string(i)});
    model.add_contact(block, foot, sphere_on_plane(0.1, {{0, 0, -1}, {0, 0, -0.25}}), {.mu = 0.5});
  }
  State x = model.rest();
  const auto stepper = make_stepper(method);
  for (int k = 0; k < 5; ++k) {
    const StepReport report = stepper->step(model, x, 0.01);
    REQUIRE(report.advanced());
    for (int i = 0; i < 4; ++i)
      CHECK(report.contact("under" + std::to_string(i)).p_n / 0.01 ==
            Approx((1 + 4 * light) * g / 4).epsilon(1e-8));
  }
}

TEST_CASE("a soft foot carries less, as its compliance says", "[redundant]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2", "event");
  CAPTURE(method);
  Model model;
  const BodyId table = model.add_body(Inertia::solid_box(3, {1, 0.8, 0.1}), {.pose = {.p = {0, 0, 0.5}}});
  const Vector3 feet[] = {{0.5, 0.4, -0.5}, {-0.5, 0.4, -0.5}, {-0.5, -0.4, -0.5}, {0.5, -0.4, -0.5}};
  for (int i = 0; i < 4; ++i)
    model.add_contact(ground, table, point_on_plane(feet[i]),
                      {.mu = 0.5, .name = "foot" + std::to_string(i), .compliance = i == 0 ? 3.0 : 1.0});
  State x = model.rest();
  const auto stepper = make_stepper(method);
  const double h = method == "event" ? 1 : 0.01;  // impulses of a second, so forces
  StepReport report;
  if (method == "event") report = simulate(model, *stepper, x, {.t_end = 1}).report(0);
  for (int k = 0; method != "event" && k < 3; ++k) report = stepper->step(model, x, h);
  REQUIRE(report.advanced());
  const Cp1Solution cp1 = solve_cp1(model, model.rest());
  // loads 1/4 + a (1, -1, 1, -1) of the weight, least in sum of c p^2: 3 (1/4 + a) + 3 a - 1/4 = 0
  for (int i = 0; i < 4; ++i) {
    const double load = 3 * g * (i % 2 == 0 ? 1.0 / 6 : 1.0 / 3);
    CHECK(cp1.contacts[static_cast<std::size_t>(i)].c_n == Approx(load).epsilon(1e-9));
    const ContactRow foot = report.contact("foot" + std::to_string(i));
    CHECK((method == "event" ? foot.force.z() : foot.p_n / h) == Approx(load).epsilon(1e-9));
  }
  CHECK_THROWS_WITH(
      model.add_contact(ground, table, point_on_plane(Vector3::Zero()), {.name = "no", .compliance = 0}),
      Catch::Contains("compliance") && Catch::Contains("> 0"));
}

TEST_CASE("a door on two hinges is carried by its compliances in m and in rad", "[redundant][joint]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2");
  CAPTURE(method);
  constexpr double m = 20, width = 0.9, apart = 1.4;
  Model model;
  const Inertia inertia = Inertia::solid_box(m, {width, 0.04, 2});
  const BodyId door = model.add_body(inertia, {.pose = {.p = {width / 2, 0, 1}}});
  for (const double z : {1 - apart / 2, 1 + apart / 2})
    model.add_joint(revolute(ground, door, {.point = {0, 0, z}, .axis = {0, 0, 1}}));
  State x = model.rest();
  const auto stepper = make_stepper(method);
  StepReport report;
  for (int k = 0; k < 3; ++k) report = stepper->step(model, x, 0.01);
  REQUIRE(report.advanced());
  // moment m g width/2 = F apart + 2 M with least 2 F^2 + 2 M^2/L^2, L^2 = tr J/(2 m)
  const double J = m / 12 * (width * width + 0.04 * 0.04 + 4 + 0.04 * 0.04 + width * width + 4),
               L2 = J / (2 * m), size = apart * apart / 4 + L2, moment = m * g * width / 2;
  REQUIRE(report.joints.size() == 2);
  for (const JointImpulse& hinge : report.joints) {
    CHECK(hinge.impulse.z() / 0.01 == Approx(m * g / 2).epsilon(1e-8));
    CHECK(std::abs(hinge.impulse.x()) / 0.01 == Approx(moment * apart / 4 / size).epsilon(1e-8));
    CHECK(std::abs(hinge.moment.y()) / 0.01 == Approx(moment * L2 / 2 / size).epsilon(1e-8));
  }
}
