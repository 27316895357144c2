// Every kind of block: answers held against the law itself, by a search that shares no code with the solvers.
#include <catch2/catch.hpp>
#include <cmath>
#include <Eigen/Dense>
#include <functional>
#include <string>

#include "friction_examples.hpp"
#include "solve/friction/friction_islands.hpp"
#include "solve/friction/friction_stages.hpp"

using namespace perp;

namespace {

const BlockKind every_kind[] = {BlockKind::HalfLine, BlockKind::Planar,           BlockKind::Cone,
                                BlockKind::Interval, BlockKind::PlanarRolling,    BlockKind::Torsional,
                                BlockKind::Rolling,  BlockKind::TorsionalRolling, BlockKind::Disc,
                                BlockKind::Ball};

/// Rows that share a bound, as the page on problem files has them; said here anew.
struct Group {
  std::vector<int> rows;
  std::vector<double> axes;
};

std::vector<Group> groups_of(const FrictionProblem& p, Eigen::Index i) {
  const double mu = p.mu(i), mu_o = p.mu_o.size() > 0 ? p.mu_o(i) : mu;
  switch (p.kind(i)) {
    case BlockKind::HalfLine:
      return {};
    case BlockKind::Planar:
      return {{{1}, {mu}}};
    case BlockKind::Cone:
      return {{{1, 2}, {mu, mu_o}}};
    case BlockKind::Interval:
      return {{{0}, {mu}}};
    case BlockKind::PlanarRolling:
      return {{{1}, {mu}}, {{2}, {p.rolling(i)}}};
    case BlockKind::Torsional:
      return {{{1, 2, 3}, {mu, mu_o, p.torsion(i)}}};
    case BlockKind::Rolling:
      return {{{1, 2}, {mu, mu_o}}, {{3, 4}, {p.rolling(i), p.rolling(i)}}};
    case BlockKind::TorsionalRolling:
      return {{{1, 2, 3}, {mu, mu_o, p.torsion(i)}}, {{4, 5}, {p.rolling(i), p.rolling(i)}}};
    case BlockKind::Disc:
      return {{{0, 1}, {mu, mu}}};
    case BlockKind::Ball:
      return {{{0, 1, 2}, {mu, mu, mu}}};
  }
  return {};
}

bool is_contact(BlockKind kind) {
  return kind != BlockKind::Interval && kind != BlockKind::Disc && kind != BlockKind::Ball;
}

/// The most that a force with sum (x_k/(size a_k))^2 <= 1 takes from u, by a compass search over the angles of x.
double most_work(const Group& group, double size, const Vector& u) {
  const auto work = [&](double a, double b) {
    const double d[] = {std::cos(a), std::sin(a) * std::cos(b), std::sin(a) * std::sin(b)};
    double sum = 0;
    for (size_t k = 0; k < group.rows.size(); ++k) sum -= size * group.axes[k] * d[k] * u(group.rows[k]);
    return sum;
  };
  double best = 0;
  for (const double start : {0.3, 1.8, 2.9}) {
    double a = start, b = group.rows.size() < 3 ? 0 : 2 * start, step = 1, here = work(a, b);
    while (step > 1e-8) {
      bool better = false;
      for (const auto& [da, db] : {std::pair{1., 0.}, {-1., 0.}, {0., 1.}, {0., -1.}}) {
        const double there = work(a + step * da, b + (group.rows.size() < 3 ? 0 : step * db));
        if (there <= here) continue;
        here = there, a += step * da, b += group.rows.size() < 3 ? 0 : step * db, better = true;
        break;
      }
      if (!better) step /= 2;
    }
    best = std::max(best, here);
  }
  return best;
}

double gauge(const Group& group, const Vector& r) {
  double sum = 0;
  for (size_t k = 0; k < group.rows.size(); ++k) {
    const double x = r(group.rows[k]);
    if (group.axes[k] > 0) sum += x * x / (group.axes[k] * group.axes[k]);
  }
  return std::sqrt(sum);
}

enum Mode { Lifts, Sticks, Slides };

/// One block of the kind whose q is made so that some reaction in the mode drawn solves it.
FrictionProblem one_block(BlockKind kind, unsigned seed) {
  Draw draw(seed);
  const int m = block_rows(kind);
  FrictionProblem p;
  p.kinds = {kind};
  const auto bound = [&](double none) {
    return Vector::Constant(1, draw.uniform(0, 1) < none ? 0 : std::pow(10, draw.uniform(-1.5, 0.3)));
  };
  p.mu = bound(is_contact(kind) ? 0.1 : 0);
  if (m > 2 && is_contact(kind) && kind != BlockKind::PlanarRolling && draw.integer(0, 2) == 0)
    p.mu_o = bound(0.1);
  p.torsion = bound(0.1);
  p.rolling = bound(0.1);
  const Matrix H = draw.matrix(m + 2, m);
  p.W = Matrix(H.transpose() * H);
  const double which = draw.uniform(0, 1);
  const double lifting = is_contact(kind) ? 0.15 : 0, sticking = is_contact(kind) ? 0.57 : 0.4;
  const Mode mode = which < lifting ? Lifts : which < sticking ? Sticks : Slides;
  Vector r = Vector::Zero(m), u = Vector::Zero(m);
  const double size = !is_contact(kind) ? 1 : mode == Lifts ? 0 : draw.uniform(0.1, 2);
  if (is_contact(kind)) r(0) = size, u(0) = mode == Lifts ? draw.uniform(0.01, 1) : 0;
  for (const Group& g : groups_of(p, 0)) {
    const bool slides = mode == Lifts || (mode == Slides && draw.integer(0, 3) > 0);
    const Vector d = draw.matrix(3, 1).normalized();
    double norm = 0;
    for (size_t k = 0; k < g.rows.size(); ++k) {
      if (slides || g.axes[k] == 0) u(g.rows[k]) = d(static_cast<int>(k));
      norm += std::pow(g.axes[k] * u(g.rows[k]), 2);
    }
    for (size_t k = 0; k < g.rows.size(); ++k)
      r(g.rows[k]) = norm > 0 ? -size * g.axes[k] * g.axes[k] * u(g.rows[k]) / std::sqrt(norm)
                              : 0.9 * size * g.axes[k] * d(static_cast<int>(k));
  }
  p.q = u - p.W.to_dense() * r;
  return p;
}

/// Whether r and u obey Signorini's condition and maximum dissipation, to `tolerance` of the sizes at hand.
void check_law(const FrictionProblem& p, const Vector& r, const Vector& u, double tolerance) {
  const std::vector<Eigen::Index> first = p.offsets();
  for (Eigen::Index i = 0; i < p.blocks(); ++i) {
    const Vector r_i = r.segment(first[i], first[i + 1] - first[i]), u_i = u.segment(first[i], r_i.size());
    const double force = tolerance * (1 + r.norm()), speed = tolerance * (1 + p.q.norm() + r.norm());
    const bool contact = is_contact(p.kind(i));
    if (contact) {
      REQUIRE(r_i(0) >= -force);
      REQUIRE(u_i(0) >= -speed);
      REQUIRE(std::min(r_i(0), u_i(0)) <= std::max(force, speed));
    }
    const double size = contact ? std::max(0.0, r_i(0)) : 1;
    for (const Group& g : groups_of(p, i)) {
      double shortest = infinity, work = 0;
      for (size_t k = 0; k < g.rows.size(); ++k) {
        work -= r_i(g.rows[k]) * u_i(g.rows[k]);
        if (g.axes[k] > 0)
          shortest = std::min(shortest, g.axes[k]);
        else
          REQUIRE(std::abs(r_i(g.rows[k])) <= force);
      }
      if (shortest < infinity) REQUIRE(gauge(g, r_i) <= size + 3 * force / shortest);
      REQUIRE(work >= most_work(g, size, u_i) - (force + speed) * (1 + r_i.norm() + u_i.norm()));
    }
  }
}

void check_kind(BlockKind kind, unsigned first, unsigned last) {
  int lifts = 0, sticks = 0, slides = 0, missed = 0;
  for (unsigned seed = first; seed < last; ++seed) {
    const FrictionProblem p = one_block(kind, seed);
    const FrictionSolution s = solve_friction(p, {.use_ipopt = false});
    CAPTURE(static_cast<int>(kind), seed, s.residual, s.r.transpose(), s.u.transpose());
    missed += !s.solved();
    if (!s.solved()) continue;
    REQUIRE((p.W.to_dense() * s.r + p.q - s.u).norm() <= 1e-12 * (1 + p.q.norm() + s.r.norm()));
    check_law(p, s.r, s.u, 1e-8);
    const Vector friction = is_contact(kind) ? Vector(s.u.tail(s.u.size() - 1)) : s.u;
    if (is_contact(kind) && s.r(0) < 1e-9)
      ++lifts;
    else
      ++(friction.size() == 0 || friction.cwiseAbs().maxCoeff() < 1e-9 ? sticks : slides);
  }
  CAPTURE(static_cast<int>(kind), lifts, sticks, slides, missed);
  const auto share = [&](int count) { return double(count) / (last - first); };
  CHECK(missed == 0);
  if (is_contact(kind)) CHECK(share(lifts) > 0.1);
  CHECK(share(sticks) > 0.25);
  if (kind != BlockKind::HalfLine) CHECK(share(slides) > 0.25);
}

}  // namespace

