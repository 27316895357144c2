#include "perp/instant/derivatives.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/instant/random_systems.hpp"

using namespace perp;
using namespace perp::testing;

namespace {

/// A body of two coordinates with all that may depend on (q, nu, t).
void add_own(Model& model) {
  const auto mass = [](const Vector& q) -> Matrix {
    return Eigen::Matrix2d{{2 + std::cos(q[0]), std::sin(q[1])}, {std::sin(q[1]), 3}};
  };
  const auto force = [](const Vector& q, const Vector& nu, double t) -> Vector {
    return Vector2(std::sin(q[0]) * nu[1] * nu[1] - q[1], t * nu[0] - q[0] * q[1]);
  };
  const BodyId own = model.add_generalized(2, {.mass = mass, .force = force}, "own");
  const GeneralizedGap gap = [](const Vector& q, double t) {
    GeneralizedPoint p{.gap = std::sin(q[0]) * q[1] + std::cos(3 * t) * q[0]};
    p.normal = Vector2(std::cos(q[0]) * q[1] + std::cos(3 * t), std::sin(q[0]));
    p.gap_t = -3 * std::sin(3 * t) * q[0];
    p.tangent = Vector2(q[1] * t, std::exp(q[0]));
    p.tangent_t = std::sin(q[0] * t);
    return p;
  };
  model.add_contact(own, gap, {.mu = 0.3, .name = "own, rough"});
  model.add_contact(own, gap, {.name = "own, smooth"});
}

/// all_kinds with joints of every sort, springs and a load of one's own.
Model everything(Random& random) {
  Model model = all_kinds(random);
  const BodyId a{1}, b{2}, plate{3}, bead{4}, shaker{5}, table{6};
  const auto options = [&](double friction) {
    return JointOptions{.point = random.vector(), .axis = random.vector(), .friction = friction};
  };
  model.add_joint(revolute(a, b, options(0.5)));
  model.add_joint(prismatic(a, b, options(0.5)));
  model.add_joint(fixed(shaker, a, options(0)));
  model.add_joint(ball(b, table, options(0)));
  model.add_joint(revolute(table, b, options(0.2)));
  model.add_joint(prismatic(shaker, a, options(0.2)));
  model.add_spring({.a = a,
                    .b = b,
                    .point_a = random.vector(),
                    .point_b = random.vector(),
                    .stiffness = 3,
                    .damping = 0.7,
                    .length = 0.4});
  model.add_spring(
      {.a = plate, .b = bead, .point_a = {0.1, 0.2, 0}, .stiffness = 3, .damping = 0.4, .length = 0.4});
  model.add_spring({.a = shaker, .b = b, .point_a = random.vector(), .stiffness = 2, .damping = 0.3});
  const JointId hinge = model.add_joint(cylindrical(a, b, {.point = {0.3, 0.2, 0.1}, .axis = {1, 2, 3}}));
  model.add_joint_spring({.joint = hinge, .stiffness = 2, .damping = 0.3, .rest = 0.1});
  model.add_joint_spring({.joint = hinge, .stiffness = 1, .damping = 0.2, .coordinate = 1});
  model.add_motor({.joint = hinge, .effort = [b](const Model& m, const State& x, double c, double rate) {
                     return c * c - 0.3 * rate * rate + m.position(x, b).x();
                   }});
  model.add_force(a, [a, b](const Model& m, const State& x) {
    const Vector3 d = m.position(x, b) - m.position(x, a);
    return Wrench{d.squaredNorm() * d, m.angular_velocity(x, a).cross(d)};
  });
  add_own(model);
  return model;
}

State moved_by(const Model& model, const State& x, const Vector& xi, double s) {
  State y = x;
  move(model, xi, s, y.q);
  return y;
}

constexpr double step = 1e-5;
constexpr double tolerance = 5e-7;  // central differences of functions of size 1..10, some of them steep

}  // namespace

