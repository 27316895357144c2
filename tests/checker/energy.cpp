#include "energy.hpp"

#include <cmath>

namespace checker {
namespace {

/// Work of what is prescribed, on what moves, from the step's impulses and the speeds at its start and end.
double driven_work(const Step& s) {
  double work = 0;
  for (const ContactRow& c : s.contacts) {
    if (c.half != 0) continue;
    const Touch *x = s.touch(s.at_x, c.contact), *y = s.touch(s.at_y, c.contact);
    if (x == nullptr || y == nullptr || c.p.isZero(0)) continue;
    for (const auto& [body, sign] : {std::pair(x->a, -1.0), std::pair(x->b, 1.0)}) {
      const Body& b = s.scene.bodies[at(body)];
      if (b.moves()) continue;
      const auto speed = [&](const State& now, const Touch& t) -> Vector3d {
        const Vector3d surface = surface_velocity(b);
        return t.turns ? now.bodies[at(body)].w
                       : Vector3d(now.bodies[at(body)].velocity_at(t.point) + surface -
                                  t.normal.dot(surface) * t.normal);
      };
      work -= sign * 0.5 * c.p.dot(speed(s.x, *x) + speed(s.y, *y));
    }
  }
  for (std::size_t j = 0; j < s.scene.joints.size(); ++j) {
    const Joint& joint = s.scene.joints[j];
    const JointReport* r = s.joint(j);
    const auto pull = [&](const State& now, const JointState& js) {
      Vector3d force = r->force, moment_b = r->moment, moment_a = r->moment;
      if (joint.kind == "gear")
        moment_a =
            moment_b.dot(js.rows[0].moment_b) / js.rows[0].moment_b.squaredNorm() * js.rows[0].moment_a;
      if (joint.friction > 0) {
        force += r->friction * js.coordinates[0].force;
        moment_b += r->friction * js.coordinates[0].moment_b;
        moment_a += r->friction * js.coordinates[0].moment_a;
      }
      double power = 0;
      for (const auto& [body, sign, moment] :
           {std::tuple(joint.a, -1.0, moment_a), {joint.b, 1.0, moment_b}}) {
        if (s.scene.bodies[at(body)].moves()) continue;
        const BodyState& b = now.bodies[at(body)];
        power -= sign * (force.dot(b.velocity_at(js.anchor)) + moment.dot(b.w));
      }
      for (const Motor& m : s.scene.motors) {  // a prescribed motion pushes along its coordinate
        if (at(m.joint) != j || m.motion.empty()) continue;
        const std::size_t k =
            coordinate_index(s.scene, m.joint, m.coordinate) - first_coordinate(s.scene, m.joint);
        const JointRow& row = js.coordinates[k];
        power += (r->force.dot(row.force) + r->moment.dot(row.moment_b)) *
                 evaluate(m.motion, {{"t", now.t}}).slope;
      }
      return power;
    };
    work += 0.5 * s.h * (pull(s.x, s.joints_x[j]) + pull(s.y, s.joints_y[j]));
  }
  return work;
}

}  // namespace

Gain gain_of(const Step& s) {
  const double before = kinetic_energy(s.scene, s.x), after = kinetic_energy(s.scene, s.y);
  const double potential_x = potential_energy(s.scene, s.x, s.values),
               potential_y = potential_energy(s.scene, s.y, s.values_y);
  const double loads =
      0.5 * s.h * (load_power(s.scene, s.x, s.values) + load_power(s.scene, s.y, s.values_y));
  const double driven = driven_work(s);
  Gain g;
  g.loads = loads;
  g.gain = after - before + potential_y - potential_x - loads - driven;
  g.size = before + std::abs(loads) + std::abs(driven);
  double weights = 0, size = 0;
  for (std::size_t i = 0; i < s.scene.bodies.size(); ++i) {
    const Body& b = s.scene.bodies[i];
    if (!b.moves()) continue;
    const Vector3d weight = b.mass * s.scene.gravity;
    const double noise = 4 * s.place_rounding();  // of speeds that are nothing else
    weights += b.mass * noise * noise + std::abs(weight.dot(s.y.bodies[i].at.p - s.x.bodies[i].at.p)) +
               b.mass * (s.h * s.scene.gravity).squaredNorm();
    size += weight.norm() * s.y.bodies[i].at.p.norm();
  }
  g.rounding = 1e-13 * (size + std::abs(potential_x) + after);
  g.size += weights + 1e-11 * (size + std::abs(potential_x) + after);
  return g;
}

namespace {

Gain gain_of(const Scene& scene, const Run& run, const std::string& method) {
  Gain all;
  std::vector<double> values(first_coordinate(scene, static_cast<int>(scene.joints.size())), 0);
  values = coordinates(scene, run.states[0], values);
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    const Step s(scene, run, i, values, method, {});
    const Gain g = gain_of(s);
    all.gain += g.gain;
    all.size = std::max(all.size, g.size);
    values = s.values_y;
  }
  return all;
}

}  // namespace

void judge_energy(const Scene& scene, const Run& run, const std::string& method, const TrialOptions& options,
                  Trial& trial) {
  constexpr double share = 0.01, falls = 0.6;
  if (method == "event") return;
  std::vector<double> values(first_coordinate(scene, static_cast<int>(scene.joints.size())), 0);
  values = coordinates(scene, run.states[0], values);
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    const Step s(scene, run, i, values, method, {});
    values = s.values_y;
    const Gain first = gain_of(s);
    if (first.gain <= share * first.size) continue;
    TrialOptions inner = options;
    inner.folder += "/finer";
    const RandomScene from = begun_at({scene, s.h, 1}, s.x);
    if (s.x.t > 0 && (!scene.motors.empty() || !scene.forces.empty() || scene.bodies.size() > 1)) {
      bool timed = !scene.motors.empty() || !scene.forces.empty();
      for (const Body& b : scene.bodies) timed = timed || !b.motion.kind.empty();
      if (timed) {  // a file begins at t = 0
        ++trial.undecided;
        continue;
      }
    }
    double gain = first.gain, size = first.size;
    for (int n = 2; n <= 1024 && gain > share * size; n *= 2) {
      if (!run_scene(text_of(from.scene), method, s.h / n, s.h, inner).empty()) {
        ++trial.undecided;
        break;
      }
      const Run finer = read_run(from.scene, inner.folder + "/out");
      const double now = gain_of(from.scene, finer, method).gain;
      if (now > falls * gain) {
        trial.judgement.faults.push_back(
            {i, "energy", "in " + std::to_string(n) + " steps", now, falls * gain});
        break;
      }
      gain = now;
    }
  }
}

}  // namespace checker
