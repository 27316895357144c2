// All parts of a judgement, step by step, and those that are the same for every method.
#include "judge.hpp"

#include <cmath>
#include <set>

namespace checker {
namespace {

bool finite(const State& x) {
  for (const BodyState& b : x.bodies)
    if (!b.at.p.allFinite() || !b.at.q.coeffs().allFinite() || !b.v.allFinite() || !b.w.allFinite())
      return false;
  return true;
}

void need_numbers(Step& s) {
  const auto bad = [&](const std::string& of) { s.faults.push_back({s.index, "not-a-number", of, 1, 0}); };
  for (const ContactRow& c : s.contacts)
    if (!c.p.allFinite() || !std::isfinite(c.p_n) || !c.normal.allFinite()) bad(c.contact);
  for (const JointReport& j : s.joint_rows)
    if (s.h > 0 && (!j.force.allFinite() || !j.moment.allFinite() || !std::isfinite(j.friction)))
      bad(j.joint);
  for (const char* column : {"energy", "energy_friction", "energy_impact"})
    if (!std::isfinite(s.row.of.at(column))) bad(column);
}

}  // namespace

std::size_t Judgement::wrong_steps() const {
  std::set<std::size_t> wrong;
  for (const Fault& f : faults) wrong.insert(f.step);
  return wrong.size();
}

/// The energy in report.csv is that of the state; the energies of a step add up; gaps and joints are what it says.
void judge_numbers(Step& s) {
  need_numbers(s);
  const double kinetic = kinetic_energy(s.scene, s.y), potential = potential_energy(s.scene, s.y, s.values_y);
  double size = kinetic + std::abs(potential);
  for (std::size_t i = 0; i < s.scene.bodies.size(); ++i)
    size += s.scene.bodies[i].mass * s.scene.gravity.norm() * s.y.bodies[i].at.p.norm();
  s.fault("says-energy", "", std::abs(kinetic + potential - s.row.of.at("energy")), 1e-11 * size);
  if (s.row.of.contains("energy_left") && s.row.of.contains("energy_load")) {
    const double before = kinetic_energy(s.scene, s.x) + potential_energy(s.scene, s.x, s.values);
    double parts = 0, parts_size = size;
    for (const char* part : {"energy_load", "energy_motor", "energy_surface", "energy_overlap",
                             "energy_friction", "energy_impact", "energy_left"}) {
      const double value = s.row.of.at(part);
      if (std::isnan(value)) continue;
      parts += value;
      parts_size = std::max(parts_size, std::abs(value));
    }
    s.fault("says-energies", "", std::abs(kinetic + potential - before - parts), 1e-9 * parts_size);
  }

  double gap = std::numeric_limits<double>::infinity();
  for (const Touch& c : s.at_y)
    if (!c.turns) gap = std::min(gap, c.gap);
  bool only_lengths = true;
  for (const Touch& c : s.at_y) only_lengths = only_lengths && !c.turns;
  const double rounding = s.h > 0 ? s.h * s.place_rounding() : 0;
  if (only_lengths && std::isfinite(gap) && s.h > 0)
    s.fault("says-gap_min", "", std::abs(gap - s.row.of.at("gap_min")), rounding + 1e-9 * std::abs(gap));
}

/// Joints are as closed as report.csv says, and as the step's speeds ask; coordinates are what joints.csv says.
void judge_joints(Step& s) {
  double worst = 0;
  for (std::size_t j = 0; j < s.scene.joints.size(); ++j) {
    const Joint& joint = s.scene.joints[j];
    const double speed = std::max(s.speed_of(joint.a), s.speed_of(joint.b));
    for (const JointRow& row : s.joints_y[j].rows) {
      worst = std::max(worst, std::abs(row.psi));
      if (!(s.h > 0) || s.method == "event") continue;
      double lever = 1;  // an angle counts by how far it moves the joint's anchor, or the body's own size
      if (row.angle) {
        lever = 0;
        for (const int body : {joint.a, joint.b}) {
          const Body& b = s.scene.bodies[at(body)];
          if (b.turns()) lever = std::max(lever, std::sqrt(b.inertia().trace() / b.mass));
        }
      }
      const double before =
          std::abs(s.joints_x[j].rows[static_cast<std::size_t>(&row - s.joints_y[j].rows.data())].psi);
      s.fault("joints", joint.name, std::abs(row.psi) * lever / s.h,
              2 * s.allowed(speed, 0) + s.place_rounding() + 1e-8 * before * lever / s.h +
                  s.marks.rounding * lever / s.h);
    }
    const auto& names = coordinate_names(joint.kind);
    const std::size_t first = first_coordinate(s.scene, static_cast<int>(j));
    for (const JointReport& r : s.joint_rows)
      for (std::size_t k = 0; k < names.size(); ++k)
        if (r.joint == (names.size() > 1 ? joint.name + "." + names[k] : joint.name)) {
          const JointRow& row = s.joints_y[j].coordinates[k];
          const double size = row.angle ? 1 : s.y.bodies[at(joint.b)].at.p.norm() + std::abs(row.psi);
          s.fault("coordinate", r.joint, std::abs(s.values_y[first + k] - r.coordinate),
                  1e-9 * size + 1e-6 * worst);
        }
  }
  const double said = s.row.of.at("joint_error");
  double size = 1;
  for (const BodyState& b : s.y.bodies) size = std::max(size, b.at.p.norm());
  if (!s.scene.joints.empty()) s.fault("says-joint_error", "", worst, 2 * said + s.marks.rounding * size);
}

Judgement judge(const Scene& scene, const Run& run, const std::string& method, double event_tolerance,
                const Marks& marks) {
  Judgement judgement;
  std::size_t count = 0;
  for (const Joint& j : scene.joints) count += coordinate_names(j.kind).size();
  std::vector<double> values(count, 0);
  if (!run.states.empty() && finite(run.states[0])) values = coordinates(scene, run.states[0], values);
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    if (!finite(run.states[i + 1])) {
      judgement.faults.push_back({i, "not-a-number", "state", 1, 0});
      judgement.steps += 1;
      break;
    }
    Step s(scene, run, i, values, method, marks);
    judge_numbers(s);
    judge_joints(s);
    if (method == "event") {
      judge_event(s, run, event_tolerance);
    } else {
      if (method == "ncp2")
        judge_halves(s);
      else
        judge_balance(s);
      judge_contacts(s);
    }
    judgement.faults.insert(judgement.faults.end(), s.faults.begin(), s.faults.end());
    judgement.steps += 1;
    judgement.loaded += s.has_loaded ? 1 : 0;
    judgement.sliding += s.has_sliding ? 1 : 0;
    judgement.impacts += s.has_impact ? 1 : 0;
    values = s.values_y;
  }
  return judgement;
}

}  // namespace checker
