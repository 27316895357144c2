#include "perp/instant/near_contacts.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "perp/instant/instant.hpp"
#include "tests/instant/random_systems.hpp"

using namespace perp;
using namespace perp::testing;

TEST_CASE("no contact nearer than the margin is missed, however bodies move or jump", "[near_contacts]") {
  Random random(5);
  Model model;
  std::vector<BodyId> bodies;
  for (int i = 0; i < 14; ++i) bodies.push_back(model.add_body(random.inertia()));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    model.add_contact(ground, bodies[i], box_on_plane({0.4, 0.3, 0.5}));
    for (std::size_t j = 0; j < i; ++j) model.add_contact(bodies[i], bodies[j], sphere_on_sphere(0.2, 0.2));
  }
  const std::size_t contacts = model.contacts().size();
  REQUIRE(contacts >= NearContacts::worth_it);
  NearContacts near;
  State x = disturbed(model, random, 4);
  int left_out = 0, found = 0;
  for (int k = 0; k < 400; ++k) {
    const double margin = k % 7 == 0 ? 1 : 0.1;
    if (k % 50 == 49)
      x = disturbed(model, random, 4);  // a jump
    else
      move(model, Vector::NullaryExpr(model.nv(), [&] { return random.number(); }), 0.1, x.q);
    Instant s;
    evaluate(model, x, s);
    const std::vector<int>& answer = near.find(model, s.X, x.t, margin);
    CHECK(std::is_sorted(answer.begin(), answer.end()));
    for (const ContactInstant& c : s.contacts)
      if (c.psi_n <= margin) CHECK(std::binary_search(answer.begin(), answer.end(), c.contact));
    left_out += static_cast<int>(contacts - answer.size());
    found += static_cast<int>(answer.size());
  }
  CHECK(near.selective());
  CHECK(left_out > 100 * 400 / 4);
  CHECK(found > 0);
}

TEST_CASE("how far gaps may have shrunk bounds how far they have", "[near_contacts]") {
  Random random(6);
  Model model;
  std::vector<BodyId> bodies;
  for (int i = 0; i < 70; ++i) {
    bodies.push_back(model.add_body(random.inertia()));
    model.add_contact(ground, bodies.back(), box_on_plane({0.4, 0.3, 0.5}));
  }
  NearContacts near;
  const State x = disturbed(model, random, 1);
  Instant before, after;
  evaluate(model, x, before);
  near.find(model, before.X, 0, 0.1);
  State y = x;
  move(model, Vector::NullaryExpr(model.nv(), [&] { return random.number(); }), 0.2, y.q);
  evaluate(model, y, after);
  const double bound = near.travel_to(model, after.X);
  double shrunk = 0;
  for (std::size_t i = 0; i < before.contacts.size(); ++i)
    shrunk = std::max(shrunk, before.contacts[i].psi_n - after.contacts[i].psi_n);
  CHECK(shrunk <= bound);
  CHECK(shrunk > bound / 10);
}

TEST_CASE("no pair of shapes nearer than the margin is missed, whatever their kinds", "[near_contacts]") {
  Random random(9);
  Model model;
  model.add_shape(ground, Shape::half_space());
  model.add_shape(ground, Shape::box({1, 2, 0.3}), {.pose = {.p = {1, 0, 0}}});
  const BodyId plate = model.add_prescribed(PrescribedMotion::turntable({1, 0, 0}, 1, {{0, 0, 3}}));
  model.add_shape(plate, Shape::half_space(), {.pose = {.p = {0, 0, -9}}});
  model.no_contact(ground, plate);
  const Shape kinds[] = {Shape::sphere(0.2), Shape::box({0.3, 0.2, 0.5}), Shape::capsule(0.1, 0.6),
                         Shape::polyhedron({{0, 0, 0}, {0.4, 0, 0}, {0, 0.3, 0}, {0, 0, 0.5}})};
  for (int i = 0; i < 24; ++i) {
    const BodyId body = model.add_body(random.inertia());
    model.add_shape(body, kinds[i % 4], {.pose = {.p = {0, 0.1 * (i % 3), 0}}});
    if (i % 5 == 0) model.add_shape(body, Shape::sphere(0.1), {.pose = {.p = {0, 0, 0.5}}});
  }
  REQUIRE(model.touching_contacts() >= NearContacts::worth_it);
  NearContacts near;
  int left_out = 0, found = 0;
  State x = disturbed(model, random, 4);
  for (int k = 0; k < 60; ++k) {
    const double margin = k % 7 == 0 ? 1 : 0.1;
    if (k % 20 == 19)
      x = disturbed(model, random, 4);
    else
      move(model, Vector::NullaryExpr(model.nv(), [&] { return random.number(); }), 0.1, x.q);
    Instant s, only;
    evaluate(model, x, s);
    const std::vector<int>& answer = near.find(model, s.X, x.t, margin);
    CHECK(std::is_sorted(answer.begin(), answer.end()));
    for (const ContactInstant& c : s.contacts)
      if (c.psi_n <= margin) REQUIRE(std::binary_search(answer.begin(), answer.end(), c.contact));
    evaluate(model, x, only, nullptr, &answer);
    REQUIRE(only.gap_min() == s.gap_min());
    left_out += model.contact_count() - static_cast<int>(answer.size());
    found += static_cast<int>(answer.size());
  }
  CHECK(near.selective());
  CHECK(left_out > 60 * 100);
  CHECK(found > 0);
}

TEST_CASE("many shapes have contacts by the same names and forces as few", "[near_contacts]") {
  // what is found of pairs by their numbers is what the pairs are
  Model model;
  for (int i = 0; i < 95; ++i) {
    const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.5), {.name = "ball-" + std::to_string(i)});
    model.add_shape(ball, i % 3 == 0 ? Shape::box({1, 1, 1}) : Shape::sphere(0.5), {.name = "s"});
  }
  State x = model.rest();
  for (int i = 0; i < 95; ++i)
    model.set_position(x, {i + 1}, {1.25 * (i % 5), 1.25 * (i / 5 % 5), 1.25 * (i / 25)});
  NearContacts near;
  Instant s;
  evaluate_loads(model, x, s);
  evaluate(model, x, s, nullptr, &near.find(model, s.X, 0, 0.3));
  CHECK(s.contacts.size() > 100);
  int last = -1;
  for (const ContactInstant& c : s.contacts) {
    CHECK(c.point > last);
    last = c.point;
    const std::string name = (*model.point_names())[static_cast<std::size_t>(c.point)];
    CHECK(name.starts_with("ball-" + std::to_string(c.W.a - 1) + ".s|ball-" + std::to_string(c.W.b - 1) +
                           ".s"));
    CHECK(model.point_names()->find(name) == c.point);
    CHECK(model.contact_of_point(c.point) == c.contact);
    CHECK(s.contact_of_point[static_cast<std::size_t>(c.point)] == static_cast<int>(&c - s.contacts.data()));
  }
  CHECK(model.point_names()->find("ball-1.s|ball-2.t") == -1);
  CHECK(model.point_names()->find("ball-1.s") == -1);
}