TEST_CASE("the acceleration bias of contacts and joints is the rate of their velocities at constant nu",
          "[derivatives]") {
  const auto seed = GENERATE(range(0u, 10u));
  Random random(seed);
  const Model model = everything(random);
  const State x = disturbed(model, random, 0.1);
  Instant s, before, after;
  evaluate(model, x, s);
  evaluate(model, moved(model, x, -step), before, &s);
  evaluate(model, moved(model, x, step), after, &s);
  ContactDerivatives geometry;
  geometry.evaluate(model, s);
  Instant same;
  evaluate(model, x, same, &s);
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const Vector3 rate = (after.contacts[i].velocity(x.nu) - before.contacts[i].velocity(x.nu)) / (2 * step);
    CAPTURE(seed, i);
    const Vector3 bias = acceleration_bias(model, x, same, same.contacts[i], geometry[i]);
    CHECK((bias - rate).head(1 + s.contacts[i].tangents).norm() < tolerance);
    if (!model.contacts()[static_cast<std::size_t>(s.contacts[i].contact)].own) continue;
    PairDerivative<3> d;  // found along each coordinate and time, the bias along the motion
    differentiate(model, x, same, same.contacts[i], geometry[i], Vector3::Zero(), d);
    const WrenchMap<3>& W = s.contacts[i].W;
    const Vector3 sum = d.velocity.middleCols(6, W.nb) * x.nu.segment(W.vb, W.nb) + d.velocity_t;
    CHECK((bias - sum).norm() < 1e-10);
  }
  const auto check = [&](const std::vector<JointRowInstant>& now, const std::vector<JointRowInstant>& then,
                         const std::vector<JointRowInstant>& later) {
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double rate = (later[i].velocity(x.nu) - then[i].velocity(x.nu)) / (2 * step);
      CAPTURE(seed, i);
      CHECK(std::abs(acceleration_bias(model, x, s, now[i]) - rate) < tolerance);
    }
  };
  check(s.joint_rows, before.joint_rows, after.joint_rows);
  check(s.joint_frictions, before.joint_frictions, after.joint_frictions);
}

TEST_CASE("W p changes with the configuration as differentiate says, for contacts and joints",
          "[derivatives]") {
  const auto seed = GENERATE(range(0u, 10u));
  Random random(seed);
  const Model model = everything(random);
  const State x = disturbed(model, random, 0.1);
  const Vector xi = Vector::NullaryExpr(model.nv(), [&] { return random.number(); });
  Instant s, before, after;
  evaluate(model, x, s);
  evaluate(model, moved_by(model, x, xi, -step), before, &s);
  evaluate(model, moved_by(model, x, xi, step), after, &s);
  ContactDerivatives geometry;
  geometry.evaluate(model, s);
  const auto expected = [&](const auto& W, const Eigen::Matrix<double, 12, 12>& force) {
    Eigen::Matrix<double, 12, 1> local = Eigen::Matrix<double, 12, 1>::Zero();
    for (int i = 0; i < W.na; ++i) local[i] = xi[W.va + i];
    for (int i = 0; i < W.nb; ++i) local[6 + i] = xi[W.vb + i];
    local = force * local;
    Vector f = Vector::Zero(model.nv());
    for (int i = 0; i < W.na; ++i) f[W.va + i] += local[i];
    for (int i = 0; i < W.nb; ++i) f[W.vb + i] += local[6 + i];
    return f;
  };
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const ContactInstant& c = s.contacts[i];
    Vector3 p = random.vector();
    for (int j = c.tangents + 1; j < 3; ++j) p[j] = 0;
    PairDerivative<3> d;
    ContactInstant kept = c;
    if (c.tangents == 2) kept.wish = c.frame.col(1);
    differentiate(model, x, s, kept, geometry[i], p, d);
    Vector f = Vector::Zero(model.nv()), minus = f;
    after.contacts[i].W.add_impulse(p, f);
    before.contacts[i].W.add_impulse(p, minus);
    CAPTURE(seed, i);
    CHECK(((f - minus) / (2 * step) - expected(c.W, d.force)).norm() < tolerance);
    const Vector3 du = (after.contacts[i].velocity(x.nu) - before.contacts[i].velocity(x.nu)) / (2 * step);
    Eigen::Matrix<double, 12, 1> local = Eigen::Matrix<double, 12, 1>::Zero();
    for (int k = 0; k < c.W.na; ++k) local[k] = xi[c.W.va + k];
    for (int k = 0; k < c.W.nb; ++k) local[6 + k] = xi[c.W.vb + k];
    CHECK((d.velocity * local - du).head(1 + c.tangents).norm() < tolerance);
  }
  const auto check = [&](const std::vector<JointRowInstant>& now, const std::vector<JointRowInstant>& then,
                         const std::vector<JointRowInstant>& later) {
    for (std::size_t i = 0; i < now.size(); ++i) {
      const Eigen::Matrix<double, 1, 1> p(random.number());
      PairDerivative<1> d;
      differentiate(model, s, now[i], p[0], d);
      Vector f = Vector::Zero(model.nv()), minus = f;
      later[i].W.add_impulse(p, f);
      then[i].W.add_impulse(p, minus);
      CAPTURE(seed, i);
      CHECK(((f - minus) / (2 * step) - expected(now[i].W, d.force)).norm() < tolerance);
    }
  };
  check(s.joint_rows, before.joint_rows, after.joint_rows);
  check(s.joint_frictions, before.joint_frictions, after.joint_frictions);
}

