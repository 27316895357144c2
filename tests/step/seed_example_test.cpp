// Section 4 of the seed paper: F and f of (48)-(49) out of the general assembly, and the motion at its step sizes.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

struct Sphere {
  Model model;
  BodyId ball;
  State x;
  Sphere(double mass, double radius, const Vector3& moments, double mu,
         const Vector3& tangent = Vector3::Zero()) {
    ball = model.add_body(Inertia::principal(mass, moments), {.name = "ball"});
    model.add_contact(ground, ball, sphere_on_plane(radius), {.mu = mu, .name = "floor", .tangent = tangent});
    x = model.rest();
    model.set_position(x, ball, {0, 0, radius});
  }
};

Sphere seed(const Vector3& tangent = Vector3::Zero()) {
  Sphere s(1, 1, Vector3::Constant(0.4), 0.2, tangent);
  s.model.set_velocity(s.x, s.ball, {2, 0, 0});
  return s;
}

/// (48)-(49) for a sphere with any mass, radius and principal inertia, z = (p_n, beta_1 .. beta_4, sigma), by hand: columns of W_n and
/// D for the directions +x, +y, -x, -y at the contact point r = (0, 0, -R).
Lcp by_hand(const Sphere& s, double mass, double R, const Vector3& moments, double mu, double gap, double h) {
  Eigen::Matrix<double, 6, 5> W;
  int column = 0;
  for (const Vector3& d :
       {Vector3(0, 0, 1), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(-1, 0, 0), Vector3(0, -1, 0)})
    W.col(column++) << d, Vector3(0, 0, -R).cross(d);
  Eigen::Matrix<double, 6, 1> M, nu;
  M << mass, mass, mass, moments;
  nu << s.x.nu.head<3>(), s.x.nu.tail<3>();
  const Vector3 w = nu.tail<3>();
  Eigen::Matrix<double, 6, 1> k;
  Vector3 w_f =
      w;  // J (w_f - w) = -h w_f x J w_f: the gyroscopic term at the end, a contraction by h |w| a round
  for (int round = 0; round < 40; ++round)
    w_f = w - h * w_f.cross(Vector3(moments.cwiseProduct(w_f))).cwiseQuotient(moments);
  k << 0, 0, -9.81 * mass, moments.cwiseProduct(w_f - w) / h;
  const Eigen::Matrix<double, 6, 1> free = nu + h * k.cwiseQuotient(M);
  Lcp lcp{Matrix::Zero(6, 6), Vector::Zero(6)};
  lcp.A.topLeftCorner(5, 5) = W.transpose() * M.cwiseInverse().asDiagonal() * W;
  lcp.A.block(1, 5, 4, 1).setOnes();
  lcp.A.block(5, 1, 1, 4).setConstant(-1);
  lcp.A(5, 0) = mu;
  lcp.b.head(5) = W.transpose() * free;
  lcp.b[0] += gap / h;
  return lcp;
}

}  // namespace

TEST_CASE("the assembly gives the seed's F and f with the signs corrected", "[seed]") {
  const Sphere s = seed();
  LcpStepper stepper({.edges = 4});
  const auto problems = stepper.problems(s.model, s.x, 0.12);
  REQUIRE(problems.size() == 1);
  // (48) has the columns +x, -x, +y, -y; here the vertices go round: +x, +y, -x, -y
  Matrix F(6, 6);
  F << 1, 0, 0, 0, 0, 0,      //
      0, 3.5, 0, -3.5, 0, 1,  //
      0, 0, 3.5, 0, -3.5, 1,  //
      0, -3.5, 0, 3.5, 0, 1,  //
      0, 0, -3.5, 0, 3.5, 1,  //
      0.2, -1, -1, -1, -1, 0;
  Vector f(6);
  f << -9.81 * 0.12, 2, 0, -2, 0, 0;
  CHECK((problems[0].A - F).cwiseAbs().maxCoeff() < 1e-15);
  CHECK((problems[0].b - f).cwiseAbs().maxCoeff() < 1e-15);
}

TEST_CASE("F and f agree with a calculation by hand for another inertia, radius and velocity", "[seed]") {
  const double mass = 1.7, R = 0.35, mu = 0.45, gap = -0.001, h = 0.013;
  const Vector3 moments(0.11, 0.17, 0.23);
  Sphere s(mass, R, moments, mu);
  s.model.set_position(s.x, s.ball, {0.3, -0.2, R + gap});
  s.model.set_velocity(s.x, s.ball, {0.7, -0.4, -0.1}, {2, -3, 1.5});
  LcpStepper stepper({.edges = 4});
  const Lcp lcp = stepper.problems(s.model, s.x, h).at(0);
  const Lcp expected = by_hand(s, mass, R, moments, mu, gap, h);
  CHECK((lcp.A - expected.A).cwiseAbs().maxCoeff() < 1e-14 * expected.A.norm());
  CHECK((lcp.b - expected.b).cwiseAbs().maxCoeff() < 1e-14 * expected.b.norm());
}

