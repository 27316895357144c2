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
