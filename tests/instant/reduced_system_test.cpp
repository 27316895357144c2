#include "perp/instant/reduced_system.hpp"

#include <catch2/catch.hpp>
#include <Eigen/Dense>
#include <numeric>

#include "tests/instant/random_systems.hpp"

using namespace perp;
using namespace perp::testing;

namespace {

/// Three spatial bodies: a on the floor, b hinged to a, c hinged to b with friction and touching the floor and a.
Model chain(Random& random, bool doubled_joint) {
  Model model;
  const BodyId a = model.add_body(random.inertia(), {.pose = {{0, 0, 1}, random.orientation()}});
  const BodyId b = model.add_body(random.inertia(), {.pose = {{1, 0, 1}, random.orientation()}});
  const BodyId c = model.add_body(random.inertia(), {.pose = {{2, 0, 1}, random.orientation()}});
  model.add_contact(ground, a, sphere_on_plane(1), {.mu = 0.3});
  model.add_contact(c, ground, sphere_on_sphere(1, 0.5));
  model.add_contact(a, c, sphere_on_sphere(1, 1), {.mu = 0.3});
  model.add_joint(revolute(a, b, {.point = {0.5, 0, 1}, .axis = {0, 1, 0}}));
  model.add_joint(revolute(b, c, {.point = {1.5, 0, 1}, .axis = {0, 1, 0.2}, .friction = 0.4}));
  if (doubled_joint) model.add_joint(revolute(a, b, {.point = {0.5, 0, 1}, .axis = {0, 1, 0}}));
  return model;
}

template <int C>
Matrix dense(const WrenchMap<C>& W, int nv) {
  Matrix out = Matrix::Zero(nv, C);
  out.middleRows(W.va, W.na) += W.A.topRows(W.na);
  out.middleRows(W.vb, W.nb) += W.B.topRows(W.nb);
  return out;
}

}  // namespace

TEST_CASE("the reduced system is (43)-(46) without forming A11", "[reduced_system]") {
  const bool redundant = GENERATE(false, true);
  Random random(4);
  const Model model = chain(random, redundant);
  const State x = disturbed(model, random, redundant ? 0.0 : 0.1);
  Instant s;
  evaluate(model, x, s);
  std::vector<int> active(s.contacts.size());
  std::iota(active.begin(), active.end(), 0);
  Islands islands;
  islands.find(model, s, active);
  REQUIRE(islands.get().size() == 1);
  const int nv = model.nv(), nb = static_cast<int>(s.joint_rows.size());
  Vector bias = Vector::NullaryExpr(nb, [&] { return random.number(); });
  if (redundant) bias.tail(5) = bias.head(5);  // a doubled joint that asks for the same
  ReducedSystem reduced;
  reduced.assemble(model, s, islands.get()[0], x.nu, bias);

  // dense matrices, in the seed's letters
  Matrix M(nv, nv), W_b(nv, nb), W_r(nv, 3 + 1 + 3 + 1);
  Vector column;
  for (int i = 0; i < nv; ++i) {
    multiply_mass(model, s, Vector::Unit(nv, i), column);
    M.col(i) = column;
  }
  for (int i = 0; i < nb; ++i) W_b.col(i) = dense(s.joint_rows[static_cast<std::size_t>(i)].W, nv);
  W_r << dense(s.contacts[0].W, nv), dense(s.contacts[1].W, nv).leftCols(1), dense(s.contacts[2].W, nv),
      dense(s.joint_frictions[0].W, nv);
  const Matrix M_inverse = M.inverse();
  const Matrix B = -W_b.transpose() * M_inverse * W_b;
  const Matrix B_inverse = B.completeOrthogonalDecomposition().pseudoInverse();
  const Matrix A11 = M_inverse + M_inverse * W_b * B_inverse * W_b.transpose() * M_inverse;
  const Matrix A12 = M_inverse * W_b * B_inverse;
  CHECK((reduced.W - W_r.transpose() * A11 * W_r).norm() < 1e-12 * reduced.W.norm());
  Vector explicit_part(8);
  explicit_part << s.contacts[0].bias, s.contacts[1].bias.head(1), s.contacts[2].bias,
      s.joint_frictions[0].psi_b_t;
  const Vector r_47 = A11 * M * x.nu + A12 * bias;  // (47): x2 of (42) is -W_b^T nu+
  CHECK((reduced.q - (W_r.transpose() * r_47 + explicit_part)).norm() < 1e-11 * reduced.q.norm());

  // impulses r give velocities that satisfy the joints and u = W r + q
  const Vector r = Vector::NullaryExpr(8, [&] { return random.number(); });
  Vector impulse = Vector::Zero(nv), reactions = Vector::Zero(nb);
  reduced.add_impulses(s, islands.get()[0], r, impulse, reactions);
  const Vector nu = x.nu + M_inverse * impulse;
  CHECK((W_b.transpose() * nu + bias).norm() < 1e-11);
  CHECK((W_r.transpose() * nu + explicit_part - (reduced.W * r + reduced.q)).norm() < 1e-11);
  CHECK((W_r * r + W_b * reactions - impulse).norm() < 1e-12);
}

TEST_CASE("bodies that only share the ground are islands of their own", "[islands]") {
  Model model;
  std::vector<BodyId> balls;
  for (int i = 0; i < 4; ++i)
    balls.push_back(model.add_body(Inertia::solid_sphere(1, 1), {.pose = {{2.0 * i, 0, 1}, {1, 0, 0, 0}}}));
  for (const BodyId ball : balls) model.add_contact(ground, ball, sphere_on_plane(1));
  model.add_contact(balls[3], balls[1], sphere_on_sphere(1, 1));
  model.add_contact(balls[2], balls[0], sphere_on_sphere(1, 1));
  Instant s;
  evaluate(model, model.rest(), s);
  Islands islands;
  const std::vector<int> active = {0, 1, 2, 3, 4};  // the last contact is out of reach
  islands.find(model, s, active);
  REQUIRE(islands.get().size() == 3);
  CHECK(islands.get()[0].contacts == std::vector<int>{0});
  CHECK(islands.get()[1].contacts == std::vector<int>{1, 3, 4});
  CHECK(islands.get()[2].contacts == std::vector<int>{2});
  islands.find(model, s, {});
  CHECK(islands.get().empty());
}

TEST_CASE("joints tie islands, bodies prescribed do not", "[islands]") {
  Model model;
  const BodyId belt = model.add_prescribed(PrescribedMotion::belt({1, 0, 0}));
  const BodyId a = model.add_particle(1), b = model.add_particle(1), c = model.add_particle(1);
  model.add_joint(ball(belt, b));
  model.add_joint(ball(belt, c));
  model.add_joint(ball(a, c));
  Instant s;
  evaluate(model, model.rest(), s);
  Islands islands;
  islands.find(model, s, {});
  REQUIRE(islands.get().size() == 2);
  CHECK(islands.get()[0].joint_rows == std::vector<int>{3, 4, 5, 6, 7, 8});
  CHECK(islands.get()[1].joint_rows == std::vector<int>{0, 1, 2});
}
