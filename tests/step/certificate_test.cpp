// What a step says of itself: each part of its equations and each of its energies, from the step's own data.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/perp.hpp"
#include "step/certificate/certificate.hpp"
#include "step/events/row_quadrature.hpp"

using namespace perp;

TEST_CASE("each half of an ncp2 step has its own normal, and in its axes the impulse lies in the cone",
          "[certificate]") {
  const Scene scene = perp::scene("rolling-ellipse");
  Ncp2Stepper stepper;
  State x = scene.start;
  int closed = 0, turned = 0;
  for (int k = 0; k < 40; ++k) {
    const StepReport report = stepper.step(scene.model, x, 0.01);
    REQUIRE(report.advanced());
    REQUIRE(report.halves.size() <= 2 * report.contacts.size());
    for (const ContactRow& row : report.contacts) {
      Vector3 sum = Vector3::Zero();
      double p_n = 0;
      for (const ContactRow& half : report.halves) {
        if (half.point != row.point) continue;
        CHECK((half.half == 1 || half.half == 2));
        const double mu = scene.model.contacts()[static_cast<std::size_t>(row.contact)].mu;
        const Vector3 friction = half.impulse - half.p_n * half.normal;
        CHECK(std::abs(friction.dot(half.normal)) <= 1e-14 * half.p_n);
        CHECK(friction.norm() <= mu * half.p_n * (1 + 1e-9));
        if (half.p_n > 0) turned += (half.position - row.position).norm() > 1e-6;
        sum += half.impulse;
        p_n += half.p_n;
      }
      CHECK((sum - row.impulse).norm() <= 1e-15 * (1 + row.impulse.norm()));
      CHECK(p_n == Approx(row.p_n));
      closed += row.p_n > 0;
    }
  }
  CHECK(closed > 30);
  CHECK(turned > 30);  // the halves act at different points
}