TEST_CASE("no admissible friction takes more from 200 random motions of any kind of block than the answer's",
          "[friction][blocks]") {
  for (const BlockKind kind : every_kind) check_kind(kind, 0, 200);
}

TEST_CASE(
    "no admissible friction takes more from 10,000 random motions of any kind of block than the answer's",
    "[friction][blocks][slow]") {
  for (const BlockKind kind : every_kind) check_kind(kind, 1000, 11000);
}

TEST_CASE("a force that takes less than the most is told from one that takes the most",
          "[friction][blocks]") {
  const Group group{{1, 2, 3}, {0.5, 0.2, 0.05}};
  const Vector u = Eigen::Vector4d(0, 1, -2, 3);
  CHECK(most_work(group, 2, u) == Approx(2 * std::sqrt(0.25 + 0.16 + 0.0225)));
  CHECK(most_work({{0, 1}, {1, 1}}, 1, Eigen::Vector2d(3, 4)) == Approx(5));
}

namespace {

constexpr BlockKind with_moments[] = {BlockKind::PlanarRolling, BlockKind::Torsional, BlockKind::Rolling,
                                      BlockKind::TorsionalRolling};

/// Some contacts of any kinds over one W of full rank.
FrictionProblem mixed_blocks(unsigned seed) {
  Draw draw(seed);
  const int blocks = draw.integer(2, 6);
  FrictionProblem p;
  p.mu = p.mu_o = p.torsion = p.rolling = Vector(blocks);
  int m = 0;
  for (int i = 0; i < blocks; ++i) {
    p.kinds.push_back(every_kind[draw.integer(0, 9)]);
    m += block_rows(p.kinds.back());
    p.mu(i) = draw.uniform(0, 1);
    p.mu_o(i) = draw.integer(0, 1) == 0 ? p.mu(i) : draw.uniform(0, 1);
    p.torsion(i) = draw.uniform(0, 0.5);
    p.rolling(i) = draw.uniform(0, 0.5);
  }
  const Matrix H = draw.matrix(m + 1, m);
  p.W = Matrix(H.transpose() * H);
  p.q = draw.matrix(m, 1) * 3;
  return p;
}

/// A ball of 2 kg and radius 1 m on a plane: n, t, o, torsion, rolling t, rolling o. Its velocity v, w before the step.
FrictionProblem ball(const Vector3& v, const Vector3& w) {
  FrictionProblem p;
  Matrix M = 2 * Matrix::Identity(6, 6), H = Matrix::Zero(6, 6);
  M.bottomRightCorner(3, 3) *= 0.4;
  const Vector3 axes[] = {Vector3::UnitZ(), Vector3::UnitX(), Vector3::UnitY()}, arm(0, 0, -1);
  for (int k = 0; k < 3; ++k) {
    H.block<3, 1>(0, k) = axes[k];
    H.block<3, 1>(3, k) = arm.cross(axes[k]);
    H.block<3, 1>(3, 3 + k) = axes[k];
  }
  p.M = M;
  p.H = H;
  p.f.resize(6);
  p.f << 2 * v + Vector3(0, 0, -2), 0.8 * w;
  p.w = Vector::Zero(6);
  p.mu = Vector::Constant(1, 0.3);
  p.torsion = Vector::Constant(1, 0.1);
  p.rolling = Vector::Constant(1, 0.05);
  return p;
}

}  // namespace

