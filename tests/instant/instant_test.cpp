#include "perp/instant/instant.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/instant/random_systems.hpp"

using namespace perp;
using namespace perp::testing;

TEST_CASE("a gap's rate is W_n^T nu plus its explicit part, for every kind of body", "[instant]") {
  const auto seed = GENERATE(range(0u, 20u));
  Random random(seed);
  const Model model = all_kinds(random);
  const State x = disturbed(model, random, 0.1);
  const double h = 1e-6;
  Instant s, before, after;
  evaluate(model, x, s);
  evaluate(model, moved(model, x, -h), before);
  evaluate(model, moved(model, x, h), after);
  REQUIRE(s.fault.empty());
  REQUIRE(s.contacts.size() == 8 + 1 + 2 + 1 + 1 + 4 + 1);
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    CAPTURE(seed, i);
    const double difference = (after.contacts[i].psi_n - before.contacts[i].psi_n) / (2 * h);
    CHECK(s.contacts[i].velocity(x.nu).x() == Approx(difference).epsilon(1e-8).margin(1e-8));
  }
}

TEST_CASE("relative velocities along n, t and o are those of the two bodies' material points", "[instant]") {
  Random random(3);
  const Model model = all_kinds(random);
  const State x = disturbed(model, random, 0.1);
  Instant s;
  evaluate(model, x, s);
  for (const ContactInstant& c : s.contacts) {
    const Contact& contact = model.contacts()[static_cast<std::size_t>(c.contact)];
    const auto at = [&](BodyId body) {
      return model.twist(x, body).at(c.position - model.position(x, body));
    };
    const Vector3 u = c.frame.transpose() * (at(contact.b) - at(contact.a));
    const Vector3 shown = c.velocity(x.nu);
    for (int j = 0; j <= c.tangents; ++j) CHECK(shown[j] == Approx(u[j]).margin(1e-14));
    CHECK(c.tangents == (contact.mu == 0 ? 0 : model.body(contact.b).kind == BodyKind::Planar ? 1 : 2));
  }
}

TEST_CASE("a belt drags along its surface and does not open the gap", "[instant]") {
  Model model;
  const BodyId belt = model.add_prescribed(PrescribedMotion::belt({3, 4, 5}));
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1), {.pose = {{0, 0, 1}, {1, 0, 0, 0}}});
  model.add_contact(belt, ball, sphere_on_plane(1), {.mu = 0.5});
  Instant s;
  evaluate(model, model.rest(), s);
  CHECK(s.contacts[0].velocity(Vector::Zero(6)).isApprox(Vector3(0, -3, -4)));
}

TEST_CASE("k holds gravity, gyroscopic terms, springs, dampers and loads", "[instant]") {
  Model model;
  const BodyId body = model.add_body(Inertia::principal(2, {1, 2, 2.5}));
  model.set_gravity({1, 2, 3});
  State x = model.rest();
  const Quaternion q = rotation({0.4, 0.2, -0.3});
  model.set_orientation(x, body, q);
  model.set_velocity(x, body, {0, 0, 1}, q * Vector3(1, 2, 3));
  const Vector3 gyroscopic = -Vector3(1, 2, 3).cross(Vector3(1, 4, 7.5));
  Instant s;
  evaluate(model, x, s);
  CHECK(s.k.head<3>().isApprox(Vector3(2, 4, 6)));
  CHECK(s.k.tail<3>().isApprox(gyroscopic));

  model.set_gravity(Vector3::Zero());
  model.add_spring(
      {.a = ground, .b = body, .point_a = {0, 0, -2}, .stiffness = 10, .damping = 3, .length = 0.5});
  evaluate(model, x, s);
  CHECK(s.k.head<3>().isApprox(Vector3(0, 0, -10 * 1.5 - 3)));

  model.add_force(body, [](const Model&, const State& state) { return Wrench{{0, state.t, 0}, {0, 0, 7}}; });
  x.t = 5;
  evaluate(model, x, s);
  CHECK(s.k.head<3>().isApprox(Vector3(0, 5, -10 * 1.5 - 3)));
  CHECK(s.k.tail<3>().isApprox(gyroscopic + q.conjugate() * Vector3(0, 0, 7)));
}

TEST_CASE("spring forces are minus the gradient of the energy", "[instant]") {
  Random random(5);
  Model model;
  const BodyId a = model.add_body(random.inertia()), b = model.add_particle(1);
  model.add_spring({.a = a, .b = b, .point_a = {0.3, 0.1, 0}, .point_b = {}, .stiffness = 7, .length = 0.4});
  const State x = disturbed(model, random, 1);
  Instant s;
  State rest = x;
  rest.nu.setZero();
  evaluate(model, rest, s);
  for (int i = 0; i < model.nv(); ++i) {
    State plus = rest, minus = rest;
    move(model, Vector::Unit(model.nv(), i), 1e-6, plus.q);
    move(model, Vector::Unit(model.nv(), i), -1e-6, minus.q);
    CHECK(s.k[i] == Approx(-(model.energy(plus) - model.energy(minus)) / 2e-6).margin(1e-7));
  }
}

