// The same scene in other units: lengths, masses, and times by the square root of lengths, so that gravity stays what it is.
#include <algorithm>
#include <cmath>

#include "run_files.hpp"
#include "trial.hpp"

namespace checker {
namespace {

void scale_gap(Contact& c, double length) {
  for (auto& [key, numbers] : c.size)
    if (key != "normal" && key != "axis")
      for (double& x : numbers) x *= length;
  c.place_a.p *= length;
  c.place_b.p *= length;
}

/// Moments go by force times length, of what turns; forces of what slides.
double effort_scale(const Scene& scene, int joint, const std::string& coordinate, double length, double mass,
                    bool& turns) {
  const std::string& kind = scene.joints[at(joint)].kind;
  const std::string name = coordinate.empty() ? coordinate_names(kind)[0] : coordinate;
  turns = name.starts_with("angle");
  return turns ? mass * length : mass;
}

}  // namespace

RandomScene scaled(const RandomScene& random, double length, double mass) {
  RandomScene r = random;
  Scene& s = r.scene;
  const double time = std::sqrt(length), speed = length / time;
  s.motors.clear();  // expressions have units of their own
  s.forces.clear();
  r.h *= time;
  for (Body& b : s.bodies) {
    b.mass *= mass;
    for (double& x : b.size)
      x *= b.shape == "moments" || b.kind == Kind::Planar ? mass * length * length : length;
    for (Place* place : {&b.rest, &b.start}) place->p *= length;
    b.v *= speed;
    b.w /= time;
    if (b.motion.kind == "shaker") b.motion.vector *= length;
    if (b.motion.kind == "belt") b.motion.vector *= speed;
    b.motion.rate /= time;
  }
  for (Joint& j : s.joints) {
    j.point *= length;
    j.point_b *= length;
    j.lead *= length;
    j.friction *= j.kind == "prismatic" ? mass : mass * length;
  }
  bool turns = false;
  for (Limit& l : s.limits) {
    (void)effort_scale(s, l.joint, l.coordinate, length, mass, turns);
    if (!turns) l.lower *= length, l.upper *= length;
  }
  for (JointSpring& k : s.joint_springs) {
    const double effort = effort_scale(s, k.joint, k.coordinate, length, mass, turns);
    k.stiffness *= turns ? effort : effort / length;
    k.damping *= turns ? effort * time : effort / speed;
    if (!turns) k.rest *= length;
  }
  for (Spring& k : s.springs) {
    k.point_a *= length;
    k.point_b *= length;
    k.stiffness *= mass / length;
    k.damping *= mass / speed;
    k.length *= length;
  }
  for (Contact& c : s.contacts) scale_gap(c, length);
  return r;
}

std::string units_differ(const RandomScene& random, const std::string& method, double length, double mass,
                         const TrialOptions& options) {
  const auto run = [&](const RandomScene& r, std::string& reason) {
    reason = run_scene(text_of(r.scene), method, r.h, r.until(), options);
    return read_run(r.scene, options.folder + "/out");
  };
  std::string reason, other;
  const RandomScene plain = scaled(random, 1, 1), changed = scaled(random, length, mass);
  const Run a = run(plain, reason), b = run(changed, other);
  if (a.states.size() != b.states.size())
    return "takes " + std::to_string(a.steps.size()) + " steps, scaled " + std::to_string(b.steps.size());
  double size = 0, fastest = 0, worst = 0;
  for (const State& x : a.states)
    for (std::size_t i = 1; i < x.bodies.size(); ++i) {
      size = std::max(size, x.bodies[i].at.p.norm());
      fastest = std::max(fastest, x.bodies[i].v.norm() + random.h * plain.scene.gravity.norm());
    }
  const double time = std::sqrt(length);
  for (std::size_t k = 0; k < a.states.size(); ++k)
    for (std::size_t i = 1; i < a.states[k].bodies.size(); ++i) {
      const BodyState &x = a.states[k].bodies[i], &y = b.states[k].bodies[i];
      worst = std::max(worst, (y.at.p / length - x.at.p).norm() / size);
      worst = std::max(worst, (y.v / (length / time) - x.v).norm() / fastest);
      worst = std::max(worst, 1 - std::abs(y.at.q.dot(x.at.q)));
    }
  return worst <= 1e-9 ? "" : "differs by " + digits(worst);
}

}  // namespace checker
