// Whether a linear step's answer passes, and the contacts that its end has and its start has not.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "step/linearized/lcp_workspace.hpp"

namespace perp {
namespace {

/// Metres that a unit of a joint's row is worth.
double length_of(const Model& model, const Instant& s, const JointRowInstant& row) {
  if (!row.world.linear.isZero(0)) return 1;
  Reaction r{.law = Law::Equality, .of = Reaction::Of::JointRow, .W = three_columns(row.W, 0)};
  return metres_per_unit(model, s, r);
}

}  // namespace

/// Null, or the start with the contacts that the end of the trial has, overlapping, and s has not. psi_n is what makes their linear gap
/// that of the end there.
const Instant* LcpStepper::Workspace::add_appeared(const Instant& s, double h) {
  const auto appeared = [&](const ContactInstant& c) {
    return s.contact_of_point[at(c.point)] < 0 && c.psi_n < 0;
  };
  if (std::none_of(end.contacts.begin(), end.contacts.end(), appeared)) return nullptr;
  if (&s != &widened) widened = s;
  for (ContactInstant c : end.contacts) {
    if (!appeared(c)) continue;
    c.psi_n -= h * c.velocity(answer.nu).x();
    widened.contacts.push_back(c);
  }
  auto& all = widened.contacts;
  std::sort(all.begin(), all.end(),
            [](const ContactInstant& a, const ContactInstant& b) { return a.point < b.point; });
  for (std::size_t i = 0; i < all.size(); ++i)
    widened.contact_of_point.set(all[i].point, static_cast<int>(i));
  return &widened;
}

bool LcpStepper::Workspace::takes_part(const Instant& s, const Island& island) const {
  if (struck.empty()) return true;
  if (!island.contacts.empty()) return reaches(s.contacts[at(island.contacts.front())].W);
  if (!island.joint_rows.empty()) return reaches(s.joint_rows[at(island.joint_rows.front())].W);
  return reaches(s.joint_frictions[at(island.joint_frictions.front())].W);
}

/// The bodies of an island become struck.
void LcpStepper::Workspace::strike(const Instant& s, const Island& island) {
  const auto bodies_of = [&](const auto& W) {
    if (W.na > 0) struck[at(W.a)] = 1;
    if (W.nb > 0) struck[at(W.b)] = 1;
  };
  for (const int i : island.contacts) bodies_of(s.contacts[at(i)].W);
  for (const int i : island.joint_rows) bodies_of(s.joint_rows[at(i)].W);
  for (const int i : island.joint_frictions) bodies_of(s.joint_frictions[at(i)].W);
}

/// The first problem's answer into `rebound`, without impulses on struck bodies.
void LcpStepper::Workspace::keep_unstruck(const Model& model, const Instant& s) {
  rebound.impulse = answer.impulse;
  rebound.speed_scale = answer.speed_scale;
  for (std::size_t i = 0; i < struck.size(); ++i)
    if (const Body& b = model.bodies()[i]; struck[i] != 0) rebound.impulse.segment(b.v0, b.nv).setZero();
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    if (reaches(s.contacts[i].W)) continue;
    rebound.p.col(static_cast<int>(i)) = answer.p.col(static_cast<int>(i));
    if (!s.moments.empty())
      rebound.moments.col(static_cast<int>(i)) = answer.moments.col(static_cast<int>(i));
    rebound.slips[i] = answer.slips[i];
    rebound.w[static_cast<int>(i)] = answer.w[static_cast<int>(i)];
  }
  for (int i = 0; i < static_cast<int>(s.joint_rows.size()); ++i)
    if (!reaches(s.joint_rows[at(i)].W)) rebound.reactions[i] = answer.reactions[i];
  for (int i = 0; i < static_cast<int>(s.joint_frictions.size()); ++i)
    if (!reaches(s.joint_frictions[at(i)].W)) rebound.joint_friction[i] = answer.joint_friction[i];
}

/// Whether the residuals of the islands solved last are within their pass marks; report.message says which are not.
bool LcpStepper::Workspace::islands_pass(const LcpStepperOptions& options, const Answer& found,
                                         StepReport& report) {
  const auto says = [&](double residual, double allowed, double speed) {
    if (residual <= allowed) return true;
    report.message = "residual " + shortest(residual) + " m/s is above " + shortest(options.tolerance) +
                     " of the speed " + shortest(speed) + " m/s";
    return false;
  };
  if (options.form == LcpForm::Mixed)
    return says(std::max(found.normal_residual, found.friction_residual),
                options.tolerance * found.speed_scale, found.speed_scale);
  constexpr double differences = 4;  // of velocities, that those at contacts are
  const auto tied = islands.get();
  for (std::size_t i = 0; i < tied.size(); ++i) {
    if (!takes_part(*solved_from, tied[i])) continue;
    IslandProblem& problem = problems[i];
    const StepSpeeds::Mark mark = speeds.of(*solved_from, tied[i], &problem.lengths);
    fastest = std::max(fastest, mark.speed);
    const double residual = problem.residual(tied[i], gap_term);
    double allowed = options.tolerance * mark.speed + mark.rounding;
    if (residual > allowed)
      allowed += std::min(closeness::of_terms * (problem.size_of_terms(tied[i], gap_term) +
                                                 differences * found.nu.lpNorm<Eigen::Infinity>()),
                          closeness::most_rounding * mark.speed);
    if (!says(residual, allowed, mark.speed)) return false;
  }
  return true;
}

/// Whether joints are closed at the end, or hold (28), to the pass mark of the fastest; report.message names those that are not.
bool LcpStepper::Workspace::joints_pass(const Model& model, double h, const LcpStepperOptions& options,
                                        const Answer& found, StepReport& report) {
  const Instant& s = *solved_from;
  if (s.joint_rows.empty()) return true;
  if (options.close_joints && closeness::joint_misfit(model, end) <= 1) return true;
  const double noise = options.tolerance * fastest + 16 * closeness::eps * moved.nu.lpNorm<Eigen::Infinity>();
  const auto tolerance = [&](const JointRowInstant& row) {
    return h * noise / length_of(model, s, row) + closeness::joint_rounding(model, s, row);
  };
  const auto position = [](const JointRowInstant& row) { return std::abs(row.psi_b); };
  const auto equation = [&](const JointRowInstant& row) {
    const auto i = static_cast<Eigen::Index>(&row - s.joint_rows.data());
    return h * std::abs(row.W.velocity(found.nu)[0] + joint_bias[i]);
  };
  const std::string open = options.close_joints ? joints_open(model, end, position, tolerance)
                                                : joints_open(model, s, equation, tolerance);
  if (open.empty()) return true;
  State nearest = moved;
  const std::string quarrel = contradicting_joints(model, nearest);
  report.message = quarrel.empty() ? "joints that do not fit together stay open: " + open
                                   : "joints that contradict each other stay open: " + quarrel;
  return false;
}

}  // namespace perp
