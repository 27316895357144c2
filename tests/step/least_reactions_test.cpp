// Reactions of least norm, where contacts and joints are redundant: what is reported changes, the motion does not.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/scene.hpp"

using namespace perp;

namespace {

double norm(const StepReport& report) {
  double squares = 0;
  for (const ContactRow& c : report.contacts) squares += c.impulse.squaredNorm();
  for (const JointImpulse& j : report.joints) squares += j.impulse.squaredNorm() + j.moment.squaredNorm();
  return std::sqrt(squares);
}

struct Both {
  std::unique_ptr<Stepper> any, least;
  explicit Both(const std::string& method)
      : any(make_stepper(method)), least(make_stepper(method, {.reactions = Reactions::MinimumNorm})) {}
};

}  // namespace

TEST_CASE("a table's four feet carry a quarter of it each, when asked for the least reactions",
          "[reactions]") {
  const std::string method = GENERATE("lcp", "lcp-ap", "ncp", "ncp-start", "ncp2");
  CAPTURE(method);
  const Scene s = scene("table");
  Both steppers(method);
  State x = s.start, y = s.start;
  const double h = 0.01, mg = s.model.bodies()[1].mass * 9.81;
  for (int i = 0; i < 20; ++i) {
    const StepReport any = steppers.any->step(s.model, x, h), least = steppers.least->step(s.model, y, h);
    REQUIRE(least.advanced());
    CHECK(x.q == y.q);
    CHECK(x.nu == y.nu);
    REQUIRE(least.contacts.size() == 4);
    for (const ContactRow& c : least.contacts) {
      CHECK(c.p_n == Approx(mg / 4 * h).epsilon(1e-9));
      CHECK((c.impulse - Vector3(0, 0, mg / 4 * h)).norm() < 1e-9 * mg * h);
    }
    CHECK(norm(least) <= norm(any) * (1 + 1e-12));
    CHECK(least.energy_friction == Approx(any.energy_friction).margin(1e-12));
  }
}

TEST_CASE("least reactions of a table that slides have its friction, along each foot's velocity",
          "[reactions]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2");
  CAPTURE(method);
  const Scene s = scene("table");
  const BodyId table{1};
  Both steppers(method);
  State x = s.start;
  s.model.set_velocity(x, table, {1, 0, 0},
                       {0, 0, method == "lcp" ? 0.0 : 1.5});  // a polygon has no ray for each foot
  State y = x;
  const double h = 0.002;
  for (int i = 0; i < 20; ++i) {
    const StepReport any = steppers.any->step(s.model, x, h), least = steppers.least->step(s.model, y, h);
    REQUIRE(least.advanced());
    CHECK(x.q == y.q);
    CHECK(x.nu == y.nu);
    Vector3 force = Vector3::Zero(), force_any = force, moment = force, moment_any = force;
    for (const ContactRow& c : any.contacts) {
      force_any += c.impulse;
      moment_any += c.position.cross(c.impulse);
    }
    for (const ContactRow& c : least.contacts) {
      force += c.impulse;
      moment += c.position.cross(c.impulse);
      const double mu = s.model.contacts()[static_cast<std::size_t>(c.contact)].mu;
      CHECK(c.impulse.head<2>().norm() == Approx(mu * c.p_n).epsilon(1e-6));
      CHECK(c.mode == ContactMode::Slip);
    }
    CHECK((force - force_any).norm() < 1e-10 * force.norm());
    CHECK((moment - moment_any).norm() < 1e-10 * force.norm());
    CHECK(norm(least) <= norm(any) * (1 + 1e-12));
    if (method == "lcp") {  // straight on: its weight moves forwards by mu height/length, alike on both sides
      CHECK(least.contact("front-right").p_n == Approx(least.contact("back-right").p_n));
      CHECK(least.contact("front-left").p_n == Approx(least.contact("back-left").p_n));
      CHECK(least.contact("front-right").p_n == Approx(9.81 * h / 4 * (1 + 0.5 * 0.5 / 0.4)));
    }
  }
}

TEST_CASE("two hinges in line share a door's weight alike in the least reactions", "[reactions][joint]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2");
  CAPTURE(method);
  Model model;
  const BodyId door = model.add_body(Inertia::solid_box(20, {0.8, 0.04, 2}), {.pose = {.p = {0.4, 0, 0}}});
  model.add_joint(revolute(ground, door, {.point = {0, 0, -0.6}, .name = "lower"}));
  model.add_joint(revolute(ground, door, {.point = {0, 0, 0.6}, .name = "upper"}));
  Both steppers(method);
  State x = model.rest();
  model.set_velocity(x, door, {0, 0.8, 0}, {0, 0, 2});
  State y = x;
  const double h = 0.01;
  for (int i = 0; i < 10; ++i) {
    const StepReport any = steppers.any->step(model, x, h), least = steppers.least->step(model, y, h);
    REQUIRE(least.advanced());
    CHECK(x.q == y.q);
    const JointImpulse lower = least.joint("lower"), upper = least.joint("upper");
    CHECK(lower.impulse.z() == Approx(upper.impulse.z()));
    CHECK(lower.impulse.z() == Approx(0.5 * 20 * 9.81 * h));
    CHECK((lower.moment - upper.moment).norm() < 1e-9);
    CHECK((lower.impulse + upper.impulse - any.joint("lower").impulse - any.joint("upper").impulse).norm() <
          1e-10);
    CHECK(norm(least) <= norm(any) * (1 + 1e-12));
  }
}
