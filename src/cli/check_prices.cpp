#include "cli/check_prices.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/cpu_time.hpp"

namespace perp {
namespace {

constexpr int steps = 20;              // that are timed
constexpr double most_seconds = 0.05;  // CPU seconds for them
constexpr double share = 1e-3;         // of the scene's T: the step at which is looked

/// Rows of what touches at the start: contacts within reach of a step, joint equations, joint frictions.
struct Rows {
  int contacts = 0, tangents = 0, joints = 0, frictions = 0;
};

Rows rows_at(const Scene& scene, double h) {
  Instant s;
  evaluate(scene.model, scene.start, s);
  Vector gained;
  solve_mass(scene.model, s, s.k, gained);
  const Vector nu = scene.start.nu + h * gained;
  Rows rows{.joints = static_cast<int>(s.joint_rows.size()),
            .frictions = static_cast<int>(s.joint_frictions.size())};
  for (const ContactInstant& c : s.contacts) {
    if (c.psi_n + h * c.velocity(nu).x() > 0) continue;
    ++rows.contacts;
    rows.tangents += c.mu > 0 ? c.tangents : 0;
  }
  return rows;
}

/// The unknowns of a step, in words.
std::string unknowns(const Scene& scene, const Method& method, const Rows& rows, double h) {
  const int impulses = rows.contacts + rows.tangents + rows.joints + rows.frictions;
  if (method.polygonal) {
    LcpStepper stepper({.edges = MethodOptions{}.edges, .anitescu_potra = method.name == "lcp-ap"});
    int count = 0, problems = 0;
    for (const Lcp& lcp : stepper.problems(scene.model, scene.start, h)) {
      count += static_cast<int>(lcp.b.size());
      ++problems;
    }
    return std::to_string(count) + " unknowns in " + std::to_string(problems) + " LCPs";
  }
  const int nv = scene.model.nv();
  const std::string with = std::to_string(nv) + " velocities";
  if (method.adaptive) return with + ", " + std::to_string(impulses) + " rows that may hold";
  if (method.name == "penalty") return with + ", " + std::to_string(rows.joints) + " joint rows";
  return std::to_string(nv + impulses) + " unknowns: " + with + ", " + std::to_string(impulses) + " impulses";
}

std::string price(const Scene& scene, const Method& method, double h) {
  if (method.adaptive && !has_sundials()) return "not built in";
  const auto stepper = method.make({});
  std::size_t taken = 0;
  std::string fault;
  const double begin = thread_cpu_seconds();
  const auto spent = [&] { return thread_cpu_seconds() - begin; };
  SimulateOptions options{.t_end = scene.start.t + steps * h,
                          .progress = [&](double) { return spent() < most_seconds; }};
  if (!method.adaptive) options.h = h;
  try {
    taken = simulate(scene.model, *stepper, scene.start, options).steps();
  } catch (const StepFailure& failure) {
    taken = failure.trajectory.steps();
    fault = failure.report.message;
  }
  char text[64];
  std::snprintf(text, sizeof text, "%.3g us a step", 1e6 * spent() / double(std::max<std::size_t>(1, taken)));
  return fault.empty() ? text : std::string(text) + ", then failed: " + fault;
}

}  // namespace

void print_prices(const Scene& scene) {
  const double h = share * (scene.t_end - scene.start.t);
  const Rows rows = rows_at(scene, h);
  std::printf(
      "a step of h = %s s from the start: %d contact rows, %d friction rows, %d joint rows, %d joint "
      "frictions\n",
      shortest(h).c_str(), rows.contacts, rows.tangents, rows.joints, rows.frictions);
  for (const Method& m : methods())
    if (!m.make({})->knows(scene.model))
      std::printf("price %-12s none: it does not know torsion, rolling and friction axes\n",
                  std::string(m.name).c_str());
    else
      std::printf("price %-12s %s; %s\n", std::string(m.name).c_str(), unknowns(scene, m, rows, h).c_str(),
                  price(scene, m, h).c_str());
}

}  // namespace perp