namespace {

/// A step that is about to be lied about.
struct Told {
  Model model;
  State x;
  double h = 1e-2;
  int steps_before = 0;
};

/// A ball that slides on a turning table, pulled by a force.
Told ball_on_a_turntable() {
  Told told;
  const BodyId table = told.model.add_prescribed(PrescribedMotion::turntable({0, 0, 1}, 0.7));
  const BodyId ball = told.model.add_body(Inertia::principal(1.3, {0.2, 0.3, 0.4}));
  told.model.add_contact(table, ball, sphere_on_plane(0.5), {.mu = 0.3, .name = "table"});
  told.model.add_force(ball, [](const Model&, const State& x) {
    return Wrench{{0.4, 0.1 * x.t, 0}, {0, 0, 0.2}};
  });
  told.x = told.model.rest();
  told.model.set_position(told.x, ball, {0.8, 0.1, 0.5});
  told.model.set_velocity(told.x, ball, {1, 0.5, 0}, {2, -1, 0.5});
  told.steps_before = 3;
  return told;
}

/// An arm with a stiff hinge and a motor, whose tip slides on the floor.
Told arm_on_the_floor() {
  Told told;
  const BodyId arm =
      told.model.add_body(Inertia::principal(2, {0.1, 0.2, 0.15}), {.pose = {.p = {0.5, 0, 0.1}}});
  const JointId hinge = told.model.add_joint(
      revolute(ground, arm, {.point = {0, 0, 0.1}, .axis = {0, 0, 1}, .friction = 0.3, .name = "hinge"}));
  const BodyId tip = told.model.add_body(Inertia::solid_sphere(0.5, 0.1), {.pose = {.p = {1, 0, 0.1}}});
  told.model.add_joint(ball(arm, tip, {.point = {1, 0, 0.1}, .name = "wrist"}));
  told.model.add_contact(ground, tip, sphere_on_plane(0.1), {.mu = 0.4, .name = "floor"});
  told.model.add_motor(
      {.joint = hinge, .effort = [](const Model&, const State&, double, double) { return 1.5; }});
  told.x = told.model.rest();
  told.model.set_velocity(told.x, tip, {0, 1, 0}, {0, 0, 3});
  told.model.set_velocity(told.x, arm, {0, 0.5, 0}, {0, 0, 1});
  told.steps_before = 3;
  return told;
}

/// The same off the floor, where nothing is redundant.
Told swinging_arm() {
  Told told = arm_on_the_floor();
  Model model;
  const BodyId arm = model.add_body(Inertia::principal(2, {0.1, 0.2, 0.15}), {.pose = {.p = {0.5, 0, 0.1}}});
  const JointId hinge = model.add_joint(
      revolute(ground, arm, {.point = {0, 0, 0.1}, .axis = {0, 1, 0}, .friction = 0.3, .name = "hinge"}));
  const BodyId tip =
      model.add_body(Inertia::principal(0.5, {0.01, 0.02, 0.025}), {.pose = {.p = {1, 0, 0.1}}});
  model.add_joint(ball(arm, tip, {.point = {1, 0, 0.15}, .name = "wrist"}));
  model.add_motor({.joint = hinge, .effort = [](const Model&, const State&, double, double) { return 1.5; }});
  told.x = model.rest();
  model.set_velocity(told.x, arm, {0, 0, -0.5}, {0, 1, 0});
  model.set_velocity(told.x, tip, {0.05, 0, -1}, {0, 1, 0});
  told.model = model;
  return told;
}

/// A ball that hits the floor within the step, with spin.
Told ball_that_bounces() {
  Told told;
  const BodyId ball = told.model.add_body(Inertia::solid_sphere(1, 0.2));
  told.model.add_contact(ground, ball, sphere_on_plane(0.2), {.mu = 0.2, .e = 0.6, .name = "floor"});
  told.x = told.model.rest();
  told.model.set_position(told.x, ball, {0, 0, 0.21});
  told.model.set_velocity(told.x, ball, {2, 1, -3}, {3, 4, 5});
  return told;
}

constexpr double lie = 1e-6;       // of a quantity's own scale
constexpr double noticed = 1e-10;  // of a residual's scale: what methods are solved to

/// The certificate of one step, of its answer or of a disturbed one.
class Witness {
 public:
  Witness(Told told, Stepper& stepper) : told_(std::move(told)) {
    for (int k = 0; k < told_.steps_before; ++k)
      REQUIRE(stepper.step(told_.model, told_.x, told_.h).advanced());
    moved_ = told_.x;
    report_ = stepper.step(told_.model, moved_, told_.h);
    REQUIRE(report_.advanced());
    answer_ = *stepper.answer();
    mass_ = 0;
    for (const Body& b : told_.model.bodies()) mass_ = std::max(mass_, b.mass);
    speed_ = std::max(told_.x.nu.lpNorm<Eigen::Infinity>(), moved_.nu.lpNorm<Eigen::Infinity>());
    energy_ = told_.model.kinetic_energy(told_.x);
    honest_ = certify(moved_, answer_);
  }

  StepReport certify(const State& moved, const StepAnswer& answer) const {
    Instant start, end;
    evaluate(told_.model, told_.x, start);
    evaluate(told_.model, moved, end, answer.scheme == Scheme::Start ? nullptr : &start);
    StepReport report;
    report.h = told_.h;
    report.projection = report_.projection;
    (void)Certificate().certify(told_.model, start, told_.x, told_.model.energy(told_.x), end, moved, answer,
                                report);
    return report;
  }

  /// Whether a part's residual, or what is left of the energy, gives the lie away.
  bool catches(const State& moved, const StepAnswer& answer) const {
    const StepReport told = certify(moved, answer);
    const Residuals &e = told.residuals, &e0 = honest_.residuals;
    const auto rises = [](double now, double before, double scale) {
      return !(now <= 10 * before + noticed * scale);
    };
    return rises(e.newton_euler, e0.newton_euler, mass_ * speed_) || rises(e.kinematic, e0.kinematic, 1) ||
           rises(e.joints, e0.joints, 1) || rises(e.normal, e0.normal, speed_) ||
           rises(e.friction, e0.friction, speed_) ||
           std::abs(told.energy_left - honest_.energy_left) > noticed * energy_;
  }

