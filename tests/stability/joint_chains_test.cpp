// Random chains and loops with joint friction and stops: no step fails, no energy comes from nowhere.
#include <catch2/catch.hpp>
#include <random>

#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

struct Mechanism {
  Model model;
  State start;
};

/// Three to five bodies in a row from the ground, by revolute, prismatic, screw, universal and ball joints at random places, half of
/// the mechanisms planar; every third is closed by a rod to the ground. Friction and stops in joints of one freedom.
Mechanism random_mechanism(unsigned seed) {
  std::mt19937 engine(seed);
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const auto vector = [&](double scale) {
    const double x = number(-scale, scale), y = number(-scale, scale), z = number(-scale, scale);
    return Vector3(x, y, z);
  };
  const bool flat = seed % 2 == 0, closed = seed % 3 == 0;
  Mechanism m;
  if (flat) m.model.set_gravity({0, -9.81, 0});
  BodyId last = ground;
  Vector3 at = Vector3::Zero();
  const int bodies = 3 + static_cast<int>(seed % 3);
  for (int i = 0; i < bodies; ++i) {
    Vector3 step = vector(0.3) + Vector3(0.5, 0, 0);
    if (flat) step.z() = 0;
    const BodyOptions options{.pose = {at + 0.5 * step, Quaternion::Identity()}};
    const double mass = number(0.5, 2);
    const BodyId body = flat ? m.model.add_planar_body(mass, mass * step.squaredNorm() / 12, options)
                             : m.model.add_body(Inertia::solid_box(mass, {0.5, 0.1, 0.1}), options);
    JointOptions joint{.point = at, .axis = flat ? Vector3(0, 0, 1) : Vector3(vector(1).normalized())};
    const int kind = static_cast<int>(number(0, 5));
    const bool measured = i == 0 || kind < 3;  // with friction and stops; the first always
    if (measured) joint.friction = number(0.2, 1);
    JointId id;
    if (measured && kind == 1 && i > 0) {
      if (flat) joint.axis = Vector3(number(-1, 1), 1, 0);
      joint.friction *= 4;
      id = m.model.add_joint(prismatic(last, body, joint));
    } else if (measured && kind == 2 && !flat) {
      joint.lead = 0.1;
      id = m.model.add_joint(screw(last, body, joint));
    } else if (measured || flat) {
      id = m.model.add_joint(revolute(last, body, joint));
    } else {
      id = m.model.add_joint(kind == 3 ? universal(last, body, joint) : ball(last, body, joint));
    }
    if (measured)
      m.model.add_limit(id, {.lower = -number(0.05, 0.6), .upper = number(0.05, 0.6), .e = number(0, 0.5)});
    last = body;
    at += step;
  }
  if (closed) {
    Vector3 far = at + Vector3(0.3, 0.4, 0);
    if (flat) far.z() = 0;
    m.model.add_joint(rod(ground, last, {.point = far, .point_b = at}));
  }
  m.start = m.model.rest();
  for (int i = 0; i < m.model.nv(); ++i) m.start.nu[i] = number(-1, 1);
  REQUIRE(project_onto_constraints(m.model, m.start).reached);
  return m;
}

struct Counts {
  int runs = 0, stops = 0, stick_slip = 0, failed = 0, growing = 0;
};

void run(unsigned seed, Counts& counts) {
  const double h = 1e-3;
  const Mechanism m = random_mechanism(seed);
  LcpStepper stepper;
  State x = m.start;
  StepReport report;
  double energy = m.model.energy(x);
  const double scale = m.model.kinetic_energy(x) + 10;  // [J] of the weights' falls
  bool stopped = false, stuck = false, slipped = false;
  ++counts.runs;
  for (int i = 0; i < 1000; ++i) {
    stepper.step(m.model, x, {.h = h}, report);
    if (!report.advanced()) {
      UNSCOPED_INFO("seed " << seed << " at " << x.t << ": " << report.message);
      ++counts.failed;
      return;
    }
    for (const ContactRow& stop : report.contacts) stopped = stopped || stop.p_n > 0;
    for (const JointImpulse& joint : report.joints) {
      if (joint.friction == 0) continue;
      (joint.mode == ContactMode::Stick ? stuck : slipped) = true;
    }
    // a step of first order is off by h^2 times energies and squares of the fastest rates, here some 50 rad/s
    constexpr double rate_squared = 2500;
    const double allowed = 1e-9 * scale + rate_squared * h * h * (scale + m.model.kinetic_energy(x));
    if (report.energy > energy + allowed) {
      UNSCOPED_INFO("seed " << seed << " at " << x.t << ": energy grows by " << report.energy - energy);
      ++counts.growing;
      return;
    }
    energy = report.energy;
  }
  counts.stops += stopped ? 1 : 0;
  counts.stick_slip += stuck && slipped ? 1 : 0;
}

void run_all(unsigned count) {
  Counts counts;
  for (unsigned seed = 0; seed < count; ++seed) run(seed, counts);
  WARN(counts.runs << " mechanisms: " << counts.stops << " hit a stop, " << counts.stick_slip
                   << " stuck and slipped in a joint");
  CHECK(counts.failed == 0);
  CHECK(counts.growing == 0);
  CHECK(2 * counts.stops >= counts.runs);
  CHECK(2 * counts.stick_slip >= counts.runs);
}

}  // namespace

TEST_CASE("no step of 25 random mechanisms with joint friction and stops fails or gains energy", "[joint]") {
  run_all(25);
}

TEST_CASE("no step of 500 random mechanisms with joint friction and stops fails or gains energy",
          "[joint][slow]") {
  run_all(500);
}
