#include "perp/solve/friction_solver.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <Eigen/Dense>
#include <map>
#include <string>

#include "friction_examples.hpp"
#include "perp/study/friction_families.hpp"

using namespace perp;

namespace {

/// Whether what the solution claims holds, by other means than the library's.
bool claims_hold(const FrictionProblem& problem, const FrictionSolution& s) {
  if (!s.r.allFinite() || !s.u.allFinite()) return false;
  const SecondOpinion opinion = second_opinion(problem, s.r);
  const double round_off = 1e-14 * (1 + opinion.absolute);
  if (std::abs(opinion.relative - s.residual) > 1e-3 * opinion.relative + round_off) return false;
  const bool passes = opinion.relative <= 1.001e-10 && opinion.absolute <= 1.001e-8;
  if (s.status == FrictionStatus::Solved) return passes;
  if (s.status == FrictionStatus::BestFound)
    return opinion.relative > 0.999e-10 || opinion.absolute > 0.999e-8;
  const Vector& y = s.certificate;  // y >= 0 on normals alone, W^T y = 0, q^T y < 0
  if (y.size() != problem.q.size()) return false;
  for (Eigen::Index i = 0; i < y.size(); ++i)
    if (i % 3 == 0 ? y(i) < 0 : y(i) != 0) return false;
  const Matrix W = problem.W.to_dense();
  return (W.transpose() * y).norm() < 1e-8 * W.norm() * y.norm() && problem.q.dot(y) < 0;
}

/// The largest miss of Signorini's and Coulomb's laws in the plane, forces as speeds of discs of 1 kg [m/s].
double breach_of_coulomb(const FrictionProblem& problem, const Vector& r) {
  const Vector u = problem.W.to_sparse() * r + problem.q;
  double worst = 0;
  for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
    const double u_n = u[2 * i], u_t = u[2 * i + 1], r_n = r[2 * i], r_t = r[2 * i + 1];
    const double bound = problem.mu[i] * r_n;
    worst = std::max({worst, -u_n, -r_n, std::min(u_n, r_n), std::abs(r_t) - bound});
    if (std::abs(u_t) > 1e-8) worst = std::max(worst, std::abs(r_t + std::copysign(bound, u_t)));
  }
  return worst;
}

/// How many of the random problems of these seeds ended with which status, and by which stage. Each claim is judged.
std::map<std::string, int> judged_answers(unsigned first, unsigned last) {
  std::map<std::string, int> answers;
  for (unsigned seed = first; seed < last; ++seed) {
    const FrictionProblem problem = random_friction_problem(seed);
    const FrictionSolution s = solve_friction(problem, {.use_ipopt = false});
    CAPTURE(seed, to_string(s.status), s.residual);
    REQUIRE(claims_hold(problem, s));
    std::string answer(to_string(s.status));
    if (s.solved()) answer.append(" by ").append(to_string(s.stage));
    ++answers[answer];
  }
  return answers;
}

/// Adds a local problem that shares no body with what is there.
void put_beside(FrictionProblem& whole, const FrictionProblem& part) {
  const Eigen::Index m = whole.q.size(), more = part.q.size(), n = whole.mu.size();
  Matrix W = Matrix::Zero(m + more, m + more);
  if (m > 0) W.topLeftCorner(m, m) = whole.W.to_dense();
  W.bottomRightCorner(more, more) = part.W.to_dense();
  whole.W = W;
  whole.q.conservativeResize(m + more);
  whole.q.tail(more) = part.q;
  whole.mu.conservativeResize(n + part.mu.size());
  whole.mu.tail(part.mu.size()) = part.mu;
}

}  // namespace

TEST_CASE("a cube under a small push stays, under a large one slides with mu N against it", "[friction]") {
  const double mu = 0.5;
  const FrictionSolution stuck = solve_friction(cube_on_plane({2, 0, -10}, mu));
  REQUIRE(stuck.solved());
  CHECK(stuck.v.norm() < 1e-12);
  const FrictionSolution slides = solve_friction(cube_on_plane({3, 4, -10}, 0.2));
  REQUIRE(slides.solved());
  CHECK((slides.v.head(3) - Vector3(3 - 0.6 * 2, 4 - 0.8 * 2, 0)).norm() < 1e-12);
}

TEST_CASE("of 1,500 random problems of any rank every status holds by a second opinion", "[friction]") {
  const std::map<std::string, int> answers = judged_answers(0, 1500);
  int solved = 0;
  for (const auto& [answer, count] : answers) solved += answer.rfind("solved", 0) == 0 ? count : 0;
  CHECK(solved > 1200);
  CHECK(answers.at("no-solution") > 80);
  CHECK(solved + answers.at("no-solution") > 1350);
}