  const Told& told() const { return told_; }
  const State& moved() const { return moved_; }
  const StepAnswer& answer() const { return answer_; }
  const StepReport& report() const { return report_; }
  const StepReport& honest() const { return honest_; }
  double speed() const { return speed_; }
  double mass() const { return mass_; }
  double energy() const { return energy_; }

 private:
  Told told_;
  State moved_;
  StepAnswer answer_;
  StepReport report_, honest_;
  double mass_ = 0, speed_ = 0, energy_ = 0;
};

int lies_about_the_state(const Witness& witness) {
  int lies = 0;
  const Model& model = witness.told().model;
  for (Eigen::Index i = 0; i < witness.moved().nu.size(); ++i) {
    State moved = witness.moved();
    moved.nu[i] += lie * witness.speed();
    INFO("velocity " << i);
    CHECK(witness.catches(moved, witness.answer()));
    ++lies;
  }
  for (const Body& b : model.bodies())
    for (int i = 0; i < b.nv; ++i) {
      State moved = witness.moved();
      Vector d = Vector::Zero(moved.nu.size());
      d[b.v0 + i] = lie;
      move(model, d, 1, moved.q);
      INFO("position or orientation of " << b.name << " along " << i);
      CHECK(witness.catches(moved, witness.answer()));
      ++lies;
    }
  return lies;
}

int lies_about_impulses(const Witness& witness) {
  int lies = 0;
  for (const bool second : {false, true}) {
    const std::size_t n = (second ? witness.answer().second : witness.answer().first).size();
    for (std::size_t k = 0; k < n; ++k) {
      for (int i = 0; i < 3; ++i) {
        StepAnswer answer = witness.answer();
        Acting& r = (second ? answer.second : answer.first)[k];
        if (i > 0 && r.of != Reaction::Of::Contact) continue;
        r.p[i] += lie * witness.mass() * witness.speed();
        INFO("impulse " << k << " along " << i << " of part " << (second ? 2 : 1));
        CHECK(witness.catches(witness.moved(), answer));
        ++lies;
      }
    }
  }
  return lies;
}

int lies_about_energies(const Witness& witness) {
  int lies = 0;
  const auto balance = [&](const StepReport& r) {
    return r.energy - witness.told().model.energy(witness.told().x) - r.energy_friction - r.energy_impact -
           r.energy_load - r.energy_motor - r.energy_surface - r.energy_overlap - r.energy_left;
  };
  REQUIRE(std::abs(balance(witness.report())) <= 1e-13 * witness.report().energy);
  for (double StepFigures::*column :
       {&StepFigures::energy, &StepFigures::energy_friction, &StepFigures::energy_impact,
        &StepFigures::energy_load, &StepFigures::energy_motor, &StepFigures::energy_surface,
        &StepFigures::energy_overlap}) {
    CHECK(witness.report().*column == Approx(witness.honest().*column).margin(1e-14 * witness.energy()));
    StepReport told = witness.report();
    told.*column += lie * witness.energy();
    CHECK(std::abs(balance(told)) > noticed * witness.energy());
    ++lies;
  }
  return lies;
}

}  // namespace

TEST_CASE("every lie of a millionth about a step is caught", "[certificate]") {
  int lies = 0;
  for (const std::string method : {"lcp", "lcp-ap", "ncp", "ncp-start", "ncp2"}) {
    int of_method = 0;
    for (const auto scene : {ball_on_a_turntable, arm_on_the_floor, ball_that_bounces}) {
      const auto stepper = make_stepper(method, {});
      const Witness witness(scene(), *stepper);
      CAPTURE(method, witness.told().model.bodies().back().name, of_method);
      const Residuals& e = witness.honest().residuals;
      CHECK(e.newton_euler <= 1e-9 * witness.mass() * witness.speed());
      CHECK(e.kinematic <= 1e-14);
      CHECK(std::max(e.normal, e.friction) <= 1e-9 * witness.speed());
      of_method +=
          lies_about_the_state(witness) + lies_about_impulses(witness) + lies_about_energies(witness);
    }
    CHECK(of_method >= 60);
    lies += of_method;
  }
  CHECK(lies >= 300);
}

