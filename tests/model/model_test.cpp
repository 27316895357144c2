#include "perp/model/model.hpp"

#include <catch2/catch.hpp>

#include "perp/model/gaps.hpp"

using namespace perp;
using Catch::Contains;

TEST_CASE("bodies take coordinates by their kind, the ground and prescribed ones none", "[model]") {
  Model model;
  model.add_prescribed(PrescribedMotion::belt({1, 0, 0}));
  model.add_particle(1);
  model.add_planar_body(1, 1);
  model.add_body(Inertia::solid_sphere(1, 1));
  CHECK(model.nq() == 3 + 3 + 7);
  CHECK(model.nv() == 3 + 3 + 6);
}

TEST_CASE("what a state is given in world axes it gives back", "[model][state]") {
  Model model;
  const BodyId body = model.add_body(Inertia::principal(1, {1, 2, 2.5}), {.name = "body"});
  const BodyId plate = model.add_planar_body(2, 3);
  State x = model.rest();
  const Quaternion q = rotation({0.3, -0.5, 1.2});
  model.set_position(x, body, {1, 2, 3});
  model.set_orientation(x, body, q);
  model.set_velocity(x, body, {4, 5, 6}, {7, 8, 9});
  CHECK(model.position(x, body) == Vector3(1, 2, 3));
  CHECK(model.pose(x, body).q.angularDistance(q) < 1e-15);
  CHECK(model.velocity(x, body) == Vector3(4, 5, 6));
  CHECK(model.angular_velocity(x, body).isApprox(Vector3(7, 8, 9), 1e-15));
  CHECK(x.nu.segment<3>(3).isApprox(q.conjugate() * Vector3(7, 8, 9)));  // kept in body axes

  model.set_orientation(x, plate, rotation({0, 0, 0.7}));
  model.set_velocity(x, plate, {1, 2, 0}, {0, 0, 3});
  CHECK(model.angle(x, plate) == Approx(0.7));
  CHECK(model.angular_velocity(x, plate) == Vector3(0, 0, 3));
}

TEST_CASE("energy and momentum are those of the textbook", "[model]") {
  Model model;
  const BodyId a = model.add_body(Inertia::principal(2, {1, 2, 2.5}));
  const BodyId b = model.add_particle(3);
  model.add_spring({.a = a, .b = b, .stiffness = 10, .length = 1});
  State x = model.rest();
  const Quaternion q = rotation({0, 0, 1.1});
  model.set_orientation(x, a, q);
  model.set_position(x, b, {0, 0, 4});
  model.set_velocity(x, a, {1, 0, 0}, q * Vector3(1, 1, 1));
  model.set_velocity(x, b, {0, 2, 0});
  CHECK(model.kinetic_energy(x) == Approx(0.5 * 2 * 1 + 0.5 * (1 + 2 + 2.5) + 0.5 * 3 * 4));
  CHECK(model.energy(x) == Approx(model.kinetic_energy(x) + 3 * 9.81 * 4 + 0.5 * 10 * 3 * 3));
  const Momentum momentum = model.momentum(x);
  CHECK(momentum.linear.isApprox(Vector3(2, 6, 0)));
  CHECK(momentum.angular.isApprox(q * Vector3(1, 2, 2.5) + Vector3(0, 0, 4).cross(Vector3(0, 6, 0))));
}

TEST_CASE("move follows a constant velocity exactly, in space and about an axis", "[model][state]") {
  Model model;
  const BodyId body = model.add_body(Inertia::solid_sphere(1, 1));
  State x = model.rest();
  model.set_velocity(x, body, {1, 2, 3}, {0, 0, 2});
  move(model, x.nu, 0.25, x.q);
  CHECK(model.position(x, body).isApprox(Vector3(0.25, 0.5, 0.75)));
  CHECK(model.pose(x, body).q.angularDistance(rotation({0, 0, 0.5})) < 1e-15);
}