TEST_CASE("of 100,000 random problems of any rank every status holds by a second opinion",
          "[friction][slow]") {
  const std::map<std::string, int> answers = judged_answers(10000, 110000);
  for (const auto& [answer, count] : answers) std::printf("%-24s %d\n", answer.c_str(), count);
  CHECK(answers.at("best-found") < 8000);
}

TEST_CASE("problems side by side end as they do each alone", "[friction]") {
  int solved = 0, none = 0;
  for (unsigned seed = 0; seed < 300; seed += 3) {
    FrictionProblem whole;
    std::vector<FrictionSolution> apart;
    for (unsigned k = 0; k < 3; ++k) {
      const FrictionProblem part = random_friction_problem(seed + k);
      apart.push_back(solve_friction(part, {.use_ipopt = false}));
      put_beside(whole, part);
    }
    const FrictionSolution together = solve_friction(whole, {.use_ipopt = false});
    CAPTURE(seed, to_string(together.status), together.residual);
    REQUIRE(claims_hold(whole, together));
    const auto of = [&](FrictionStatus status) {
      return std::count_if(apart.begin(), apart.end(), [&](const auto& s) { return s.status == status; });
    };
    if (of(FrictionStatus::Solved) == 3) CHECK(together.solved());
    if (of(FrictionStatus::NoSolution) > 0) CHECK(together.status == FrictionStatus::NoSolution);
    solved += together.solved();
    none += together.status == FrictionStatus::NoSolution;
  }
  CHECK(solved > 40);
  CHECK(none > 10);
}

TEST_CASE("a contact of nothing that moves is open or has no solution, whatever is beside it", "[friction]") {
  FrictionProblem problem = cube_on_plane({3, 4, -10}, 0.2);
  Matrix H = Matrix::Zero(6, 15);
  H.leftCols(12) = problem.H.to_dense();
  problem.H = H;
  problem.mu = Vector::Constant(5, 0.2);
  problem.w = Vector::Zero(15);
  problem.w(12) = 1;
  CHECK(solve_friction(problem).solved());
  problem.w(12) = -1;
  const FrictionSolution s = solve_friction(problem);
  REQUIRE(s.status == FrictionStatus::NoSolution);
  CHECK(s.certificate.head(12).norm() == 0);
  CHECK(s.certificate(12) > 0);
}

TEST_CASE("the same problem gives the same bits", "[friction]") {
  const FrictionProblem problem = random_friction_problem(77);
  const FrictionSolution a = solve_friction(problem), b = solve_friction(problem);
  CHECK(a.r == b.r);
  CHECK(a.iterations == b.iterations);
}

TEST_CASE("grams and tonnes give the same motion", "[friction]") {
  const FrictionSolution kilogram = solve_friction(cube_on_plane({3, 4, -10}, 0.2));
  for (const double unit : {1e-3, 1e3, 1e9}) {
    CAPTURE(unit);
    const FrictionSolution other = solve_friction(cube_on_plane(unit * Vector3(3, 4, -10), 0.2, unit));
    REQUIRE(other.solved());
    CHECK((other.v - kilogram.v).norm() < 1e-12);
    CHECK((other.r.sum() - unit * kilogram.r.sum()) == Approx(0).margin(1e-11 * unit));
  }
}

TEST_CASE("one contact given ten times moves as given once", "[friction]") {
  const Matrix W = Matrix3::Identity() * 2;
  const Vector3 q(-1, 0.7, 0.2);
  const double mu = 0.3;
  FrictionProblem once, tenfold;
  once.W = W;
  once.q = q;
  once.mu = Vector::Constant(1, mu);
  tenfold.W = W.replicate(10, 10);
  tenfold.q = q.replicate(10, 1);
  tenfold.mu = Vector::Constant(10, mu);
  const FrictionSolution a = solve_friction(once), b = solve_friction(tenfold);
  REQUIRE(a.solved());
  REQUIRE(b.solved());
  for (int i = 0; i < 10; ++i) CHECK((a.u - b.u.segment(3 * i, 3)).norm() < 1e-12);
}

TEST_CASE("friction that vanishes tends to no friction, and none is the half line", "[friction]") {
  const Vector3 force(3, 4, -10);
  const FrictionSolution none = solve_friction(cube_on_plane(force, 0));
  const FrictionSolution little = solve_friction(cube_on_plane(force, 1e-6));
  const FrictionSolution rough = solve_friction(cube_on_plane(force, 10));
  REQUIRE(none.solved());
  REQUIRE(little.solved());
  REQUIRE(rough.solved());
  CHECK((none.v.head(2) - force.head(2)).norm() < 1e-12);
  CHECK((little.v - none.v).norm() < 2e-5);
  CHECK(rough.v.norm() < 1e-11);
}