TEST_CASE("a row of event is tied to the forces between its ends: each lie about its state is caught",
          "[certificate][event_driven]") {
  if (!has_sundials()) {
    WARN("skipped: this perp was built without SUNDIALS");
    return;
  }
  int lies = 0;
  for (const auto scene : {ball_on_a_turntable, swinging_arm}) {
    const Told told = scene();
    EventDriven events({.rtol = 1e-11});
    const Trajectory run = simulate(told.model, events, told.x, {.t_end = told.x.t + 0.05});
    const State a = run.state(run.steps() - 1), b = run.back();
    REQUIRE(run.events.empty());
    for (std::size_t i = 0; i < run.steps(); ++i) {
      const StepFigures& row = run.figures(i);
      const Residuals& e = row.residuals;
      CAPTURE(i, e.newton_euler, e.kinematic, e.joints, e.normal, e.friction, row.energy_left);
      CHECK(e.newton_euler < 3e-9);
      CHECK(e.kinematic < 1e-9);
      CHECK(std::max({e.joints, e.normal, e.friction}) < 1e-9);
      CHECK(e.newton_euler + e.kinematic + e.joints + e.normal + e.friction > 0);
      CHECK(std::abs(row.energy_left) < 1e-9);
      CHECK(std::isnan(row.energy_overlap));
    }
    Instant instant;
    evaluate(told.model, a, instant);
    const Scales scales = scales_of(told.model, a, instant);
    ModeDynamics dynamics(told.model);
    REQUIRE(
        dynamics.begin(a, modes_by_velocity(told.model, a, instant, scales), scales.small_speed()).empty());
    RowQuadrature row;
    REQUIRE(row.integrate(dynamics, a, b, 1e-11));
    CHECK(row.momentum_residual < 1e-8);
    CHECK(row.kinematic_residual < 1e-8);
    for (Eigen::Index i = 0; i < b.nu.size(); ++i) {
      State told_b = b;
      told_b.nu[i] += lie;
      REQUIRE(row.integrate(dynamics, a, told_b, 1e-11));
      CHECK(row.momentum_residual > 1e-8);
      Vector d = Vector::Zero(b.nu.size());
      d[i] = lie;
      told_b = b;
      move(told.model, d, 1, told_b.q);
      REQUIRE(row.integrate(dynamics, a, told_b, 1e-11));
      CHECK(row.kinematic_residual > 1e-7);
      lies += 2;
    }
  }
  CHECK(lies == 36);
}

namespace {

/// What a run leaves unaccounted, its sum over the steps.
double left_over(const std::string& scene_name, const std::string& method, double h, double t_end) {
  const Scene scene = perp::scene(scene_name);
  const auto stepper = make_stepper(method, {});
  const Trajectory run = simulate(scene.model, *stepper, scene.start, {.t_end = t_end, .h = h});
  double left = 0;
  for (std::size_t i = 0; i < run.steps(); ++i) left += run.figures(i).energy_left;
  return left;
}

}  // namespace