TEST_CASE("the projection on a cone of moments is the nearest admissible reaction", "[friction][blocks]") {
  for (unsigned seed = 0; seed < 300; ++seed) {
    Draw draw(seed);
    const FrictionProblem p = one_block(with_moments[seed % 4], seed);
    const Vector z = draw.matrix(block_rows(p.kind(0)), 1) * 2, near = project_reaction(p, 0, z);
    CAPTURE(seed, z.transpose(), near.transpose());
    // K is a cone: z - p is at right angles to p and makes no sharp angle with any other of its rays
    REQUIRE(near(0) >= 0);
    for (const Group& g : groups_of(p, 0)) REQUIRE(gauge(g, near) <= near(0) * (1 + 1e-12));
    REQUIRE(std::abs((z - near).dot(near)) <= 1e-12);
    double most = z(0) - near(0);
    for (const Group& g : groups_of(p, 0)) most += most_work(g, 1, near - z);
    REQUIRE(most <= 1e-7);
  }
}

TEST_CASE("every method solves problems with moments on its own, or says with its residual that it does not",
          "[friction][blocks]") {
  for (const FrictionMethod method : {FrictionMethod::Newton, FrictionMethod::InteriorPoint,
                                      FrictionMethod::Proximal, FrictionMethod::GaussSeidel}) {
    int solved = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
      const FrictionProblem p = mixed_blocks(seed);
      const FrictionSolution s = solve_friction(p, {.method = method});
      CAPTURE(static_cast<int>(method), seed, s.residual);
      if (s.solved()) check_law(p, s.r, s.u, 1e-8);
      solved += s.solved();
    }
    CAPTURE(static_cast<int>(method));
    CHECK(solved >= 54);
  }
}