TEST_CASE("without free velocity nothing pushes", "[friction]") {
  FrictionProblem problem = random_friction_problem(9);
  problem.q.setZero();
  const FrictionSolution s = solve_friction(problem);
  REQUIRE(s.solved());
  CHECK(s.r.norm() == 0);
}

TEST_CASE("a half line, planar friction and a joint's interval follow their laws in one problem",
          "[friction]") {
  FrictionProblem
      problem;  // three bodies apart: a push down, a slide along a line, a joint against its friction
  problem.W = Matrix::Identity(4, 4);
  problem.q = Eigen::Vector4d(-1, -2, 3, 5);
  problem.mu = Vector3(0, 0.5, 2);
  problem.kinds = {BlockKind::HalfLine, BlockKind::Planar, BlockKind::Interval};
  for (const FrictionMethod method :
       {FrictionMethod::Chain, FrictionMethod::InteriorPoint, FrictionMethod::GaussSeidel}) {
    const FrictionSolution s = solve_friction(problem, {.method = method});
    REQUIRE(s.solved());
    CHECK((s.r - Eigen::Vector4d(1, 2, -1, -2)).norm() < 1e-11);
    CHECK((s.u - Eigen::Vector4d(0, 0, 2, 3)).norm() < 1e-11);
  }
}

TEST_CASE("each stage alone answers and is named", "[friction]") {
  const FrictionProblem problem = cube_on_plane({3, 4, -10}, 0.2);
  const auto [method, stage] = GENERATE(
      table<FrictionMethod, FrictionStage>({{FrictionMethod::Newton, FrictionStage::Newton},
                                            {FrictionMethod::InteriorPoint, FrictionStage::InteriorPoint},
                                            {FrictionMethod::Proximal, FrictionStage::Proximal},
                                            {FrictionMethod::GaussSeidel, FrictionStage::GaussSeidel},
                                            {FrictionMethod::Ipopt, FrictionStage::Ipopt}}));
  if (method == FrictionMethod::Ipopt && !has_ipopt()) return;
  const FrictionSolution s = solve_friction(problem, {.method = method});
  CAPTURE(to_string(stage));
  REQUIRE(s.solved());
  CHECK(s.stage == stage);
}

TEST_CASE("the proximal point method solves a cube's contacts within twenty of Newton's steps",
          "[friction]") {
  const FrictionOptions options{.method = FrictionMethod::Proximal, .max_iterations = 20};
  CHECK(solve_friction(cube_on_plane({3, 4, -10}, 0.2), options).solved());
}

TEST_CASE("where the stages before are held short Ipopt alone answers, and is named", "[friction]") {
  if (!has_ipopt()) return;
  const FrictionProblem problem = cube_on_plane({3, 4, -10}, 0.2);
  FrictionOptions held{.stage_iterations = 1, .use_ipopt = false};
  REQUIRE_FALSE(solve_friction(problem, held).solved());
  held.use_ipopt = true;
  const FrictionSolution s = solve_friction(problem, held);
  REQUIRE(s.solved());
  CHECK(s.stage == FrictionStage::Ipopt);
}

TEST_CASE("a limit on iterations is kept and the best point told as such", "[friction]") {
  const FrictionProblem problem = random_friction_problem(1234);
  const FrictionSolution s = solve_friction(problem, {.max_iterations = 1});
  CHECK(s.iterations <= 1);
  CHECK(claims_hold(problem, s));
}

TEST_CASE("a contact that closes from both sides is proved to have no solution", "[friction]") {
  FrictionProblem problem;  // one freedom along the normal, squeezed
  Matrix H = Matrix::Zero(1, 6);
  H(0, 0) = 1;
  H(0, 3) = -1;
  problem.W = Matrix(H.transpose() * H);
  problem.q = Vector::Zero(6);
  problem.q(0) = problem.q(3) = -1;
  problem.mu = Vector::Constant(2, 0.5);
  const FrictionSolution s = solve_friction(problem);
  REQUIRE(s.status == FrictionStatus::NoSolution);
  CHECK(s.existence == FrictionExistence::None);
  CHECK(claims_hold(problem, s));
}