TEST_CASE("what a run's energies leave unaccounted falls at the method's order", "[certificate]") {
  struct Claim {
    const char *scene, *method;
    double order, t_end;
  };
  for (const Claim& claim :
       {Claim{"oblique-sphere", "ncp", 1, 0.3}, Claim{"double-pendulum", "lcp", 1, 0.4},
        Claim{"double-pendulum", "ncp", 1, 0.4}, Claim{"double-pendulum", "ncp2", 2, 0.4},
        Claim{"rolling-ellipse", "ncp2", 2, 0.4}, Claim{"spring-block", "ncp2", 2, 0.4}}) {
    const double coarse = left_over(claim.scene, claim.method, claim.t_end / 100, claim.t_end);
    const double fine = left_over(claim.scene, claim.method, claim.t_end / 200, claim.t_end);
    const double order = std::log2(std::abs(coarse / fine));
    CAPTURE(claim.scene, claim.method, coarse, fine, order);
    CHECK(order > claim.order - 0.2);
    CHECK(order < claim.order + 0.2);
  }
}

TEST_CASE("a force on a turntable: works and what the energy gained agree to the method's error",
          "[certificate]") {
  double before = 0;
  for (const double h : {2e-3, 1e-3}) {
    Told told = ball_on_a_turntable();
    Ncp2Stepper stepper;
    double load = 0, surface = 0, friction = 0, left = 0;
    for (int k = 0; k < std::lround(0.2 / h); ++k) {
      const StepReport r = stepper.step(told.model, told.x, h);
      REQUIRE(r.advanced());
      load += r.energy_load;
      surface += r.energy_surface;
      friction += r.energy_friction;
      left += r.energy_left;
      CHECK(r.energy_motor == 0);
      CHECK(r.energy_friction <= 1e-14);
    }
    CAPTURE(h, load, surface, friction, left);
    CHECK(load > 0.05);
    CHECK(std::abs(surface) > 0.05);
    CHECK(friction < -0.1);
    if (before != 0) CHECK(std::abs(before / left) == Approx(4).epsilon(0.15));
    before = left;
  }
}

TEST_CASE("a step too long for a spring, which would gain energy from nothing, does not advance",
          "[certificate]") {
  Model model;  // a gram on a spring far too stiff for the step
  model.set_gravity(Vector3::Zero());
  const BodyId gram = model.add_particle(1e-3);
  model.add_spring({.a = ground, .b = gram, .stiffness = 1e6, .length = 0.1});
  for (const std::string method : {"lcp", "ncp2"}) {
    State x = model.rest();
    model.set_position(x, gram, {0.101, 0, 0});
    const auto stepper = make_stepper(method, {});
    StepReport report;
    for (int k = 0; k < 50; ++k) {
      report = stepper->step(model, x, 1e-3);
      if (!report.advanced()) break;
    }
    CAPTURE(method, report.message);
    CHECK_FALSE(report.advanced());
    CHECK(report.message.find("is too stiff for a step of 0.001 s") != std::string::npos);
    CHECK(model.position(x, gram).x() < 0.2);
  }
}

TEST_CASE("impacts within a step never add energy, however many", "[certificate]") {
  for (const std::string method : {"lcp", "ncp", "ncp2"})
    for (const double h : {4e-3, 1e-3, 2e-4}) {
      Model model;
      model.set_gravity(Vector3::Zero());
      State x;
      std::vector<BodyId> balls;
      for (int i = 0; i < 5; ++i) balls.push_back(model.add_body(Inertia::solid_sphere(1, 0.5)));
      for (std::size_t i = 0; i + 1 < 5; ++i)
        model.add_contact(balls[i], balls[i + 1], sphere_on_sphere(0.5, 0.5), {.e = 1});
      x = model.rest();
      for (int i = 0; i < 5; ++i)
        model.set_position(x, balls[static_cast<std::size_t>(i)], {i == 0 ? 0 : 1.999 + 1.001 * i, 0, 0});
      model.set_velocity(x, balls[0], {5, 0, 0});
      const auto stepper = make_stepper(method, {});
      double most = 0;
      for (int k = 0; k < std::lround(0.9 / h); ++k) {
        const StepReport report = stepper->step(model, x, h);
        CAPTURE(method, h, k, report.message);
        REQUIRE(report.advanced());
        most = std::max(most, report.energy);
      }
      CAPTURE(method, h, most);
      CHECK(most <= 12.5 * (1 + 1e-12));
    }
}