TEST_CASE("bad bodies, contacts, joints and states are refused by name", "[model]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1), {.name = "ball"});
  const BodyId belt = model.add_prescribed(PrescribedMotion::belt({1, 0, 0}));
  CHECK_THROWS_WITH(model.add_particle(0), Contains("mass is 0"));
  CHECK_THROWS_WITH(model.add_planar_body(1, -1), Contains("J is -1"));
  CHECK_THROWS_WITH(model.add_particle(1, {.name = "ball"}), Contains("name is ball") && Contains("taken"));
  CHECK_THROWS_WITH(model.add_contact(ball, ball, sphere_on_plane(1), {.name = "self"}),
                    Contains("contact 'self'") && Contains("two different bodies"));
  CHECK_THROWS_WITH(model.add_contact(ground, belt, sphere_on_plane(1)), Contains("able to move"));
  CHECK_THROWS_WITH(model.add_contact(ground, {7}, sphere_on_plane(1)), Contains("b is 7"));
  CHECK_THROWS_WITH(model.add_contact(ground, ball, sphere_on_plane(1), {.mu = -0.1}),
                    Contains("mu is -0.1"));
  CHECK_THROWS_WITH(model.add_contact(ground, ball, sphere_on_plane(1), {.e = 1.5}), Contains("e is 1.5"));
  CHECK_THROWS_WITH(model.set_gravity({0, not_set, 0}), Contains("g is nan"));
  CHECK_THROWS_WITH(model.add_spring({.a = ground, .b = ball, .stiffness = -1}), Contains("stiffness is -1"));
  CHECK_THROWS_WITH(model.add_prescribed({}), Contains("motion"));
  CHECK_THROWS_WITH(model.find_body("bell"), Contains("bell") && Contains("ground, ball"));
  CHECK(model.contacts().empty());  // what was refused left nothing behind

  State x = model.rest();
  CHECK_THROWS_WITH(model.set_velocity(x, ball, {not_set, 0, 0}), Contains("v is nan"));
  CHECK_THROWS_WITH(model.set_position(x, ground, {1, 0, 0}), Contains("ground"));
  x.q[2] = not_set;
  CHECK_THROWS_WITH(model.check("here", x), Contains("here: x.q is nan"));
  x.q.resize(3);
  CHECK_THROWS_WITH(model.check("here", x), Contains("size 3") && Contains("size 7"));
}

TEST_CASE("a refused contact does not take its name", "[model]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1));
  CHECK_THROWS(model.add_contact(ground, ball, sphere_on_plane(1), {.mu = -1, .name = "floor"}));
  CHECK_NOTHROW(model.add_contact(ground, ball, sphere_on_plane(1), {.name = "floor"}));
  CHECK_THROWS_WITH(model.add_contact(ground, ball, sphere_on_plane(1), {.name = "floor"}),
                    Contains("taken"));
}

TEST_CASE("planar bodies stay in the plane: poses and velocities out of it are refused", "[model]") {
  Model model;
  CHECK_THROWS_WITH(model.add_planar_body(1, 1, {.pose = {{0, 0, 1}, Quaternion::Identity()}}),
                    Contains("plane"));
  const BodyId plate = model.add_planar_body(1, 1);
  State x = model.rest();
  CHECK_THROWS(model.set_position(x, plate, {0, 0, 1}));
  CHECK_THROWS(model.set_velocity(x, plate, {0, 0, 1}));
  CHECK_THROWS(model.set_velocity(x, plate, {1, 0, 0}, {1, 0, 0}));
  CHECK_THROWS(model.set_orientation(x, plate, rotation({1, 0, 0})));
}

TEST_CASE("every change gives a model a new revision, a copy keeps it", "[model]") {
  Model model;
  const auto empty = model.revision();
  model.add_particle(1);
  CHECK(model.revision() != empty);
  const Model copy = model;
  CHECK(copy.revision() == model.revision());
  model.set_gravity(Vector3::Zero());
  CHECK(copy.revision() != model.revision());
  CHECK(Model().revision() != Model().revision());
}