TEST_CASE("the seed's sphere moves as exact arithmetic says at every step size, in both forms", "[seed]") {
  const LcpForm form = GENERATE(LcpForm::Condensed, LcpForm::Mixed);
  const int edges = GENERATE(4, 8);
  const Sphere s = seed();
  LcpStepper stepper({.edges = edges, .form = form});
  const double x_at[][2] = {{0.12, 0.909527314285714286},
                            {0.06, 0.923653714285714286},
                            {0.03, 0.931967571428571429},
                            {0.001, 0.940071039428571429}};
  for (const auto& [h, x] : x_at) {
    const Trajectory run = simulate(s.model, stepper, s.x, {.t_end = 0.6, .h = h});
    CAPTURE(h, edges);
    CHECK(s.model.position(run.back(), s.ball).x() ==
          Approx(x).epsilon(h == 0.001 ? 1e-13 : 1e-14).margin(0));
  }
  const Trajectory run = simulate(s.model, stepper, s.x, {.t_end = 0.6, .h = 0.12});
  REQUIRE(run.size() == 6);
  const double v[] = {1.76456, 1.52912, 10.0 / 7, 10.0 / 7, 10.0 / 7};
  for (std::size_t k = 0; k < 5; ++k) {
    CHECK(s.model.velocity(run.state(k + 1), s.ball).x() == Approx(v[k]).epsilon(1e-14).margin(0));
    CHECK(run.figures(k).residuals.newton_euler < 1e-15);
    CHECK(run.figures(k).residuals.normal < 1e-15);
    CHECK(run.figures(k).residuals.friction < 2e-15);
  }
  CHECK(s.model.angular_velocity(run.back(), s.ball).y() == Approx(10.0 / 7).epsilon(1e-14));
}

TEST_CASE("along axes turned by pi/4 the force is that of Figure 9", "[seed]") {
  const Sphere s = seed({1, 1, 0});
  LcpStepper stepper({.edges = 8});  // a vertex at -x again
  const Trajectory run = simulate(s.model, stepper, s.x, {.t_end = 0.6, .h = 0.12});
  const Matrix3 frame = contact_frame(Vector3::UnitZ(), {1, 1, 0});
  const double sliding = 0.2 * 9.81 / std::sqrt(2.0);  // 1.38734 N
  for (std::size_t k = 0; k < 5; ++k) {
    const StepReport report = run.report(k);
    const Vector3 force = frame.transpose() * report.contact("floor").impulse / report.h;
    const double rolls_within =
        (2 - 2 * 0.2 * 9.81 * 0.12 - 10.0 / 7) / 0.12 / std::sqrt(2.0);  // to v = 10/7 in the third step
    const double expected = k < 2 ? sliding : k == 2 ? rolls_within : 0;
    CHECK(force.x() == Approx(9.81).epsilon(1e-14));
    CHECK(force.y() == Approx(-expected).margin(1e-14));
    CHECK(force.z() == Approx(expected).margin(1e-14));
    CHECK(report.contact("floor").mode == (k < 2 ? ContactMode::Slip : ContactMode::Stick));
  }
  CHECK(sliding == Approx(1.38734).epsilon(1e-5));
}

TEST_CASE("a contact has as many unknowns as its friction needs", "[seed]") {
  const auto unknowns = [](double mu, int edges, bool planar) {
    Model model;
    const BodyId body = planar ? model.add_planar_body(1, 1) : model.add_body(Inertia::solid_sphere(1, 1));
    model.add_contact(ground, body, planar ? disc_on_line(1) : sphere_on_plane(1), {.mu = mu});
    State x = model.rest();
    LcpStepper stepper({.edges = edges});
    return stepper.problems(model, x, 0.01).at(0).b.size();
  };
  CHECK(unknowns(0, 8, false) == 1);
  CHECK(unknowns(0.3, 4, false) == 6);
  CHECK(unknowns(0.3, 8, false) == 10);
  CHECK(unknowns(0.3, 8, true) == 4);
  CHECK(unknowns(0, 8, true) == 1);
}