TEST_CASE("every joint's rows turn as differentiate says, in a thousand states", "[derivatives][joint]") {
  Random random(1);
  Model model = with_all_joints(random);
  const JointId moved_joint = model.add_joint(prismatic(BodyId{2}, BodyId{3}, {.axis = random.vector()}));
  model.add_motion(moved_joint, {.position = [](double t) { return std::sin(3 * t); },
                                 .rate = [](double t) { return 3 * std::cos(3 * t); },
                                 .acceleration = [](double t) { return -9 * std::sin(3 * t); }});
  for (int joint = 2; joint < 20; ++joint)
    for (int i = 0; i < static_cast<int>(model.joint({joint}).coordinates.size()); ++i)
      model.add_limit({joint}, {.lower = -1, .upper = 2, .coordinate = i});
  Instant s, before, after;
  PairDerivative<1> d;
  PairDerivative<3> stop;
  for (int k = 0; k < 1000; ++k) {
    const State x = disturbed(model, random, 0.2);
    evaluate(model, x, s);
    evaluate(model, moved(model, x, -step), before);
    evaluate(model, moved(model, x, step), after);
    const auto local = [](const auto& W, const Vector& nu) {
      Eigen::Matrix<double, 12, 1> v = Eigen::Matrix<double, 12, 1>::Zero();
      for (int i = 0; i < W.na; ++i) v[i] = nu[W.va + i];
      for (int i = 0; i < W.nb; ++i) v[6 + i] = nu[W.vb + i];
      return v;
    };
    const auto blocks = [](const auto& W) {
      Eigen::Matrix<double, 12, 1> w;
      w << W.A.col(0), W.B.col(0);
      return w;
    };
    const auto check = [&](const auto& now, const auto& then, const auto& later) {
      for (std::size_t i = 0; i < now.size(); ++i) {
        CAPTURE(k, i, now[i].joint);
        const double u_rate = (later[i].velocity(x.nu) - then[i].velocity(x.nu)) / (2 * step);
        if (std::abs(u_rate) > 100) continue;  // near to where an angle is not defined
        REQUIRE(acceleration_bias(model, x, s, now[i]) == Approx(u_rate).epsilon(1e-5).margin(1e-5));
        differentiate(model, s, now[i], 1, d);
        const Eigen::Matrix<double, 12, 1> slope = (blocks(later[i].W) - blocks(then[i].W)) / (2 * step);
        if (!now[i].W.na || !now[i].W.nb) continue;  // a prescribed body moves too
        REQUIRE((d.force * local(now[i].W, x.nu) - slope).norm() < 1e-5 * (1 + slope.norm()));
      }
    };
    check(s.joint_rows, before.joint_rows, after.joint_rows);
    check(s.joint_coordinates, before.joint_coordinates, after.joint_coordinates);
    REQUIRE(s.contacts.size() > 20);
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
      const double u_rate =
          (after.contacts[i].velocity(x.nu) - before.contacts[i].velocity(x.nu)).x() / (2 * step);
      if (std::abs(u_rate) > 100) continue;
      REQUIRE(acceleration_bias(model, x, s, s.contacts[i], {}).x() ==
              Approx(u_rate).epsilon(1e-5).margin(1e-5));
    }
  }
}