TEST_CASE("a joint's equations change at the rate W_b^T nu plus their explicit part", "[instant][joint]") {
  const auto seed = GENERATE(range(0u, 10u));
  Random random(seed);
  Model model;
  const BodyId shaker =
      model.add_prescribed(PrescribedMotion::turntable({0.3, 1, 0.2}, 2, {{0, 0, 1}, {1, 0, 0, 0}}));
  const BodyId a = model.add_body(random.inertia(), {.pose = {random.vector(), random.orientation()}});
  const BodyId b = model.add_body(random.inertia(), {.pose = {random.vector(), random.orientation()}});
  const auto options = [&] { return JointOptions{.point = random.vector(), .axis = random.vector()}; };
  model.add_joint(fixed(a, b, options()));
  model.add_joint(ball(shaker, a, options()));
  model.add_joint(revolute(a, b, options()));
  JointOptions dry = options();
  dry.friction = 1;
  model.add_joint(prismatic(b, shaker, dry));
  model.add_joint(revolute(b, a, dry));
  const State x = disturbed(model, random, 0.2);
  const double h = 1e-6;
  Instant s, before, after;
  evaluate(model, x, s);
  evaluate(model, moved(model, x, -h), before);
  evaluate(model, moved(model, x, h), after);
  REQUIRE(s.joint_rows.size() == 6 + 3 + 5 + 5 + 5);
  for (std::size_t i = 0; i < s.joint_rows.size(); ++i) {
    const double difference = (after.joint_rows[i].psi_b - before.joint_rows[i].psi_b) / (2 * h);
    CAPTURE(seed, i);
    CHECK(s.joint_rows[i].velocity(x.nu) == Approx(difference).epsilon(1e-7).margin(1e-7));
  }
  REQUIRE(s.joint_frictions.size() == 2);
}

TEST_CASE("joints hold, and their coordinates are zero, where they were defined", "[instant][joint]") {
  Random random(1);
  Model model;
  const BodyId a = model.add_body(random.inertia(), {.pose = {random.vector(), random.orientation()}});
  const BodyId b = model.add_body(random.inertia(), {.pose = {random.vector(), random.orientation()}});
  const JointOptions options{.point = random.vector(), .axis = random.vector(), .friction = 1};
  model.add_joint(revolute(a, b, options));
  Instant s;
  evaluate(model, model.rest(), s);
  CHECK(s.joint_error() < 1e-15);
  CHECK(std::abs(s.joint_frictions[0].psi_b) < 1e-15);

  // b turned about the axis by 0.3 still satisfies the joint, whose coordinate is then 0.3
  State x = model.rest();
  const Quaternion turn = rotation(0.3 * options.axis.normalized());
  const Pose X = model.pose(x, b);
  model.set_position(x, b, options.point + turn * (X.p - options.point));
  model.set_orientation(x, b, turn * X.q);
  evaluate(model, x, s);
  CHECK(s.joint_error() < 1e-15);
  CHECK(s.joint_frictions[0].psi_b == Approx(0.3));
}

TEST_CASE("a gap that is not finite is named, with the time", "[instant]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1));
  model.add_contact(ground, ball, Gap([](const Pose&, const Pose&, double t) {
                      return ContactPoint{.gap = std::sqrt(1 - t)};
                    }),
                    {.name = "pit"});
  State x = model.rest();
  Instant s;
  evaluate(model, x, s);
  CHECK(s.fault.empty());
  x.t = 1.5;
  evaluate(model, x, s);
  CHECK(s.fault == "gap of contact 'pit' is not finite at t = 1.5");
}

TEST_CASE("solving and multiplying by the mass matrix undo each other", "[instant]") {
  Random random(7);
  Model model = all_kinds(random);
  const auto mass = [](const Vector& q) -> Matrix {
    return Eigen::Matrix2d{{2 + std::cos(q[0]), std::sin(q[1])}, {std::sin(q[1]), 3}};
  };
  const auto none = [](const Vector&, const Vector&, double) -> Vector { return Vector::Zero(2); };
  const BodyId own = model.add_generalized(2, {.mass = mass, .force = none});
  const Vector nu = Vector::NullaryExpr(model.nv(), [&] { return random.number(); });
  State x = model.rest();
  model.set_coordinates(x, own, Vector2(0.3, 0.7), Vector2::Zero());
  x.nu = nu;
  Instant s;
  evaluate(model, x, s);
  Vector f, back;
  multiply_mass(model, s, nu, f);
  solve_mass(model, s, f, back);
  CHECK((back - nu).norm() < 1e-13);
  CHECK(0.5 * nu.dot(f) == Approx(model.kinetic_energy(x)));
}
