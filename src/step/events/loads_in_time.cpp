#include "step/events/loads_in_time.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace perp {
namespace {

void append(std::vector<double>& out, const Vector3& v, double factor) {
  for (const double x : v) out.push_back(factor * x);
}

/// 1/m and 1 over the smallest moment of inertia: the most that a unit of force or moment does to a body.
struct Mobility {
  double linear = 0, angular = 0;
  explicit Mobility(const Body& b) {
    if (b.nv == 0) return;
    if (b.mass > 0) linear = 1 / b.mass;
    if (b.kind == BodyKind::Planar) angular = 1 / b.J(2, 2);
    if (b.kind == BodyKind::Spatial) angular = b.J.inverse().trace();
  }
};

constexpr int nodes = 9;

/// Chebyshev's points of [0, 1], ends included, and the weights of the barycentric formula.
double node(int k) { return 0.5 - 0.5 * std::cos(std::numbers::pi * k / (nodes - 1)); }
double weight(int k) { return (k % 2 == 0 ? 1.0 : -1.0) * (k == 0 || k == nodes - 1 ? 0.5 : 1.0); }

/// How much each node counts at the place s in [0, 1].
std::array<double, nodes> shares(double s) {
  std::array<double, nodes> share{};
  double sum = 0;
  for (int k = 0; k < nodes; ++k) {
    const double d = s - node(k);
    if (std::abs(d) < 1e-14) {
      share.fill(0);
      share[static_cast<std::size_t>(k)] = 1;
      return share;
    }
    share[static_cast<std::size_t>(k)] = weight(k) / d;
    sum += weight(k) / d;
  }
  for (double& x : share) x /= sum;
  return share;
}

}  // namespace

LoadsInTime::LoadsInTime(const Model& model) {
  add_motions(model);
  add_efforts(model);
}

void LoadsInTime::add(Load load) {
  if (load.timing != nullptr)
    for (const auto& value : load.timing->switches) switches_.push_back({value, load.name});
  if (load.timing == nullptr || !load.timing->steady) loads_.push_back(std::move(load));
}

void LoadsInTime::add_motions(const Model& model) {
  for (const Body& b : model.bodies()) {
    if (b.kind != BodyKind::Prescribed) continue;
    const PrescribedMotion& motion = b.motion;
    add({b.name,
         timing_of(motion.twist),
         [&motion](const Model&, const State& x, std::vector<double>& out) {
           const Twist V = motion.twist(x.t);
           append(out, V.v, 1);
           append(out, V.w, 1);
           if (motion.surface) append(out, motion.surface(x.t, motion.pose(x.t).p), 1);
         },
         {0, 0, 0, 1, 1, 1, 0, 0, 0},
         {1, 1, 1, 1, 1, 1, 1, 1, 1}});
  }
  for (const JointGeometry& joint : model.joints())
    for (std::size_t i = 0; i < joint.motions.size(); ++i) {
      if (!joint.motions[i]) continue;
      const JointMotion& motion = *joint.motions[i];
      const bool turns = joint.coordinates[i].freedom == JointFreedom::Rotation;
      add({joint.name,
           timing_of(motion.rate),
           [&motion](const Model&, const State& x, std::vector<double>& out) {
             out.push_back(motion.rate(x.t));
           },
           {static_cast<char>(turns)},
           {1}});
    }
}

void LoadsInTime::add_efforts(const Model& model) {
  for (const BodyForce& force : model.forces()) {
    const Mobility mobility(model.body(force.body));
    add({model.body(force.body).name,
         timing_of(force.wrench),
         [&force, mobility](const Model& m, const State& x, std::vector<double>& out) {
           const Wrench w = force.wrench(m, x);
           append(out, w.force, mobility.linear);
           append(out, w.moment, mobility.angular);
         },
         {0, 0, 0, 1, 1, 1},
         {0, 0, 0, 0, 0, 0}});
  }
  for (const JointMotor& motor : model.motors()) {
    const JointGeometry& joint = model.joint(motor.joint);
    const Mobility a(model.body(joint.a)), b(model.body(joint.b));
    const bool turns =
        joint.coordinates[static_cast<std::size_t>(motor.coordinate)].freedom == JointFreedom::Rotation;
    const double most = turns ? a.angular + b.angular : a.linear + b.linear;
    add({joint.name,
         timing_of(motor.effort),
         [&motor, most](const Model& m, const State& x, std::vector<double>& out) {
           out.push_back(most * motor.effort(m, x, m.coordinate(x, motor.joint, motor.coordinate),
                                             m.coordinate_rate(x, motor.joint, motor.coordinate)));
         },
         {static_cast<char>(turns)},
         {0}});
  }
}

bool LoadsInTime::all_named() const {
  return std::all_of(loads_.begin(), loads_.end(), [](const Load& load) { return load.timing != nullptr; });
}

LoadsInTime::Jump LoadsInTime::next(double t, double until, double look) const {
  Jump soonest;
  for (const Load& load : loads_) {
    if (load.timing == nullptr) continue;
    const double time = load.timing->first(t, std::min(until, soonest.t), look);
    if (time < soonest.t) soonest = {time, load.name};
  }
  return soonest;
}

double LoadsInTime::seen_until(const Model& model, double from, double to, double look, double small,
                               double small_rate, const std::function<State(double t)>& at) const {
  const double h = to - from;
  const int looks = static_cast<int>(std::min(1e6, std::ceil(h / look)));
  if (looks <= 1) return to;
  double seen = to;
  std::vector<std::vector<double>> known(nodes);
  std::vector<double> now;
  for (const Load& load : loads_) {
    for (int k = 0; k < nodes; ++k) {
      known[static_cast<std::size_t>(k)].clear();
      load.value(model, at(from + node(k) * h), known[static_cast<std::size_t>(k)]);
    }
    for (int j = 1; j < looks; ++j) {
      const double s = static_cast<double>(j) / looks;
      if (from + s * h >= seen) break;
      const std::array<double, nodes> share = shares(s);
      now.clear();
      load.value(model, at(from + s * h), now);
      bool strange = false;
      for (std::size_t i = 0; i < now.size() && !strange; ++i) {
        double expected = 0;
        for (std::size_t k = 0; k < known.size(); ++k) expected += share[k] * known[k][i];
        const double change = std::abs(now[i] - expected) * (load.is_rate[i] != 0 ? 1 : h);
        strange = !(change <= (load.turns[i] != 0 ? small_rate : small));
      }
      if (strange) seen = from + static_cast<double>(j - 1) / looks * h;
      if (strange) break;
    }
  }
  return seen;
}

}  // namespace perp
