#include "perp/study/impulse_path.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {

namespace {

/// What acts in a step, as a column: forces of contacts and joints, then moments.
Vector acting(const Model& model, const StepReport& report) {
  const auto contacts = static_cast<Eigen::Index>(model.contact_count());
  const auto joints = static_cast<Eigen::Index>(model.joints().size());
  Vector p = Vector::Zero(6 * contacts + 7 * joints);
  auto force = p.head(3 * (contacts + joints)), moment = p.tail(3 * contacts + 4 * joints);
  for (const ContactRow& row : report.contacts) {
    force.segment<3>(3 * row.contact) += row.impulse;
    moment.segment<3>(3 * row.contact) += row.position.cross(row.impulse);
  }
  for (const JointImpulse& joint : report.joints) {
    if (joint.coordinate <= 0) {  // the equations' impulse stands in the row of every coordinate
      force.segment<3>(3 * (contacts + joint.joint)) += joint.impulse;
      moment.segment<3>(3 * contacts + 4 * joint.joint) += joint.moment;
    }
    moment[3 * contacts + 4 * joint.joint + 3] += joint.friction;
  }
  return p;
}

}  // namespace

ImpulsePath impulse_path(const Model& model, const Trajectory& run) {
  constexpr int most_contacts = 100'000;  // columns of a run's every step
  if (model.contact_count() > most_contacts)
    refuse("impulse_path", "model", std::to_string(model.contact_count()) + " contacts and pairs of shapes",
           "needs to have " + std::to_string(most_contacts) + " at most");
  ImpulsePath path;
  path.t.push_back(run.t(0));
  Vector sum = Vector::Zero(static_cast<Eigen::Index>(6 * static_cast<std::size_t>(model.contact_count()) +
                                                      7 * model.joints().size()));
  std::vector<Vector> sums{sum};
  for (std::size_t i = 0; i < run.steps(); ++i) {
    sum += acting(model, run.report(i));
    const double t = run.t(i + 1);
    if (t > path.t.back()) {
      path.t.push_back(t);
      sums.push_back(sum);
    } else {
      sums.back() = sum;
    }
  }
  const auto n = static_cast<Eigen::Index>(path.t.size());
  const auto forces = static_cast<Eigen::Index>(
      3 * (static_cast<std::size_t>(model.contact_count()) + model.joints().size()));
  path.forces.resize(forces, n);
  path.moments.resize(sum.size() - forces, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    path.forces.col(i) = sums[static_cast<std::size_t>(i)].head(forces);
    path.moments.col(i) = sums[static_cast<std::size_t>(i)].tail(sum.size() - forces);
  }
  return path;
}

double impulse_error(const ImpulsePath& run, const ImpulsePath& reference, double length) {
  if (run.forces.rows() != reference.forces.rows() || run.moments.rows() != reference.moments.rows())
    refuse("impulse_error", "run", static_cast<double>(run.forces.rows()),
           "needs the reference's contacts and joints");
  if (!(length > 0)) refuse("impulse_error", "length", length, "needs to be positive [m]");
  double largest = 0;
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    const auto above = std::upper_bound(reference.t.begin(), reference.t.end(), run.t[i]);
    const auto high = std::min<std::ptrdiff_t>(above - reference.t.begin(), std::ssize(reference.t) - 1);
    const auto low = std::max<std::ptrdiff_t>(high - 1, 0);
    const double t0 = reference.t[static_cast<std::size_t>(low)],
                 t1 = reference.t[static_cast<std::size_t>(high)];
    const double share = t1 > t0 ? std::clamp((run.t[i] - t0) / (t1 - t0), 0.0, 1.0) : 1;
    const auto difference = [&](const Matrix& a, const Matrix& b) {
      if (a.rows() == 0) return 0.0;
      const Vector there = (1 - share) * b.col(low) + share * b.col(high);
      return (a.col(static_cast<Eigen::Index>(i)) - there).lpNorm<Eigen::Infinity>();
    };
    const double f = difference(run.forces, reference.forces);
    const double m = difference(run.moments, reference.moments) / length;
    if (!(std::max(f, m) <= largest)) largest = std::max(f, m);
    if (std::isnan(f) || std::isnan(m)) return not_set;
  }
  return largest;
}

}  // namespace perp