TEST_CASE("a solution that was not come to is proved to exist by velocities inside the cones", "[friction]") {
  const double mu = 0.2;
  const FrictionProblem problem = cube_on_plane({3, 4, -10}, mu);
  const FrictionSolution s = solve_friction(problem, {.stage_iterations = 1, .use_ipopt = false});
  REQUIRE_FALSE(s.solved());
  CHECK(s.existence == FrictionExistence::Exists);
  REQUIRE(s.certificate.size() == 12);
  for (int i = 0; i < 4; ++i)
    CHECK(s.certificate(3 * i) > mu * s.certificate.segment(3 * i + 1, 2).norm() + 1e-6);
  const Matrix H = problem.H.to_dense();  // u = H^T v + w for some v
  const Vector v = H.transpose().colPivHouseholderQr().solve(s.certificate - problem.w);
  CHECK((H.transpose() * v + problem.w - s.certificate).norm() < 1e-9 * s.certificate.norm());
}

TEST_CASE("minimum norm shares a cube's weight equally over its corners", "[friction]") {
  const FrictionProblem problem = cube_on_plane({0, 0, -10}, 0.5);
  Vector uneven = Vector::Zero(12);  // two opposite corners carry it all
  uneven(0) = uneven(9) = 5;
  const FrictionSolution any = solve_friction(problem, {.start = uneven});
  const FrictionSolution least =
      solve_friction(problem, {.reactions = Reactions::MinimumNorm, .start = uneven});
  REQUIRE(any.solved());
  REQUIRE(least.solved());
  CHECK(least.r.norm() < any.r.norm());
  for (int corner = 0; corner < 4; ++corner) CHECK(least.r(3 * corner) == Approx(2.5).epsilon(1e-9));
}

TEST_CASE("a warm start with q changed by one percent needs few Newton steps", "[friction]") {
  int others = 0, many = 0;
  constexpr int runs = 200;
  for (unsigned seed = 0; seed < runs; ++seed) {
    Draw draw(seed);
    FrictionProblem problem =
        cube_on_plane(Vector3(draw.uniform(-9, 9), draw.uniform(-9, 9), -10), draw.uniform(0.1, 1));
    const FrictionSolution before = solve_friction(problem);
    REQUIRE(before.solved());
    problem.f += 0.01 * problem.f.norm() * draw.matrix(6, 1) / std::sqrt(6.0);
    const FrictionSolution after = solve_friction(problem, {.start = before.r});
    REQUIRE(after.solved());
    others += after.stage != FrictionStage::Newton && after.stage != FrictionStage::None;
    many += after.iterations > 6;
  }
  CHECK(others <= runs / 50);
  CHECK(many <= runs / 10);
}

TEST_CASE("sweeps that creep are tried, and leave the rest to Newton untouched", "[friction]") {
  const FrictionProblem other = friction_family("kapla", 77, 2);
  // a trial, and the answer of Newton's method alone to the last bit
  const FrictionSolution chain = solve_friction(other),
                         newton = solve_friction(other, {.method = FrictionMethod::Newton});
  REQUIRE(chain.solved());
  CHECK(chain.stage == FrictionStage::Newton);
  CHECK(chain.iterations > newton.iterations);
  CHECK(chain.iterations <= newton.iterations + 25);
  CHECK((chain.r.array() == newton.r.array()).all());
}

TEST_CASE("a pile of discs that Newton's method does not solve is swept", "[friction]") {
  const FrictionProblem pile = disc_pile(7);
  CHECK_FALSE(solve_friction(pile, {.method = FrictionMethod::Newton, .max_iterations = 25}).solved());
  const FrictionSolution swept = solve_friction(pile);
  REQUIRE(swept.solved());
  CHECK(swept.stage == FrictionStage::GaussSeidel);
  CHECK(breach_of_coulomb(pile, swept.r) < 1e-8);
}

TEST_CASE("sweeps in the bodies' velocities take the steps of sweeps in W", "[friction]") {
  const FrictionProblem global = friction_family("stack", 7, 4);
  REQUIRE(global.is_global());
  const FrictionOptions some{.method = FrictionMethod::GaussSeidel, .max_iterations = 20};
  const FrictionSolution a = solve_friction(global, some), b = solve_friction(to_local(global), some);
  CHECK((a.r - b.r).norm() < 1e-8 * b.r.norm());
}

TEST_CASE("options out of range are refused by name", "[friction]") {
  const FrictionProblem problem = random_friction_problem(1);
  CHECK_THROWS_WITH(static_cast<void>(solve_friction(problem, {.tolerance = 0})),
                    Catch::Contains("tolerance"));
  CHECK_THROWS_WITH(static_cast<void>(solve_friction(problem, {.start = Vector::Zero(1)})),
                    Catch::Contains("start"));
}