TEST_CASE("the homotopy alone comes to the answers of problems with moments", "[friction][blocks]") {
  int solved = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const ContactSystem<6> system = contact_system<6>(mixed_blocks(seed));
    Iterate<6> best;
    best.r = Columns<6>::Zero(6, system.n);
    evaluate(system, best);
    Budget budget;
    interior_point(system, {}, 1e-5, budget, best);
    solved += best.error <= 1e-5;
  }
  CHECK(solved >= 50);
}

TEST_CASE("the chain solves 200 problems of several contacts of any kinds", "[friction][blocks]") {
  for (unsigned seed = 100; seed < 300; ++seed) {
    const FrictionProblem p = mixed_blocks(seed);
    const FrictionSolution s = solve_friction(p, {.use_ipopt = false});
    CAPTURE(seed, s.residual);
    REQUIRE(s.solved());
    check_law(p, s.r, s.u, 1e-8);
  }
}

TEST_CASE("problems with moments side by side end as they do each alone", "[friction][blocks]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const FrictionProblem a = mixed_blocks(seed), b = mixed_blocks(seed + 500);
    FrictionProblem both;
    const Eigen::Index m = a.q.size(), n = b.q.size();
    Matrix W = Matrix::Zero(m + n, m + n);
    W.topLeftCorner(m, m) = a.W.to_dense();
    W.bottomRightCorner(n, n) = b.W.to_dense();
    both.W = W;
    const auto join = [](const Vector& x, const Vector& y) {
      Vector z(x.size() + y.size());
      z << x, y;
      return z;
    };
    both.q = join(a.q, b.q);
    both.mu = join(a.mu, b.mu);
    both.mu_o = join(a.mu_o, b.mu_o);
    both.torsion = join(a.torsion, b.torsion);
    both.rolling = join(a.rolling, b.rolling);
    both.kinds = a.kinds;
    both.kinds.insert(both.kinds.end(), b.kinds.begin(), b.kinds.end());
    for (const FrictionIsland& island : friction_islands(both)) REQUIRE_NOTHROW(check(island.problem));
    const FrictionSolution s = solve_friction(both, {.use_ipopt = false});
    CAPTURE(seed, s.residual);
    REQUIRE(s.solved());
    check_law(both, s.r, s.u, 1e-8);
  }
}