TEST_CASE("loads change with configuration and velocity as differentiate_loads says", "[derivatives]") {
  const auto seed = GENERATE(range(0u, 10u));
  Random random(seed);
  const Model model = everything(random);
  const State x = disturbed(model, random, 0.1);
  const Vector xi = Vector::NullaryExpr(model.nv(), [&] { return random.number(); });
  Instant s, before, after;
  evaluate(model, x, s);
  std::vector<LoadDerivative> blocks;
  differentiate_loads(model, x, s, blocks);
  Vector by_xi = Vector::Zero(model.nv()), by_nu = by_xi;
  for (const LoadDerivative& d : blocks) {
    const Body &row = model.bodies()[static_cast<std::size_t>(d.row)],
               &column = model.bodies()[static_cast<std::size_t>(d.column)];
    by_xi.segment(row.v0, row.nv) += d.xi.topLeftCorner(row.nv, column.nv) * xi.segment(column.v0, column.nv);
    by_nu.segment(row.v0, row.nv) += d.nu.topLeftCorner(row.nv, column.nv) * xi.segment(column.v0, column.nv);
  }
  evaluate(model, moved_by(model, x, xi, -step), before);
  evaluate(model, moved_by(model, x, xi, step), after);
  CHECK(((after.k - before.k) / (2 * step) - by_xi).norm() < 1e-7);
  State slower = x, faster = x;
  slower.nu -= step * xi;
  faster.nu += step * xi;
  evaluate(model, slower, before);
  evaluate(model, faster, after);
  CHECK(((after.k - before.k) / (2 * step) - by_nu).norm() < 1e-7);
}

TEST_CASE("momenta of generalized bodies change with the configuration as differentiate_mass says",
          "[derivatives]") {
  const auto seed = GENERATE(range(0u, 10u));
  Random random(seed);
  const Model model = everything(random);
  const State x = disturbed(model, random, 0.1);
  const auto any = [&] { return Vector(Vector::NullaryExpr(model.nv(), [&] { return random.number(); })); };
  const Vector xi = any(), y = any();
  std::vector<LoadDerivative> blocks;
  differentiate_mass(model, x, y, blocks);
  REQUIRE(blocks.size() == 1);
  const Body& own = model.bodies()[static_cast<std::size_t>(blocks[0].row)];
  Instant before, after;
  evaluate(model, moved_by(model, x, xi, -step), before);
  evaluate(model, moved_by(model, x, xi, step), after);
  Vector less, more;
  multiply_mass(model, before, y, less);
  multiply_mass(model, after, y, more);
  Vector difference = (more - less) / (2 * step);
  difference.segment(own.v0, own.nv) -=
      blocks[0].xi.topLeftCorner(own.nv, own.nv) * xi.segment(own.v0, own.nv);
  CHECK(difference.norm() < 1e-7);
}

TEST_CASE("a generalized gap of the size of a hundredth is differentiated to ten digits", "[derivatives]") {
  constexpr double size = 0.01;
  Model model;
  const BodyId own = model.add_generalized(
      1, {.mass = [](const Vector&) { return Matrix::Identity(1, 1); },
          .force = [](const Vector&, const Vector&, double) -> Vector { return Vector::Zero(1); }});
  const GeneralizedGap gap = [=](const Vector& q, double) {
    return GeneralizedPoint{.gap = size * std::sin(q[0] / size),
                            .normal = Vector::Constant(1, std::cos(q[0] / size))};
  };
  model.add_contact(own, gap);
  State x = model.rest();
  model.set_coordinates(x, own, Vector::Constant(1, 0.006), Vector::Constant(1, 3));
  Instant s;
  evaluate(model, x, s);
  const double bias = acceleration_bias(model, x, s, s.contacts[0], {}).x();
  CHECK(bias == Approx(-9 / size * std::sin(0.6)).epsilon(1e-10));
}

TEST_CASE("a frame that continues another turns no further than the normal does", "[derivatives]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.2), {.pose = {{0, 0, 0.8}, {1, 0, 0, 0}}});
  model.add_contact(ground, ball, sphere_in_sphere(1, 0.2), {.mu = 0.5});
  State x = model.rest();
  Instant s, next;
  evaluate(model, x, s);
  for (int k = 1; k <= 200; ++k) {  // round the bowl, past where the default tangent changes its axis
    const double angle = 0.03 * k;
    model.set_position(x, ball, {0.8 * std::sin(angle), 0, 0.8 * std::cos(angle)});
    evaluate(model, x, next, &s);
    CHECK((next.contacts[0].frame - s.contacts[0].frame).norm() < 0.03 * std::sqrt(2.0) + 1e-6);
    std::swap(s, next);
  }
}
