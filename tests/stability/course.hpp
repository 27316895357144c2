// A run watched step by step: what got worst on the way.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "perp/step/methods.hpp"
#include "perp/study/scene.hpp"

namespace perp {

struct Course {
  State end;
  int steps = 0;            ///< that advanced
  bool finished = false;    ///< all of them
  double gap_min = 0;       ///< the deepest overlap, <= 0 [m]
  double gap_max = 0;       ///< of points in reach [m]
  double joint_error = 0;   ///< [m, rad]
  double drift = 0;         ///< of any body's position from the start [m]
  double height_drift = 0;  ///< the same along z
  double energy_max = -infinity;
  double friction = 0;  ///< work of friction, as reported [J]
  double left = 0;      ///< and what no work accounts for [J]
  std::map<std::string, int, std::less<>> solvers;

  int stand_ins() const {  ///< steps that Newton's method alone did not solve
    int count = 0;
    for (const auto& [name, times] : solvers)
      if (name != "newton" && name != "none") count += times;
    return count;
  }
};

inline Course course(const Model& model, const State& start, std::string_view method, double T, double h,
                     double max_correction_speed = infinity) {
  Course c;
  c.end = start;
  const std::unique_ptr<Stepper> stepper = make_stepper(method);
  const int n = std::max(1, static_cast<int>(std::lround(T / h)));
  StepReport report;
  for (; c.steps < n; ++c.steps) {
    const double t = T * (c.steps + 1) / n;
    stepper->step(model, c.end, {.h = T / n, .t_end = t, .max_correction_speed = max_correction_speed},
                  report);
    if (!report.advanced()) return c;
    ++c.solvers[std::string(report.solver)];
    c.gap_min = std::min(c.gap_min, report.gap_min);
    for (const ContactRow& row : report.contacts) c.gap_max = std::max(c.gap_max, row.gap);
    c.joint_error = std::max(c.joint_error, report.joint_error);
    c.energy_max = std::max(c.energy_max, report.energy);
    c.friction += report.energy_friction;
    c.left += report.energy_left;
    for (const Body& b : model.bodies()) {
      if (b.nv == 0) continue;
      const Vector3 moved = (c.end.q - start.q).segment<3>(b.q0);
      c.drift = std::max(c.drift, moved.lpNorm<Eigen::Infinity>());
      c.height_drift = std::max(c.height_drift, std::abs(moved.z()));
    }
  }
  c.finished = true;
  return c;
}

inline Course course(const Scene& scene, std::string_view method, double T, double h) {
  return course(scene.model, scene.start, method, T, h);
}

}  // namespace perp