TEST_CASE("a problem with moments is the same in its local form", "[friction][blocks]") {
  const FrictionProblem global = ball({1, 0.2, 0}, {0.3, 1, 4}), local = to_local(global);
  CHECK(local.torsion == global.torsion);
  CHECK(local.rolling == global.rolling);
  const FrictionSolution a = solve_friction(global), b = solve_friction(local);
  REQUIRE(a.solved());
  REQUIRE(b.solved());
  CHECK((a.r - b.r).norm() < 1e-9);
}

TEST_CASE("a ball spun in place is held by its torsion alone, one that rolls by its rolling moment",
          "[friction][blocks]") {
  const FrictionSolution spun = solve_friction(ball({0, 0, 0}, {0, 0, 3}));
  REQUIRE(spun.solved());
  CHECK(spun.v(5) == Approx(3 - 0.1 * 2 / 0.8));
  CHECK(spun.v.head(5).norm() < 1e-12);
  const FrictionSolution rolls = solve_friction(ball({1, 0, 0}, {0, 1, 0}));
  REQUIRE(rolls.solved());
  CHECK(rolls.v(0) == Approx((2.8 - 0.05 * 2) / 2.8));
  CHECK(rolls.v(4) == Approx(rolls.v(0)));
}

TEST_CASE("a mu of zero leaves torsion and rolling their bounds", "[friction][blocks]") {
  FrictionProblem p = ball({1, 0, 0}, {0, 1, 3});
  p.mu(0) = 0;
  const FrictionSolution s = solve_friction(p);
  REQUIRE(s.solved());
  CHECK(s.r.segment(1, 2).norm() == 0);
  CHECK(s.v(0) == Approx(1));
  CHECK(s.v(4) == Approx(1 - 0.05 * 2 / 0.8));
  CHECK(s.v(5) == Approx(3 - 0.1 * 2 / 0.8));
}

TEST_CASE("a change of units does not change what a residual with moments is", "[friction][blocks]") {
  const FrictionProblem metres = ball({1, 0.2, 0}, {0.3, 1, 4});
  const double L = 1e3;  // millimetres: lengths times L, masses and times as they were
  FrictionProblem millimetres = metres;
  Matrix M = metres.M.to_dense(), H = metres.H.to_dense();
  M.bottomRightCorner(3, 3) *= L * L;
  H.bottomLeftCorner(3, 3) *= L;
  millimetres.M = M;
  millimetres.H = H;
  millimetres.f.head(3) *= L;
  millimetres.f.tail(3) *= L * L;
  millimetres.torsion *= L;
  millimetres.rolling *= L;
  Vector r(6);
  r << 2, 0.4, -0.1, 0.1, -0.05, 0.02;
  Vector r_mm = r * L;
  r_mm.tail(3) *= L;
  const FrictionResidual a = friction_residual(metres, r), b = friction_residual(millimetres, r_mm);
  CHECK(a.absolute > 0.1);
  CHECK(b.absolute == Approx(a.absolute).epsilon(1e-12));
  CHECK(b.relative == Approx(a.relative).epsilon(1e-12));
  CHECK(b.cone == Approx(a.cone * L).epsilon(1e-12));
}

TEST_CASE("bounds that a kind needs and that are not there are refused by name", "[friction][blocks]") {
  FrictionProblem p = ball({0, 0, 0}, {0, 0, 0});
  p.rolling.resize(0);
  CHECK_THROWS_WITH(solve_friction(p), Catch::Contains("rolling size"));
  p.rolling = Vector::Constant(1, -1);
  CHECK_THROWS_WITH(solve_friction(p), Catch::Contains("rolling(0)"));
  p.rolling = p.torsion = Vector::Constant(1, not_set);
  CHECK_THROWS_WITH(solve_friction(p), Catch::Contains("torsion(0)"));
}
